"""The parameters of one node: declarations, checks, callbacks. It knows no network."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from sunset.interfaces.rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from sunset.ros._parameter_checks import refusal
from sunset.ros.exceptions import (
    InvalidParameterException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from sunset.ros.names import validate_parameter_name
from sunset.ros.parameter import Parameter
from sunset.texts import shorten, suggestion

SetCallback = Callable[[list[Parameter]], SetParametersResult]
PostSetCallback = Callable[[list[Parameter]], object]


_LISTS = frozenset(kind.value for kind in Parameter.Type if kind.name.endswith("_ARRAY"))


@dataclass(slots=True)
class Changes:
    """What one set of parameters did."""

    new: list[Parameter] = field(default_factory=list)
    changed: list[Parameter] = field(default_factory=list)
    deleted: list[Parameter] = field(default_factory=list)


class ParameterStore:
    """The parameters of one node.

    Args:
        node: fully qualified name of the node, for errors.
        overrides: values that win over the defaults of declarations.
        allow_undeclared: whether parameters may be set that were not declared.
        on_change: told of every change.

    Attributes:
        set_callbacks: asked, the latest first, before parameters are set.
        post_set_callbacks: told, the latest first, when parameters were set.
    """

    def __init__(
        self,
        node: str,
        overrides: Mapping[str, Parameter],
        *,
        allow_undeclared: bool,
        on_change: Callable[[Changes], object],
    ) -> None:
        self.set_callbacks: list[SetCallback] = []
        self.post_set_callbacks: list[PostSetCallback] = []
        self.overrides = dict(overrides)
        self._node = node
        self._allow_undeclared = allow_undeclared
        self._on_change = on_change
        self._parameters: dict[str, Parameter] = {}
        self._descriptors: dict[str, ParameterDescriptor] = {}

    def names(self) -> list[str]:
        """Return the names of all declared parameters, in order of declaration."""
        return list(self._parameters)

    def has(self, name: str) -> bool:
        """Return whether a parameter is declared."""
        return name in self._parameters

    def declare(
        self, name: str, value: object, descriptor: ParameterDescriptor, *, ignore_override: bool
    ) -> Parameter:
        """Add a parameter.

        Args:
            name: its name.
            value: its default, or its type, or None for one of dynamic type that is not set.
            descriptor: what values it admits.
            ignore_override: whether `value` wins over the command line.

        Raises:
            ParameterAlreadyDeclaredException: it is declared already.
            InvalidParameterException: the name is empty, or neither type nor value is given.
            InvalidParameterTypeException: a parameter cannot hold the value.
            InvalidParameterValueException: the descriptor or a callback refuses the value.
        """
        validate_parameter_name(name)
        if name in self._parameters:
            raise ParameterAlreadyDeclaredException(
                f"Parameter {name!r} of {self._node} is declared already."
            )
        parameter, descriptor = self._described(name, value, descriptor)
        if not ignore_override and name in self.overrides:
            parameter = self.overrides[name]
            if parameter.value == [] and descriptor.type in _LISTS:  # which says nothing about the type
                parameter = Parameter(name, Parameter.Type(descriptor.type), [])
        self._descriptors[name] = descriptor
        reason = self._store([parameter], declaring=True)
        if reason is not None:
            self._parameters.pop(name, None)
            del self._descriptors[name]
            raise InvalidParameterValueException(
                f"Parameter {name!r} of {self._node} cannot be declared with {parameter.value!r}: {reason}"
            )
        return self._parameters[name]

    def _described(
        self, name: str, value: object, descriptor: ParameterDescriptor
    ) -> tuple[Parameter, ParameterDescriptor]:
        """Return a new parameter, and its descriptor with name and type filled in."""
        descriptor = descriptor.copy()
        descriptor.name = name
        if isinstance(value, Parameter.Type):
            descriptor.type = value.value
            parameter = Parameter(name)
        else:
            parameter = Parameter(name, value=value)
            descriptor.type = parameter.type_.value
        if not descriptor.dynamic_typing and descriptor.type == Parameter.Type.NOT_SET:
            raise InvalidParameterException(
                f"Parameter {name!r} of {self._node} needs a default value, a type, or dynamic_typing=True."
            )
        return parameter, descriptor

    def undeclare(self, name: str) -> None:
        """Remove a parameter.

        Raises:
            ParameterNotDeclaredException: it is not declared.
            ParameterImmutableException: it is read-only.
        """
        self.check_declared([name])
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(f"Parameter {name!r} of {self._node} is read-only.")
        del self._parameters[name], self._descriptors[name]

    def get(self, name: str) -> Parameter:
        """Return a parameter.

        Raises:
            ParameterNotDeclaredException: it is not declared.
            ParameterUninitializedException: it has a fixed type and was never set.
        """
        if name not in self._parameters:
            if self._allow_undeclared:
                return Parameter(name)
            self.check_declared([name])
        parameter = self._parameters[name]
        if parameter.type_ is Parameter.Type.NOT_SET and not self._descriptors[name].dynamic_typing:
            raise ParameterUninitializedException(f"Parameter {name!r} of {self._node} was never set.")
        return parameter

    def peek(self, name: str) -> Parameter | None:
        """Return a parameter, set or not; None if it is not declared."""
        return self._parameters.get(name)

    def descriptor(self, name: str) -> ParameterDescriptor:
        """Return what values a parameter admits.

        Raises:
            ParameterNotDeclaredException: it is not declared.
        """
        if name not in self._descriptors:
            if self._allow_undeclared:
                return ParameterDescriptor(name=name, dynamic_typing=True)
            self.check_declared([name])
        return self._descriptors[name].copy()

    def set_descriptor(self, name: str, descriptor: ParameterDescriptor) -> None:
        """Change what values a parameter admits.

        Raises:
            ParameterNotDeclaredException: it is not declared.
            ParameterImmutableException: it is read-only.
            InvalidParameterValueException: its value would not be admitted.
        """
        self.check_declared([name])
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(f"Parameter {name!r} of {self._node} is read-only.")
        descriptor = descriptor.copy()
        descriptor.name = name
        if not descriptor.dynamic_typing:
            descriptor.type = self._parameters[name].type_.value
        reason = refusal(self._parameters[name], descriptor)
        if reason is not None:
            raise InvalidParameterValueException(f"The descriptor does not admit the present value: {reason}")
        self._descriptors[name] = descriptor

    def check_declared(self, names: Iterable[str]) -> None:
        """Refuse names that are not declared.

        Raises:
            ParameterNotDeclaredException: one of them is not.
        """
        missing = [name for name in names if name not in self._parameters]
        if missing and not self._allow_undeclared:
            known = ", ".join(self._parameters) or "none"
            raise ParameterNotDeclaredException(
                f"Parameter {', '.join(map(repr, missing))} of {self._node} is not declared: "
                f"{suggestion(missing[0], self._parameters)}name one of {known}."
            )

    def set_together(self, parameters: list[Parameter]) -> SetParametersResult:
        """Set all of some parameters, or none.

        Raises:
            ParameterNotDeclaredException: one of them is not declared.
        """
        self.check_declared(parameter.name for parameter in parameters)
        reason = self._store(parameters, declaring=False)
        return SetParametersResult(successful=reason is None, reason=shorten(reason or ""))

    def _store(self, parameters: list[Parameter], *, declaring: bool) -> str | None:
        for parameter in parameters:
            descriptor = self.descriptor(parameter.name)
            if descriptor.read_only and not declaring:
                return f"Parameter {parameter.name} is read-only."
            unset = parameter.type_ is Parameter.Type.NOT_SET
            reason = None if declaring and unset else refusal(parameter, descriptor)
            if reason is not None:
                return reason
        for callback in self.set_callbacks:
            result = callback(parameters)
            if not isinstance(result, SetParametersResult):
                raise TypeError(
                    f"A set-parameters callback must return a SetParametersResult, got {result!r}."
                )
            if not result.successful:
                return result.reason or "Refused without a reason."
        self._commit(parameters, declaring=declaring)
        for post_callback in self.post_set_callbacks:
            post_callback(parameters)
        return None

    def _commit(self, parameters: list[Parameter], *, declaring: bool) -> None:
        changes = Changes()
        for parameter in parameters:
            old = self._parameters.get(parameter.name)
            was_set = old is not None and old.type_ is not Parameter.Type.NOT_SET
            is_set = parameter.type_ is not Parameter.Type.NOT_SET
            if is_set:
                (changes.changed if was_set else changes.new).append(parameter)
            elif was_set:
                changes.deleted.append(parameter)
            if is_set or declaring:
                self._descriptors.setdefault(parameter.name, self.descriptor(parameter.name))
                self._parameters[parameter.name] = parameter
            else:  # as in rclpy, to unset a parameter is to undeclare it
                self._parameters.pop(parameter.name, None)
                self._descriptors.pop(parameter.name, None)
        self._on_change(changes)
