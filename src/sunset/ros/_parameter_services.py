"""The six services through which others see and set a node's parameters."""

from collections.abc import Callable, Iterable, Sequence
from typing import TypeVar

from sunset.errors import ParameterError
from sunset.interfaces import Service
from sunset.interfaces.rcl_interfaces.msg import ListParametersResult, SetParametersResult
from sunset.interfaces.rcl_interfaces.msg import Parameter as ParameterMessage
from sunset.interfaces.rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from sunset.ros._parameter_store import ParameterStore
from sunset.ros.parameter import Parameter

_T = TypeVar("_T")

_SEPARATOR = "."


class ParameterServices:
    """Answers for a node's parameters, as rclpy's nodes do.

    A name that is not declared, or has no value to get, empties the whole answer of a query; when set, each is
    refused for itself.
    """

    def __init__(self, store: ParameterStore) -> None:
        self._store = store

    def callbacks(self) -> list[tuple[type[Service], str, Callable[..., object]]]:
        """Return type, name below the node's, and callback of each service."""
        return [
            (DescribeParameters, "describe_parameters", self.describe),
            (GetParameterTypes, "get_parameter_types", self.get_types),
            (GetParameters, "get_parameters", self.get),
            (ListParameters, "list_parameters", self.list_names),
            (SetParameters, "set_parameters", self.set_each),
            (SetParametersAtomically, "set_parameters_atomically", self.set_together),
        ]

    def describe(
        self, request: DescribeParameters.Request, response: DescribeParameters.Response
    ) -> DescribeParameters.Response:
        """Answer with one descriptor a name."""
        response.descriptors = self._each(request.names, self._store.descriptor)
        return response

    def get_types(
        self, request: GetParameterTypes.Request, response: GetParameterTypes.Response
    ) -> GetParameterTypes.Response:
        """Answer with one type a name."""
        types = self._each(request.names, lambda name: self._parameter(name).type_.value)
        return GetParameterTypes.Response(types=types) if types else response

    def get(self, request: GetParameters.Request, response: GetParameters.Response) -> GetParameters.Response:
        """Answer with one value a name."""
        response.values = self._each(request.names, lambda name: self._store.get(name).get_parameter_value())
        return response

    def list_names(
        self, request: ListParameters.Request, response: ListParameters.Response
    ) -> ListParameters.Response:
        """Answer with the names under some prefixes, down to some depth, and their prefixes."""
        response.result = list_names(self._store.names(), request.prefixes, request.depth)
        return response

    def set_each(
        self, request: SetParameters.Request, response: SetParameters.Response
    ) -> SetParameters.Response:
        """Set one after the other; answer with one result each."""
        response.results = [self._set([message]) for message in request.parameters]
        return response

    def set_together(
        self, request: SetParametersAtomically.Request, response: SetParametersAtomically.Response
    ) -> SetParametersAtomically.Response:
        """Set all or none; answer with one result."""
        response.result = self._set(request.parameters)
        return response

    def _set(self, messages: list[ParameterMessage]) -> SetParametersResult:
        try:
            parameters = [Parameter.from_parameter_msg(message) for message in messages]
            self._store.check_declared(parameter.name for parameter in parameters)
        except ParameterError as error:  # the asker's mistake, and the answer says so
            return SetParametersResult(successful=False, reason=str(error))
        return self._store.set_together(parameters)

    def _parameter(self, name: str) -> Parameter:
        return self._store.peek(name) or Parameter(name)

    def _each(self, names: list[str], function: Callable[[str], _T]) -> list[_T]:
        try:
            self._store.check_declared(names)
            return [function(name) for name in names]
        except ParameterError:  # rclpy's nodes answer with nothing at all then
            return []


def list_names(names: Iterable[str], prefixes: Sequence[str], depth: int) -> ListParametersResult:
    """Return those of the names that are under some prefixes, and their own prefixes.

    Args:
        names: of parameters; their parts are separated by full stops.
        prefixes: only names that equal one of these or are below it; all names if empty.
        depth: only names with so many parts at most, not counting the prefix; 0 for no limit.
    """
    listed = [name for name in names if _is_listed(name, prefixes, depth)]
    found = {name.rpartition(_SEPARATOR)[0]: None for name in listed if _SEPARATOR in name}
    return ListParametersResult(names=listed, prefixes=list(found))


def _is_listed(name: str, prefixes: Sequence[str], depth: int) -> bool:
    if not prefixes:
        return depth == 0 or name.count(_SEPARATOR) < depth
    for prefix in prefixes:
        if name == prefix:
            return True
        if name.startswith(f"{prefix}{_SEPARATOR}"):
            rest = name[len(prefix) + 1 :]
            if depth == 0 or rest.count(_SEPARATOR) < depth:
                return True
    return False
