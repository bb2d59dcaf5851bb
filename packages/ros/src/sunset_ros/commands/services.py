"""The verbs `param`, `lifecycle` and `service`."""

import argparse
import sys
from collections.abc import Callable

from sunset_ros._parameter_files import parse_value
from sunset_ros.commands.messages import message_from_yaml, message_to_repr
from sunset_ros.commands.session import NotThereError, Session, absolute, hidden, session
from sunset_ros.interfaces import Service, get_service
from sunset_ros.interfaces.lifecycle_msgs.msg import TransitionDescription
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState, GetAvailableTransitions, GetState
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterValue
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from sunset_ros.parameter import Parameter, parameter_value_to_python
from sunset_ros.qos import qos_profile_parameters
from sunset_ros.rmw.core.port import EndpointKind


def service_call(arguments: argparse.Namespace) -> None:
    """Ask a service, and print the answer."""
    name = absolute(arguments.service)
    service_type = get_service(arguments.type)
    request = message_from_yaml(arguments.values, service_type.Request)
    with session(arguments) as graph:
        print(f"requester: making request: {message_to_repr(request)}\n", flush=True)
        response = graph.ask(service_type, name, request)
    print(f"response:\n{message_to_repr(response)}\n")


# Parameters


def param_list(arguments: argparse.Namespace) -> int:
    """Print the parameters of a node, or of all nodes."""
    return _print_each(arguments, "list_parameters", ListParameters, "{}:\n{}", _parameters)


def param_get(arguments: argparse.Namespace) -> None:
    """Print the value of a parameter."""
    with session(arguments) as graph:
        node = graph.find_node(arguments.node)
        request = GetParameters.Request(names=[arguments.parameter])
        response = graph.ask(GetParameters, f"{node}/get_parameters", request, qos_profile_parameters)
    if not response.values:
        raise NotThereError(f"Parameter not set: {node} has no parameter {arguments.parameter!r}.")
    print(value_text(response.values[0]))


def param_set(arguments: argparse.Namespace) -> None:
    """Set a parameter."""
    value = parse_value(arguments.value, f"value of {arguments.parameter!r}")
    message = Parameter(arguments.parameter, value=value).to_parameter_msg()
    with session(arguments) as graph:
        node = graph.find_node(arguments.node)
        request = SetParameters.Request(parameters=[message])
        response = graph.ask(SetParameters, f"{node}/set_parameters", request, qos_profile_parameters)
    (result,) = response.results
    reason = f": {result.reason}" if result.reason else ""
    if not result.successful:
        raise NotThereError(f"Setting parameter failed{reason}")
    print(f"Set parameter successful{reason}")


def value_text(value: ParameterValue) -> str:
    """Return the value of a parameter as `ros2 param get` prints it.

    >>> value_text(Parameter("modality", value=2).get_parameter_value())
    'Integer value is: 2'
    """
    kind = Parameter.Type(value.type)
    if kind is Parameter.Type.NOT_SET:
        return "Parameter not set."
    element, _, array = kind.name.partition("_")
    name = "Boolean" if element == "BOOL" else element.capitalize()
    return f"{name} {'values are' if array else 'value is'}: {parameter_value_to_python(value)}"


def _parameters(graph: Session, node: str) -> str:
    request = ListParameters.Request()
    response = graph.ask(ListParameters, f"{node}/list_parameters", request, qos_profile_parameters)
    return "\n".join(f"  {name}" for name in sorted(response.result.names))


# Lifecycles


def lifecycle_nodes(arguments: argparse.Namespace) -> None:
    """Print the names of all nodes with a lifecycle."""
    with session(arguments) as graph:
        for node in _nodes_with(graph, "get_state", GetState):
            print(node)


def lifecycle_get(arguments: argparse.Namespace) -> int:
    """Print the state of a node, or of all nodes with a lifecycle."""
    return _print_each(arguments, "get_state", GetState, "{}: {}", _state)


def lifecycle_list(arguments: argparse.Namespace) -> None:
    """Print the transitions that a node can make now."""
    with session(arguments) as graph:
        transitions = _transitions(graph, graph.find_node(arguments.node))
    for each in transitions:
        print(
            f"- {each.transition.label} [{each.transition.id}]\n"
            f"\tStart: {each.start_state.label}\n\tGoal: {each.goal_state.label}"
        )


def lifecycle_set(arguments: argparse.Namespace) -> None:
    """Let a node make a transition, given by its label or number."""
    with session(arguments) as graph:
        node = graph.find_node(arguments.node)
        possible = [each.transition for each in _transitions(graph, node)]
        chosen = [each for each in possible if arguments.transition in {each.label, str(each.id)}]
        if not chosen:
            known = ", ".join(f"{each.label} [{each.id}]" for each in possible) or "none"
            raise NotThereError(
                f"Unknown transition requested: {arguments.transition!r}; available ones are {known}."
            )
        request = ChangeState.Request(transition=chosen[0])
        response = graph.ask(ChangeState, f"{node}/change_state", request)
    if not response.success:
        raise NotThereError("Transitioning failed.")
    print("Transitioning successful")


def _state(graph: Session, node: str) -> str:
    state = graph.ask(GetState, f"{node}/get_state", GetState.Request()).current_state
    return f"{state.label} [{state.id}]"


def _transitions(graph: Session, node: str) -> list[TransitionDescription]:
    request = GetAvailableTransitions.Request()
    response = graph.ask(GetAvailableTransitions, f"{node}/get_available_transitions", request)
    return list(response.available_transitions)


# What they share


def _nodes_with(graph: Session, service: str, kind: type[Service]) -> list[str]:
    """Return the names of all nodes that offer a service below their name."""
    graph.look_around()
    nodes = dict.fromkeys(node for node in graph.nodes() if not hidden(node))
    offered = graph.names_and_types(EndpointKind.SERVICE)
    return [node for node in nodes if kind.__ros_name__ in offered.get(f"{node}/{service}", ())]


def _print_each(
    arguments: argparse.Namespace,
    service: str,
    kind: type[Service],
    line: str,
    describe: Callable[[Session, str], str],
) -> int:
    """Print what a service says of the given node or, if there is none, of each; return the exit code.

    Of all nodes, those that do not answer are reported and skipped.
    """
    code = 0
    with session(arguments) as graph:
        if arguments.node:
            print(describe(graph, graph.find_node(arguments.node)))
            return code
        for node in _nodes_with(graph, service, kind):
            try:
                print(line.format(node, describe(graph, node)))
            except NotThereError as error:
                print(f"{arguments.program}: {error}", file=sys.stderr)
                code = 1
    return code
