"""The part of a node that is about its parameters."""

from collections.abc import Sequence
from typing import Any

from sunset.interfaces.rcl_interfaces.msg import (
    ListParametersResult,
    ParameterDescriptor,
    ParameterValue,
    SetParametersResult,
)
from sunset.ros._parameter_services import list_names
from sunset.ros._parameter_store import ParameterStore, PostSetCallback, SetCallback
from sunset.ros.parameter import Parameter


class NodeParameters:
    """Parameter methods of `Node`, as in rclpy."""

    _parameters: ParameterStore

    def declare_parameter(
        self,
        name: str,
        value: object = None,
        descriptor: ParameterDescriptor | None = None,
        ignore_override: bool = False,
    ) -> Parameter:
        """Add a parameter to this node.

        Args:
            name: its name.
            value: its default, or a `Parameter.Type` if it has none.
            descriptor: describes it and limits its values; its type is that of the default, unless
                `dynamic_typing` is set.
            ignore_override: whether the default wins over the command line.

        Returns:
            The parameter with the value that it has now.

        Raises:
            ParameterAlreadyDeclaredException: it is declared already.
            InvalidParameterException: the name is empty, or it has neither default nor type.
            InvalidParameterTypeException: a parameter cannot hold the default.
            InvalidParameterValueException: descriptor or callbacks refuse the value.
        """
        return self._parameters.declare(
            name, value, descriptor or ParameterDescriptor(), ignore_override=ignore_override
        )

    def declare_parameters(
        self,
        namespace: str,
        parameters: Sequence[tuple[Any, ...]],
        ignore_override: bool = False,
    ) -> list[Parameter]:
        """Add several parameters, each (name), (name, value) or (name, value, descriptor).

        Args:
            namespace: put before each name with a full stop, unless empty.
            parameters: the parameters.
            ignore_override: whether defaults win over the command line.

        Raises:
            TypeError: an entry has another length.
            ParameterError: as `declare_parameter`.
        """
        prefix = f"{namespace}." if namespace else ""
        declared = []
        for entry in parameters:
            if not 1 <= len(entry) <= 3:  # noqa: PLR2004  name, value, descriptor
                raise TypeError(f"A parameter is declared by (name, value, descriptor), got {entry!r}.")
            name, value, descriptor = (*entry, None, None)[:3]
            declared.append(self.declare_parameter(f"{prefix}{name}", value, descriptor, ignore_override))
        return declared

    def undeclare_parameter(self, name: str) -> None:
        """Remove a parameter.

        Raises:
            ParameterNotDeclaredException: it is not declared.
            ParameterImmutableException: it is read-only.
        """
        self._parameters.undeclare(name)

    def has_parameter(self, name: str) -> bool:
        """Return whether a parameter is declared."""
        return self._parameters.has(name)

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter.

        Raises:
            ParameterNotDeclaredException: it is not declared.
            ParameterUninitializedException: it has a fixed type and was never set.
        """
        return self._parameters.get(name)

    def get_parameters(self, names: Sequence[str]) -> list[Parameter]:
        """Return several parameters.

        Raises:
            ParameterNotDeclaredException: one is not declared.
            ParameterUninitializedException: one has a fixed type and was never set.
        """
        return [self._parameters.get(name) for name in names]

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Return a parameter, or the alternative if it is not declared or not set."""
        parameter = self._parameters.peek(name)
        if parameter is None or parameter.type_ is Parameter.Type.NOT_SET:
            return Parameter(name) if alternative_value is None else alternative_value
        return parameter

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Return the parameters under a prefix, by the rest of their names."""
        start = f"{prefix}." if prefix else ""
        return {
            name[len(start) :]: self._parameters.peek(name) or Parameter(name)
            for name in self._parameters.names()
            if name.startswith(start)
        }

    def list_parameters(self, prefixes: Sequence[str], depth: int) -> ListParametersResult:
        """Return the names of parameters under some prefixes.

        Args:
            prefixes: only names that equal one of these or are below it; all names if empty.
            depth: only names with so many parts at most, not counting the prefix; 0 for no limit.
        """
        return list_names(self._parameters.names(), prefixes, depth)

    def get_parameter_type(self, name: str) -> Parameter.Type:
        """Return the type of a parameter's value.

        Raises:
            ParameterNotDeclaredException: it is not declared.
        """
        self._parameters.check_declared([name])
        parameter = self._parameters.peek(name)
        return Parameter.Type.NOT_SET if parameter is None else parameter.type_

    def get_parameter_types(self, names: Sequence[str]) -> list[Parameter.Type]:
        """Return the types of several parameters' values.

        Raises:
            ParameterNotDeclaredException: one is not declared.
        """
        return [self.get_parameter_type(name) for name in names]

    def describe_parameter(self, name: str) -> ParameterDescriptor:
        """Return what values a parameter admits.

        Raises:
            ParameterNotDeclaredException: it is not declared.
        """
        return self._parameters.descriptor(name)

    def describe_parameters(self, names: Sequence[str]) -> list[ParameterDescriptor]:
        """Return what values several parameters admit.

        Raises:
            ParameterNotDeclaredException: one is not declared.
        """
        return [self._parameters.descriptor(name) for name in names]

    def set_descriptor(self, name: str, descriptor: ParameterDescriptor) -> ParameterValue:
        """Change what values a parameter admits, and return its value.

        Raises:
            ParameterNotDeclaredException: it is not declared.
            ParameterImmutableException: it is read-only.
            InvalidParameterValueException: its value would not be admitted.
        """
        self._parameters.set_descriptor(name, descriptor)
        return self._parameters.get(name).get_parameter_value()

    def set_parameters(self, parameter_list: list[Parameter]) -> list[SetParametersResult]:
        """Set parameters one after the other, and return one result each.

        Raises:
            ParameterNotDeclaredException: one is not declared; those before it are set.
        """
        return [self._parameters.set_together([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set all of some parameters, or none.

        Raises:
            ParameterNotDeclaredException: one is not declared.
        """
        return self._parameters.set_together(list(parameter_list))

    def add_on_set_parameters_callback(self, callback: SetCallback) -> None:
        """Ask `callback(parameters)` before parameters are set; it returns whether they may be, and if not, why.

        It must not change anything: another callback may still refuse.
        """
        self._parameters.set_callbacks.insert(0, callback)

    def remove_on_set_parameters_callback(self, callback: SetCallback) -> None:
        """Stop asking a callback.

        Raises:
            ValueError: it was not asked.
        """
        self._parameters.set_callbacks.remove(callback)

    def add_post_set_parameters_callback(self, callback: PostSetCallback) -> None:
        """Tell `callback(parameters)` when parameters were set."""
        self._parameters.post_set_callbacks.insert(0, callback)

    def remove_post_set_parameters_callback(self, callback: PostSetCallback) -> None:
        """Stop telling a callback.

        Raises:
            ValueError: it was not told.
        """
        self._parameters.post_set_callbacks.remove(callback)
