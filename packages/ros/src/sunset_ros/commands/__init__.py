"""The commands of `ros2` for computers without ROS: `sunset ros`."""

import argparse
import math
import sys
from collections.abc import Callable
from typing import Final, TypeAlias

from sunset_ros.commands import graph, services, topics
from sunset_ros.commands.session import NotThereError

__all__ = ["EXIT_NOT_THERE", "add_arguments"]

EXIT_NOT_THERE: Final = 1
"""The exit code where a name is not on the graph, or a request is refused."""

_Actions: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"  # noqa: SLF001  it has no other name
_Command: TypeAlias = Callable[[argparse.Namespace], int | None]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "The commands of 'ros2' for machines without ROS. Exit code 1: a node, topic, parameter or service does "
        "not exist, or a node refused; 2: the command line cannot be used."
    )
    things = parser.add_subparsers(title="things", metavar="THING", required=True)
    _add_node(_actions(things, "node", "list and describe nodes"))
    _add_topic(_actions(things, "topic", "list, describe and listen to topics"))
    _add_param(_actions(things, "param", "list, get and set parameters"))
    _add_lifecycle(_actions(things, "lifecycle", "see and change states of nodes"))
    _add_service(_actions(things, "service", "list and call services"))


def _add_node(actions: _Actions) -> None:
    _add(actions, "list", graph.node_list, "list the nodes")
    info = _add(actions, "info", graph.node_info, "show what a node consists of")
    info.add_argument("node", metavar="NODE", help="its full name, such as /managed_subsystem/camera")


def _add_topic(actions: _Actions) -> None:
    _show_types(_add(actions, "list", graph.topic_list, "list the topics"))
    info = _add(
        actions, "info", graph.topic_info, "show which nodes publish on a topic and which subscribe to it"
    )
    info.add_argument("topic", metavar="TOPIC")
    info.add_argument("-v", "--verbose", action="store_true", help="show every publisher and subscription")
    rate = _add(actions, "hz", topics.topic_hz, "measure how often messages come, until Ctrl-C")
    rate.add_argument("topic", metavar="TOPIC")
    rate.add_argument(
        "-w",
        "--window",
        type=_at_least_one,
        default=10_000,
        metavar="N",
        help="average over so many messages (default: 10000)",
    )
    echo = _add(actions, "echo", topics.topic_echo, "print messages, until Ctrl-C")
    echo.add_argument("topic", metavar="TOPIC")
    echo.add_argument("--once", action="store_true", help="print one message and end")
    echo.add_argument(
        "--no-arr", action="store_true", help="print type and length of arrays instead of elements"
    )
    echo.add_argument(
        "-f",
        "--full-length",
        action="store_true",
        help="print all elements of long arrays, and long strings whole",
    )


def _add_param(actions: _Actions) -> None:
    listing = _add(actions, "list", services.param_list, "list the parameters of a node, or of all")
    listing.add_argument("node", nargs="?", metavar="NODE")
    getting = _add(actions, "get", services.param_get, "print a parameter's value")
    setting = _add(actions, "set", services.param_set, "set a parameter")
    for parser in (getting, setting):
        parser.add_argument("node", metavar="NODE")
        parser.add_argument("parameter", metavar="PARAMETER")
    setting.add_argument("value", metavar="VALUE", help="YAML, such as 0.5, true, rgb_camera or '[1, 2]'")


def _add_lifecycle(actions: _Actions) -> None:
    _add(actions, "nodes", services.lifecycle_nodes, "list the nodes with a lifecycle")
    getting = _add(actions, "get", services.lifecycle_get, "print the state of a node, or of all")
    getting.add_argument("node", nargs="?", metavar="NODE")
    listing = _add(actions, "list", services.lifecycle_list, "list the transitions that a node can make now")
    listing.add_argument("node", metavar="NODE")
    setting = _add(actions, "set", services.lifecycle_set, "request a transition of a node")
    setting.add_argument("node", metavar="NODE")
    setting.add_argument("transition", metavar="TRANSITION", help="its label or number, such as deactivate")


def _add_service(actions: _Actions) -> None:
    _show_types(_add(actions, "list", graph.service_list, "list the services"))
    call = _add(actions, "call", services.service_call, "call a service and print its response")
    call.add_argument("service", metavar="NAME")
    call.add_argument("type", metavar="TYPE", help="such as std_srvs/srv/Trigger")
    call.add_argument(
        "values", nargs="?", default="{}", metavar="YAML", help="fields of the request (default: {})"
    )


def _actions(things: _Actions, name: str, text: str) -> _Actions:
    parser = things.add_parser(name, help=text)
    return parser.add_subparsers(title="actions", metavar="ACTION", required=True)


def _show_types(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-t", "--show-types", action="store_true", help="show the types too")


def _add(actions: _Actions, name: str, command: _Command, text: str) -> argparse.ArgumentParser:
    parser = actions.add_parser(name, help=text)
    common = parser.add_argument_group("the network")
    common.add_argument(
        "--domain-id", type=int, metavar="N", help="the domain, 0 to 232 (default: ROS_DOMAIN_ID, else 0)"
    )
    common.add_argument(
        "--network",
        action="store_true",
        help="hear other computers too, and be heard by them (default: this one only)",
    )
    common.add_argument(
        "--timeout",
        type=_seconds,
        default=3.0,
        metavar="S",
        help="seconds within which other nodes must be found (default: 3)",
    )
    parser.set_defaults(execute=_reporting(command), program=parser.prog.split()[0])
    return parser


def _at_least_one(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"expected a whole number of at least 1, got {text!r}")
    return int(text)


def _seconds(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0 <= number < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number of seconds from 0 on, got {text!r}")
    return number


def _reporting(command: _Command) -> _Command:
    """Return a command that writes a `NotThereError` to stderr."""

    def execute(arguments: argparse.Namespace) -> int | None:
        try:
            return command(arguments)
        except NotThereError as error:
            print(f"{arguments.program}: {' '.join(str(error).split()).rstrip('.')}.", file=sys.stderr)
            return EXIT_NOT_THERE

    return execute
