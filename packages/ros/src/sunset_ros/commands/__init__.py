"""The commands of `ros2` for computers without ROS: `sunset ros`."""

import argparse
import math
import sys
from collections.abc import Callable
from typing import Any, Final, TypeAlias

from sunset_ros.commands import graph, services
from sunset_ros.commands.session import NotThereError

__all__ = ["EXIT_NOT_THERE", "add_arguments"]

EXIT_NOT_THERE: Final = 1
"""The exit code where a name is not on the graph, or a request is refused."""

_Command: TypeAlias = Callable[[argparse.Namespace], int | None]
_Argument: TypeAlias = Callable[[argparse.ArgumentParser], object]


def _argument(*names: str, **options: Any) -> _Argument:
    """Return a function that adds an argument to a parser."""
    return lambda parser: parser.add_argument(*names, **options)


def _flag(*names: str, text: str) -> _Argument:
    return _argument(*names, action="store_true", help=text)


_NODE: Final = _argument("node", metavar="NODE", help="its full name, such as /managed_subsystem/camera")
_NODE_IF_ANY: Final = _argument("node", nargs="?", metavar="NODE")
_TOPIC: Final = _argument("topic", metavar="TOPIC")
_PARAMETER: Final = _argument("parameter", metavar="PARAMETER")
_VALUE: Final = _argument("value", metavar="VALUE", help="YAML, such as 0.5, true, rgb_camera or '[1, 2]'")
_TRANSITION: Final = _argument(
    "transition", metavar="TRANSITION", help="its label or number, such as deactivate"
)
_NAME: Final = _argument("service", metavar="NAME")
_TYPE: Final = _argument("type", metavar="TYPE", help="such as std_srvs/srv/Trigger")
_FIELDS: Final = _argument(
    "values", nargs="?", default="{}", metavar="YAML", help="fields of the request (default: {})"
)
_TYPES: Final = _flag("-t", "--show-types", text="show the types too")
_VERBOSE: Final = _flag("-v", "--verbose", text="show every publisher and subscription")
_ONCE: Final = _flag("--once", text="print one message and end")
_NO_ARRAYS: Final = _flag("--no-arr", text="print type and length of arrays instead of elements")

_THINGS: Final = {
    "node": "list and describe nodes",
    "topic": "list, describe and listen to topics",
    "param": "list, get and set parameters",
    "lifecycle": "see and change states of nodes",
    "service": "list and call services",
}
_ACTIONS: Final[tuple[tuple[str, _Command, str, list[_Argument]], ...]] = (
    ("node list", graph.node_list, "list the nodes", []),
    ("node info", graph.node_info, "show what a node consists of", [_NODE]),
    ("topic list", graph.topic_list, "list the topics", [_TYPES]),
    ("topic info", graph.topic_info, "show which nodes publish and subscribe", [_TOPIC, _VERBOSE]),
    ("topic hz", graph.topic_hz, "measure how often messages come, until Ctrl-C", [_TOPIC]),
    ("topic echo", graph.topic_echo, "print messages, until Ctrl-C", [_TOPIC, _ONCE, _NO_ARRAYS]),
    ("param list", services.param_list, "list the parameters of a node, or of all", [_NODE_IF_ANY]),
    ("param get", services.param_get, "print a parameter's value", [_NODE, _PARAMETER]),
    ("param set", services.param_set, "set a parameter", [_NODE, _PARAMETER, _VALUE]),
    ("lifecycle nodes", services.lifecycle_nodes, "list the nodes with a lifecycle", []),
    ("lifecycle get", services.lifecycle_get, "print the state of a node, or of all", [_NODE_IF_ANY]),
    ("lifecycle list", services.lifecycle_list, "list the transitions that a node can make now", [_NODE]),
    ("lifecycle set", services.lifecycle_set, "request a transition of a node", [_NODE, _TRANSITION]),
    ("service list", graph.service_list, "list the services", [_TYPES]),
    ("service call", services.service_call, "call a service and print its response", [_NAME, _TYPE, _FIELDS]),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "The commands of 'ros2' for machines without ROS. Exit code 1: a node, topic, parameter or service does "
        "not exist, or a node refused; 2: the command line cannot be used."
    )
    things = parser.add_subparsers(title="things", metavar="THING", required=True)
    actions = {}
    for thing, text in _THINGS.items():
        subparsers = things.add_parser(thing, help=text)
        actions[thing] = subparsers.add_subparsers(title="actions", metavar="ACTION", required=True)
    for words, command, text, arguments in _ACTIONS:
        thing, name = words.split()
        action = actions[thing].add_parser(name, help=text)
        for add in arguments:
            add(action)
        _add_network(action)
        action.set_defaults(execute=_reporting(command), program=action.prog.split()[0])


def _add_network(parser: argparse.ArgumentParser) -> None:
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
