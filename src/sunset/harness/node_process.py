"""Nodes as processes of their own, on a live middleware: in each process, and seen from the system's process."""

import os
import signal
import socket
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from typing import IO, Any, Final

import msgspec

from sunset.errors import InvalidInputError, ManagerError, SunsetError, complaint
from sunset.harness.deployment import deployed_parameters
from sunset.processes.process import Process
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

_GRACE_S: Final = 3.0
"""How long nodes may take to leave the graph when they are ended."""
_TURN_S: Final = 0.1
"""Longest wait for a process before the next is ended: ending all at once would take the processor from others."""
_SIGNALS: Final = {number.value: number.name for number in signal.Signals}  # real-time signals lack names


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
    confined: Mapping[str, object] | None = None
    """Likewise within walls, as a `ManagerSpec` in JSON."""
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
            from sunset.harness.confined_manager import run_confined  # noqa: PLC0415  no other node needs it
            from sunset.harness.manager_process import ManagerSpec  # noqa: PLC0415  likewise

            manager = msgspec.convert(spec.confined, ManagerSpec)
            return run_confined(manager, context, occasion=spec.occasion)
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
        return 2  # as the command line for bad input
    if failure:
        # the last line that the managing system has printed may lack an end
        print(f"\n{failure}", file=sys.stderr)  # noqa: T201  the last line, which the run reads
        return MANAGER_FAILED
    return 0


class NodeProcesses:
    """Runs nodes, each in a process that is forked from a server; a `ProcessHost`.

    All of them end with this process, however it ends. Processes that a node has started end with the node. They have
    the variables of `environment` besides this process's own. `on_line` is called, on other threads, with a node and a
    line that it printed.
    """

    def __init__(
        self,
        specs: Mapping[str, NodeSpec],
        environment: Mapping[str, str],
        on_line: Callable[[str, str], object],
    ) -> None:
        self._specs = specs
        self._environment = environment
        self._on_line = on_line
        self._server: ForkServer = node_server()
        self._running: dict[str, Process] = {}
        self._ended: dict[str, int | None] = {}
        self._lines: dict[str, deque[str]] = {}
        self._readers: dict[str, threading.Thread] = {}
        self.on_exit: Callable[[str], object] = lambda _: None
        """Called with the node, during `poll`, whenever a process has ended."""

    def start(self, node: str) -> None:
        """Start a new process for `node`.

        Raises:
            SunsetError: no process can be started.
        """
        if not self._server.is_running:  # it was killed
            self._server = node_server()
        task = {"spec": asdict(self._specs[node]), "environment": self._environment}
        process = self._server.start(task)
        self._ended.pop(node, None)
        self._running[node] = process
        self._lines[node] = lines = deque[str](maxlen=1)
        reader = threading.Thread(target=self._read, args=(node, process.take_output(), lines), daemon=True)
        self._readers[node] = reader
        reader.start()

    def _read(self, node: str, output: IO[str], lines: deque[str]) -> None:
        with output:
            for line in output:
                lines.append(line.rstrip())
                # a node must not wait because of an error of its reader
                with suppress(Exception, SystemExit):
                    self._on_line(node, line.rstrip())

    @property
    def nodes(self) -> tuple[str, ...]:
        """All nodes, whether they run or not."""
        return tuple(self._specs)

    def is_running(self, node: str) -> bool:
        """Return whether the process of `node` exists."""
        return node in self._running

    def pid(self, node: str) -> int | None:
        """Return the process id of `node`; None without a process."""
        process = self._running.get(node)
        return None if process is None else process.pid

    def kill(self, node: str) -> None:
        """End the process of `node` at once."""
        self._running[node].kill()

    def poll(self) -> None:
        """Note the processes that have ended."""
        for node, process in list(self._running.items()):
            if process.ended:
                self._note_end(node)
                self.on_exit(node)

    def end_of(self, node: str) -> str:
        """Return how the last process of `node` ended, in words; empty while it runs."""
        if node not in self._ended:
            return ""
        code = self._ended[node]
        last_line = self._last_line(node)
        if code == 0:
            return "ended in order"  # its output does not say why
        if code is None:
            return "ended, it is not known how"
        if code < 0:
            return f"ended by signal {-code} ({_SIGNALS.get(-code) or signal.strsignal(-code)})"
        return f"ended with exit code {code}" + (f": {last_line}" if last_line else "")

    def manager_failure(self, node: str) -> str:
        """Return how the confined managing system of `node` failed, in a sentence; empty if it did not."""
        return self._last_line(node) if self._ended.get(node) == MANAGER_FAILED else ""

    def _last_line(self, node: str) -> str:
        """Return the last line that an ended process printed."""
        reader = self._readers.pop(node, None)
        if reader is not None:
            reader.join(timeout=1.0)  # another process may hold the pipe for ever, so this waits only once
        return self._lines[node][-1] if self._lines[node] else ""

    def has_failed(self, node: str) -> bool:
        """Return whether the last process of `node` was seen to end, and not in order."""
        return self._ended.get(node) not in {0, None}

    def close(self) -> None:
        """End all processes, the newest first, and wait until they are gone."""
        limit_s = time.monotonic() + _GRACE_S
        for process in reversed(self._running.values()):
            process.send_signal(signal.SIGTERM)
            process.send_signal(signal.SIGCONT)
            process.join(min(limit_s, time.monotonic() + _TURN_S))
        for process in self._running.values():
            process.join(limit_s)
        for node in list(self._running):
            self._note_end(node)
        self._server.close()

    def _note_end(self, node: str) -> None:
        process = self._running.pop(node)
        process.close()
        self._ended[node] = process.returncode
