"""`sunset node`: one node as a process of its own, on DDS."""

import argparse
import os
import signal
import sys
import threading
from collections.abc import Callable
from typing import Final

from sunset.errors import InvalidInputError, SunsetError
from sunset.forks import signal_after_parent
from sunset.harness.deployment import deployed_parameters
from sunset.rmw.backends import live_middleware
from sunset.rmw.core.port import CallbackError
from sunset.ros import Context, Node, SingleThreadedExecutor
from sunset.ros.signals import install_signal_handlers
from sunset.system import HARNESS, current_system

__all__ = ["MANAGER", "add_arguments", "add_network_options", "execute"]

MANAGER: Final = "managing_system"
"""The name of a managing system's process."""
_PARTING_S: Final = 2.0
"""How long a node whose parent ended may take to leave the graph."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "Run one node as a process on Cyclone DDS, until it is interrupted or shut down through its "
        "lifecycle. Other ROS 2 nodes on this computer see it like their own. If 'sunset up' or a live run is in the "
        "same domain, it has the parameters of that system's own nodes."
    )
    names = [*current_system().nodes, *(node.name for node in HARNESS.values() if node.node_class), MANAGER]
    parser.add_argument("node", choices=names, metavar="NAME", help=f"one of {', '.join(names)}")
    parser.add_argument(
        "--manager", metavar="SPEC", help=f"which managing system {MANAGER} is: none, baseline, or your own"
    )
    add_network_options(parser)
    parser.add_argument(
        "--end-with-stdin",
        action="store_true",
        help="end when stdin does: with the parent process, if that holds the other end of a pipe",
    )
    parser.add_argument(
        "--ros-args", nargs=argparse.REMAINDER, default=[], help="ROS arguments: -r, -p, --params-file, …"
    )
    parser.set_defaults(execute=execute)


def add_network_options(parser: argparse.ArgumentParser) -> None:
    """Add what says who hears a live system."""
    parser.add_argument(
        "--network", action="store_true", help="be heard beyond this computer, which is the default's limit"
    )
    parser.add_argument(
        "--ros-distro",
        metavar="NAME",
        help="ROS 2 distribution of the other nodes (default: found out from what they announce)",
    )


def execute(arguments: argparse.Namespace) -> int:
    """Run the node."""
    if (arguments.node == MANAGER) != (arguments.manager is not None):
        raise InvalidInputError(
            f"--manager says which managing system {MANAGER} is, and no other node has one."
        )
    factory = _factory(arguments.node, arguments.manager)
    context = Context()
    middleware = live_middleware().join(network=arguments.network, distro=arguments.ros_distro)
    with middleware:
        deployed = deployed_parameters(middleware.domain_id)
        shared = [] if deployed is None else ["--params-file", str(deployed)]
        words = ["--ros-args", *shared, *arguments.ros_args]
        context.init(words, middleware=middleware, log_to_stderr=True)
        install_signal_handlers(context=context)
        if arguments.end_with_stdin:
            _end_with_stdin()
        try:
            node = factory(context)
        except SunsetError:
            if context.ok():
                raise
            return 0  # a signal came before the node was made
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        _spin(executor, node, lasting=arguments.node != MANAGER)
    return 0


def _factory(name: str, manager: str | None) -> Callable[[Context], Node]:
    """Return what makes a node."""
    if manager is not None:
        from sunset.managing import load_manager  # noqa: PLC0415  slow, and no other node needs it

        factory = load_manager(manager)
        return lambda context: factory(context=context)
    node_class: Callable[..., Node] = current_system().node_class(name)
    return lambda context: node_class(context=context)


def _spin(executor: SingleThreadedExecutor, node: Node, *, lasting: bool) -> None:
    """Run callbacks until the context is shut down; where `lasting`, one that raises is logged."""
    while executor.context.ok():
        try:
            executor.spin()
        except CallbackError as error:
            if not lasting:
                raise
            node.get_logger().error(str(error), throttle_duration_sec=10.0)


def _end_with_stdin() -> None:
    """End this process, as by SIGTERM, when no process holds the other end of stdin any more.

    Where the system can, a process that is stopped then goes on, to see it.
    """
    signal_after_parent(signal.SIGCONT)
    threading.Thread(target=_watch_stdin, daemon=True).start()


def _watch_stdin() -> None:
    while os.read(sys.stdin.fileno(), 4096):
        pass
    os.kill(os.getpid(), signal.SIGTERM)
    threading.Event().wait(_PARTING_S)
    os._exit(1)
