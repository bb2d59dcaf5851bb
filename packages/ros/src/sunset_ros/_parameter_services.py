"""The six services through which others see and set a node's parameters."""

from collections.abc import Callable
from typing import TypeVar

from sunset_ros._node_parameters import NodeParameters
from sunset_ros.errors import ParameterError
from sunset_ros.exceptions import InvalidParameterTypeException, ParameterNotDeclaredException
from sunset_ros.interfaces import Message, Service
from sunset_ros.interfaces.rcl_interfaces import srv
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter as ParameterMessage
from sunset_ros.interfaces.rcl_interfaces.msg import SetParametersResult
from sunset_ros.parameter import Parameter

_T = TypeVar("_T")


def parameter_services(node: NodeParameters) -> list[tuple[type[Service], str, Callable[..., Message]]]:
    """Return type, name below the node's, and callback of each service.

    As in rclpy, an undeclared name, or a name without a value, empties the whole answer of a query. When parameters are
    set, each has a result.
    """

    def describe(request: srv.DescribeParameters.Request, _: Message) -> Message:
        return srv.DescribeParameters.Response(descriptors=_each(request.names, node.describe_parameter))

    def get_types(request: srv.GetParameterTypes.Request, _: Message) -> Message:
        types = _each(request.names, lambda name: node.get_parameter_type(name).value)
        return srv.GetParameterTypes.Response(types=types)

    def get(request: srv.GetParameters.Request, _: Message) -> Message:
        parameters = _each(request.names, node.get_parameter)
        return srv.GetParameters.Response(values=[each.get_parameter_value() for each in parameters])

    def list_names(request: srv.ListParameters.Request, _: Message) -> Message:
        return srv.ListParameters.Response(result=node.list_parameters(request.prefixes, request.depth))

    def set_each(request: srv.SetParameters.Request, _: Message) -> Message:
        return srv.SetParameters.Response(results=[_set(node, [message]) for message in request.parameters])

    def set_together(request: srv.SetParametersAtomically.Request, _: Message) -> Message:
        return srv.SetParametersAtomically.Response(result=_set(node, request.parameters))

    return [
        (srv.DescribeParameters, "describe_parameters", describe),
        (srv.GetParameterTypes, "get_parameter_types", get_types),
        (srv.GetParameters, "get_parameters", get),
        (srv.ListParameters, "list_parameters", list_names),
        (srv.SetParameters, "set_parameters", set_each),
        (srv.SetParametersAtomically, "set_parameters_atomically", set_together),
    ]


def _set(node: NodeParameters, messages: list[ParameterMessage]) -> SetParametersResult:
    try:
        return node.set_parameters_atomically([Parameter.from_parameter_msg(each) for each in messages])
    except (
        InvalidParameterTypeException,
        ParameterNotDeclaredException,
    ) as error:  # the asker's mistake, and the answer says so
        return SetParametersResult(successful=False, reason=str(error))


def _each(names: list[str], function: Callable[[str], _T]) -> list[_T]:
    try:
        return [function(name) for name in names]
    except ParameterError:  # rclpy's nodes answer with nothing at all then
        return []
