"""The six services through which others see and set a node's parameters."""

from collections.abc import Callable
from typing import TypeVar

from sunset_ros._node_parameters import NodeParameters
from sunset_ros.errors import ParameterError
from sunset_ros.interfaces import Service
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter as ParameterMessage
from sunset_ros.interfaces.rcl_interfaces.msg import SetParametersResult
from sunset_ros.interfaces.rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from sunset_ros.parameter import Parameter

_T = TypeVar("_T")


class ParameterServices:
    """Serves a node's parameters, as in rclpy.

    An undeclared name, or a name without a value, empties the whole answer of a query. When parameters are set, each
    has a result.
    """

    def __init__(self, node: NodeParameters) -> None:
        self._node = node

    def callbacks(self) -> list[tuple[type[Service], str, Callable[..., object]]]:
        """Return type, name below the node's, and callback of each service."""
        return [
            (DescribeParameters, "describe_parameters", self._describe),
            (GetParameterTypes, "get_parameter_types", self._get_types),
            (GetParameters, "get_parameters", self._get),
            (ListParameters, "list_parameters", self._list),
            (SetParameters, "set_parameters", self._set_each),
            (SetParametersAtomically, "set_parameters_atomically", self._set_together),
        ]

    def _describe(
        self, request: DescribeParameters.Request, response: DescribeParameters.Response
    ) -> DescribeParameters.Response:
        response.descriptors = _each(request.names, self._node.describe_parameter)
        return response

    def _get_types(
        self, request: GetParameterTypes.Request, response: GetParameterTypes.Response
    ) -> GetParameterTypes.Response:
        types = _each(request.names, lambda name: self._node.get_parameter_type(name).value)
        return GetParameterTypes.Response(types=types) if types else response

    def _get(
        self, request: GetParameters.Request, response: GetParameters.Response
    ) -> GetParameters.Response:
        response.values = _each(
            request.names, lambda name: self._node.get_parameter(name).get_parameter_value()
        )
        return response

    def _list(
        self, request: ListParameters.Request, response: ListParameters.Response
    ) -> ListParameters.Response:
        response.result = self._node.list_parameters(request.prefixes, request.depth)
        return response

    def _set_each(
        self, request: SetParameters.Request, response: SetParameters.Response
    ) -> SetParameters.Response:
        response.results = [self._set([message]) for message in request.parameters]
        return response

    def _set_together(
        self, request: SetParametersAtomically.Request, response: SetParametersAtomically.Response
    ) -> SetParametersAtomically.Response:
        response.result = self._set(request.parameters)
        return response

    def _set(self, messages: list[ParameterMessage]) -> SetParametersResult:
        try:
            parameters = [Parameter.from_parameter_msg(message) for message in messages]
            self._node._check_parameters_declared(parameter.name for parameter in parameters)  # noqa: SLF001  part of the node
        except ParameterError as error:  # the asker's mistake, and the answer says so
            return SetParametersResult(successful=False, reason=str(error))
        return self._node.set_parameters_atomically(parameters)


def _each(names: list[str], function: Callable[[str], _T]) -> list[_T]:
    try:
        return [function(name) for name in names]
    except ParameterError:  # rclpy's nodes answer with nothing at all then
        return []
