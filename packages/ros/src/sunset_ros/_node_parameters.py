"""Parameters of nodes: declarations, checks, callbacks. It knows no network."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from sunset_ros.exceptions import (
    InvalidParameterException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from sunset_ros.interfaces.rcl_interfaces.msg import (
    ListParametersResult,
    ParameterDescriptor,
    ParameterValue,
    SetParametersResult,
)
from sunset_ros.parameter import Parameter, refusal
from sunset_ros.texts import shorten, suggestion

SetCallback = Callable[[list[Parameter]], SetParametersResult]
PostSetCallback = Callable[[list[Parameter]], object]

_LISTS = frozenset(kind.value for kind in Parameter.Type if kind.name.endswith("_ARRAY"))
_SEPARATOR = "."


@dataclass(slots=True)
class Changes:
    """The changes by a set of parameters."""

    new: list[Parameter] = field(default_factory=list)
    changed: list[Parameter] = field(default_factory=list)
    deleted: list[Parameter] = field(default_factory=list)

    def __bool__(self) -> bool:
        return bool(self.new or self.changed or self.deleted)

    def of(self, is_wanted: Callable[[str], bool]) -> "Changes":
        """Return the changes of parameters whose names a predicate accepts."""
        kinds = (self.new, self.changed, self.deleted)
        return Changes(*([parameter for parameter in kind if is_wanted(parameter.name)] for kind in kinds))


class NodeParameters:
    """Parameter methods of `Node`, as in rclpy.

    Those that take names raise a `ParameterNotDeclaredException` if a parameter is not declared and must be.

    `node` is its fully qualified name, for errors. Overrides win over the defaults of declarations, and `on_change` is
    called with all changes.
    """

    def __init__(
        self,
        node: str,
        overrides: Iterable[Parameter],
        allow_undeclared: bool,
        on_change: Callable[[Changes], object],
    ) -> None:
        self._parameters_of = node
        self._parameter_overrides = {parameter.name: parameter for parameter in overrides}
        self._allow_undeclared_parameters = allow_undeclared
        self._on_parameter_change = on_change
        self._parameters: dict[str, Parameter] = {}
        self._descriptors: dict[str, ParameterDescriptor] = {}
        self._on_set_parameters_callbacks: list[SetCallback] = []  # the latest first
        self._post_set_parameters_callbacks: list[PostSetCallback] = []  # likewise

    def declare_parameter(
        self,
        name: str,
        value: object = None,
        descriptor: ParameterDescriptor | None = None,
        ignore_override: bool = False,
    ) -> Parameter:
        """Add a parameter to this node, and return it with its value.

        Args:
            name: its name.
            value: its default, or a `Parameter.Type` without default.
            descriptor: limits its values; its type is the type of the default, unless `dynamic_typing` is set.
            ignore_override: whether the default wins over the command line.

        Raises:
            ParameterAlreadyDeclaredException: it is declared already.
            InvalidParameterException: the name is empty, or it has neither default nor type.
            InvalidParameterTypeException: a parameter cannot hold the default.
            InvalidParameterValueException: descriptor or callbacks refuse the value.
        """
        if name in self._parameters:
            raise ParameterAlreadyDeclaredException(
                f"Parameter {name!r} of {self._parameters_of} is declared already."
            )
        parameter, descriptor = self._with_descriptor(name, value, descriptor or ParameterDescriptor())
        if not ignore_override and name in self._parameter_overrides:
            parameter = self._parameter_overrides[name]
            if parameter.value == [] and descriptor.type in _LISTS:  # which says nothing about the type
                parameter = Parameter(name, Parameter.Type(descriptor.type), [])
        self._descriptors[name] = descriptor
        reason = self._store_parameters([parameter], declaring=True)
        if reason is not None:
            self._parameters.pop(name, None)
            del self._descriptors[name]
            raise InvalidParameterValueException(
                f"Parameter {name!r} of {self._parameters_of} cannot be declared with {parameter.value!r}: {reason}"
            )
        return self._parameters[name]

    def _declare_overrides(self) -> None:
        for parameter in self._parameter_overrides.values():
            if not self.has_parameter(parameter.name):
                self.declare_parameter(parameter.name, parameter.value)

    def declare_parameters(
        self,
        namespace: str,
        parameters: Sequence[tuple[Any, ...]],
        ignore_override: bool = False,
    ) -> list[Parameter]:
        """Add several parameters, each (name), (name, value) or (name, value, descriptor).

        Unless the namespace is empty, it is put before each name with a full stop.

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
        """Remove a parameter; raise a `ParameterImmutableException` if it is read-only."""
        self._check_parameters_declared([name])
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(f"Parameter {name!r} of {self._parameters_of} is read-only.")
        del self._parameters[name], self._descriptors[name]

    def has_parameter(self, name: str) -> bool:
        """Return whether a parameter is declared."""
        return name in self._parameters

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter; raise a `ParameterUninitializedException` if it has a fixed type and was never set."""
        if name not in self._parameters and self._allow_undeclared_parameters:
            return Parameter(name)
        self._check_parameters_declared([name])
        parameter = self._parameters[name]
        if parameter.type_ is Parameter.Type.NOT_SET and not self._descriptors[name].dynamic_typing:
            raise ParameterUninitializedException(
                f"Parameter {name!r} of {self._parameters_of} was never set."
            )
        return parameter

    def get_parameters(self, names: Sequence[str]) -> list[Parameter]:
        """Return several parameters."""
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Return a parameter, or the alternative if it is not declared or not set."""
        parameter = self._parameters.get(name)
        if parameter is None or parameter.type_ is Parameter.Type.NOT_SET:
            return Parameter(name) if alternative_value is None else alternative_value
        return parameter

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Return the parameters under a prefix, by the rest of their names."""
        start = f"{prefix}." if prefix else ""
        under = [name for name in self._parameters if name.startswith(start)]
        return {name.removeprefix(start): self._parameters[name] for name in under}

    def list_parameters(self, prefixes: Sequence[str], depth: int) -> ListParametersResult:
        """Return the names of parameters that equal a prefix or are below it; all if there are no prefixes.

        They have at most `depth` parts, not counting the prefix; 0 is no limit.
        """
        names = [name for name in self._parameters if _is_listed(name, prefixes, depth)]
        found = {name.rpartition(_SEPARATOR)[0]: None for name in names if _SEPARATOR in name}
        return ListParametersResult(names=names, prefixes=list(found))

    def get_parameter_type(self, name: str) -> Parameter.Type:
        """Return the type of a parameter's value."""
        self._check_parameters_declared([name])
        parameter = self._parameters.get(name)
        return Parameter.Type.NOT_SET if parameter is None else parameter.type_

    def get_parameter_types(self, names: Sequence[str]) -> list[Parameter.Type]:
        """Return the types of several parameters' values."""
        return [self.get_parameter_type(name) for name in names]

    def describe_parameter(self, name: str) -> ParameterDescriptor:
        """Return a parameter's descriptor."""
        if name not in self._descriptors and self._allow_undeclared_parameters:
            return ParameterDescriptor(name=name, dynamic_typing=True)
        if name not in self._descriptors:
            self._check_parameters_declared([name])
        return self._descriptors[name].copy()

    def describe_parameters(self, names: Sequence[str]) -> list[ParameterDescriptor]:
        """Return the descriptors of several parameters."""
        return [self.describe_parameter(name) for name in names]

    def set_descriptor(self, name: str, descriptor: ParameterDescriptor) -> ParameterValue:
        """Change a parameter's descriptor, and return its value.

        Raises:
            ParameterImmutableException: it is read-only.
            InvalidParameterValueException: its value would not be admitted.
        """
        self._check_parameters_declared([name])
        if self._descriptors[name].read_only:
            raise ParameterImmutableException(f"Parameter {name!r} of {self._parameters_of} is read-only.")
        descriptor = descriptor.copy()
        descriptor.name = name
        if not descriptor.dynamic_typing:
            descriptor.type = self._parameters[name].type_.value
        reason = refusal(self._parameters[name], descriptor)
        if reason is not None:
            raise InvalidParameterValueException(f"The descriptor does not admit the present value: {reason}")
        self._descriptors[name] = descriptor
        return self._parameters[name].get_parameter_value()

    def set_parameters(self, parameter_list: list[Parameter]) -> list[SetParametersResult]:
        """Set parameters individually, and return their results."""
        return [self.set_parameters_atomically([parameter]) for parameter in parameter_list]

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set all of some parameters, or none."""
        self._check_parameters_declared(parameter.name for parameter in parameter_list)
        reason = self._store_parameters(list(parameter_list), declaring=False)
        return SetParametersResult(successful=reason is None, reason=shorten(reason or ""))

    def add_on_set_parameters_callback(self, callback: SetCallback) -> None:
        """Ask `callback(parameters)` before parameters are set; it returns whether they may be, and if not, why.

        It must not change anything: another callback may still refuse.
        """
        self._on_set_parameters_callbacks.insert(0, callback)

    def remove_on_set_parameters_callback(self, callback: SetCallback) -> None:
        """Stop asking a callback; raise a `ValueError` if it is not registered."""
        self._on_set_parameters_callbacks.remove(callback)

    def add_post_set_parameters_callback(self, callback: PostSetCallback) -> None:
        """Call `callback(parameters)` when parameters were set."""
        self._post_set_parameters_callbacks.insert(0, callback)

    def remove_post_set_parameters_callback(self, callback: PostSetCallback) -> None:
        """Stop calling a callback; raise a `ValueError` if it is not registered."""
        self._post_set_parameters_callbacks.remove(callback)

    def _with_descriptor(
        self, name: str, value: object, descriptor: ParameterDescriptor
    ) -> tuple[Parameter, ParameterDescriptor]:
        """Return a new parameter, and its descriptor with name and type filled in."""
        if not isinstance(name, str) or not name:
            raise InvalidParameterException(
                f"A parameter's name must be a text that is not empty, got {name!r}."
            )
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
                f"Parameter {name!r} of {self._parameters_of} needs a default value, a type, or dynamic_typing=True."
            )
        return parameter, descriptor

    def _check_parameters_declared(self, names: Iterable[str]) -> None:
        missing = [name for name in names if name not in self._parameters]
        if missing and not self._allow_undeclared_parameters:
            offered = self._offered_parameters()
            known = ", ".join(offered) or "none"
            raise ParameterNotDeclaredException(
                f"Parameter {', '.join(map(repr, missing))} of {self._parameters_of} is not declared: "
                f"{suggestion(missing[0], offered)}name one of {known}."
            )

    def _offered_parameters(self) -> list[str]:
        """Return the names that are suggested for a parameter that is not declared."""
        return list(self._parameters)

    def _store_parameters(self, parameters: list[Parameter], *, declaring: bool) -> str | None:
        for parameter in parameters:
            descriptor = self.describe_parameter(parameter.name)
            if descriptor.read_only and not declaring:
                return f"Parameter {parameter.name} is read-only."
            unset = parameter.type_ is Parameter.Type.NOT_SET
            reason = None if declaring and unset else refusal(parameter, descriptor)
            if reason is not None:
                return reason
        for callback in self._on_set_parameters_callbacks:
            result = callback(parameters)
            if not isinstance(result, SetParametersResult):
                raise TypeError(
                    f"A set-parameters callback must return a SetParametersResult, got {result!r}."
                )
            if not result.successful:
                return result.reason or "Refused without a reason."
        self._commit_parameters(parameters, declaring=declaring)
        for post_callback in self._post_set_parameters_callbacks:
            post_callback(parameters)
        return None

    def _commit_parameters(self, parameters: list[Parameter], *, declaring: bool) -> None:
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
                self._descriptors.setdefault(parameter.name, self.describe_parameter(parameter.name))
                self._parameters[parameter.name] = parameter
            else:  # as in rclpy, to unset a parameter is to undeclare it
                self._parameters.pop(parameter.name, None)
                self._descriptors.pop(parameter.name, None)
        self._on_parameter_change(changes)


def _is_listed(name: str, prefixes: Sequence[str], depth: int) -> bool:
    starts = [f"{prefix}{_SEPARATOR}" for prefix in prefixes] or [""]
    rests = [name.removeprefix(start) for start in starts if name.startswith(start)]
    return name in prefixes or any(depth == 0 or rest.count(_SEPARATOR) < depth for rest in rests)
