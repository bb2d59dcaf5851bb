"""One node as a process of its own, on a live middleware.

`run_forked` runs the node of a `NodeSpec` in a process that a `sunset.processes.server` has forked.
"""

import os
import socket
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import msgspec

from sunset.errors import InvalidInputError, ManagerError, SunsetError, complaint
from sunset.harness.deployment import deployed_parameters
from sunset.processes.server import ForkServer, shared_server
from sunset.system import (
    HARNESS,
    MANAGING_SYSTEM,
    current_system,
    load_extension,
    loaded_extensions,
    system_with,
)
from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.rmw.backends import LIVE, live_middleware
from sunset_ros.rmw.core.port import CallbackError
from sunset_ros.signals import install_signal_handlers

MANAGER_FAILED: Final = 3
"""The exit code of a process whose confined managing system has failed; its last line says how."""

_BAD_INPUT: Final = 2


def node_names() -> list[str]:
    """Return the names of all nodes that can run."""
    return [*_classes(), MANAGING_SYSTEM]


def _classes() -> list[str]:
    return [*current_system().nodes, *(node.name for node in HARNESS.values() if node.node_class)]


@dataclass(frozen=True, kw_only=True)
class NodeSpec:
    """The node that a process runs.

    Raises:
        InvalidInputError: the node does not exist, or a managing system is named for another node.
    """

    node: str
    """One of `node_names`."""
    manager: str | None = None
    """The managing system that `MANAGING_SYSTEM` is, without walls; None for any other node."""
    confined: Mapping[str, Any] | None = None
    """The confined managing system that `MANAGING_SYSTEM` is, as a `ManagerSpec` in JSON; None for any other node."""
    occasion: str = ""
    """The run of a confined managing system, in words."""
    middleware: str = LIVE
    network: bool = False
    """Whether the node is heard beyond this computer."""
    distro: str | None = None
    """The ROS 2 distribution of the other nodes; None to detect it."""
    ros_arguments: Sequence[str] = ()
    """The arguments after `--ros-args`."""
    extensions: Sequence[str] = field(
        default_factory=lambda: tuple(extension.where for extension in loaded_extensions())
    )
    """The extensions of the managed system; by default those that are loaded now."""
    faults: Sequence[str] = ()
    """Faults of the scenario, which may be missing in the catalogue."""

    def __post_init__(self) -> None:
        names = node_names()
        if self.node not in names:
            raise InvalidInputError(f"There is no node {self.node!r}; choose one of {', '.join(names)}.")
        if (self.node == MANAGING_SYSTEM) == (self.manager is None and self.confined is None):
            raise InvalidInputError(
                f"--manager says which managing system {MANAGING_SYSTEM} is, and no other node has one."
            )


def run_node(spec: NodeSpec) -> str:
    """Run a node until its context is shut down: through its lifecycle, or by a signal.

    Returns:
        How a confined managing system has failed, in a sentence; empty if it has not.

    Raises:
        CallbackError: a callback of the managing system raised. Errors of other nodes are logged.
        SunsetError: the network cannot be joined, or the node cannot be made.
    """
    node_class = _node_class(spec) if spec.confined is None else None
    context = Context()
    middleware = live_middleware(spec.middleware).join(network=spec.network, distro=spec.distro)
    with middleware:
        deployed = deployed_parameters(middleware.domain_id)
        shared = [] if deployed is None else ["--params-file", str(deployed)]
        words = ["--ros-args", *shared, *spec.ros_arguments]
        context.init(words, middleware=middleware, log_to_stderr=True)
        install_signal_handlers(context=context)
        if node_class is None:
            return _run_confined(spec, context)
        try:
            node = node_class(context=context)
        except SunsetError:
            if context.ok():
                raise
            return ""  # a signal came before the node was made
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        _spin(executor, node, lasting=spec.node != MANAGING_SYSTEM)
        return ""


def _node_class(spec: NodeSpec) -> Callable[..., Node]:
    if spec.manager is None:
        node_class: Callable[..., Node] = current_system().node_class(spec.node)
        return node_class
    from sunset.managing import load_manager  # noqa: PLC0415  slow, and no other node needs it

    return load_manager(spec.manager)


def _run_confined(spec: NodeSpec, context: Context) -> str:
    from sunset.harness.confined_manager import run_confined  # noqa: PLC0415  no other node needs it
    from sunset.harness.manager_process import ManagerSpec  # noqa: PLC0415  likewise

    return run_confined(msgspec.convert(spec.confined, ManagerSpec), context, occasion=spec.occasion)


def _spin(executor: SingleThreadedExecutor, node: Node, *, lasting: bool) -> None:
    """Run callbacks until the context is shut down; if `lasting`, log their errors."""
    while executor.context.ok():
        try:
            executor.spin()
        except CallbackError as error:
            if not lasting:
                if isinstance(error.__cause__, ManagerError):  # a sentence of its own
                    raise error.__cause__ from error
                raise
            node.get_logger().error(str(error), throttle_duration_sec=10.0)


def node_server() -> ForkServer:
    """Return the server that live nodes are forked from, and start it unless it runs."""
    return shared_server(f"{__name__}:run_forked", f"{__name__}:prepare", clean=False)


def prepare() -> None:
    """Import the modules of all nodes, so that they are loaded in processes that are forked from this one."""
    import setproctitle  # noqa: F401, PLC0415  an optional extra

    import sunset.harness.confined_manager  # noqa: F401, PLC0415  for a managing system

    for name in _classes():
        current_system().node_class(name)
    live_middleware().prepare()


def run_forked(_: socket.socket, task: Mapping[str, Any]) -> None:
    """Run the node of a task in this process, which a server has forked, and exit."""
    os.environ.update(task["environment"])
    sys.exit(_run_specified(task["spec"]))


def _run_specified(fields: Mapping[str, Any]) -> int:
    """Run the node with the fields of a `NodeSpec`; return the exit code."""
    from setproctitle import setproctitle  # noqa: PLC0415  an optional extra

    try:
        for extension in fields["extensions"]:
            load_extension(extension)
        spec = NodeSpec(**fields)
        setproctitle(f"sunset node {spec.node}")
        with system_with(spec.faults):
            failure = run_node(spec)
    except Exception as error:
        sentence = complaint(error)
        if not sentence:
            raise
        print(f"sunset: {sentence}", file=sys.stderr)  # noqa: T201  the last line of a node that could not run
        return _BAD_INPUT
    if failure:
        # the last line that the managing system has printed may lack an end
        print(f"\n{failure}", file=sys.stderr)  # noqa: T201  the last line, which the run reads
        return MANAGER_FAILED
    return 0
