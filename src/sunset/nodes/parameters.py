"""ROS parameters bound to attributes: declared in the class body, validated, read like attributes."""

import math
import sys
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field
from typing import Any, Final, Generic, Protocol, Self, TypeVar, overload

from sunset.system import FAULT_ACCESS, NAMESPACE, current_system, is_topic_name, short_name
from sunset_ros.exceptions import NameValidationException
from sunset_ros.interfaces.rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from sunset_ros.texts import suggestion

ValueT = TypeVar("ValueT", bound=bool | int | float | str)


class _Host(Protocol):
    """The part of a node that a parameter needs."""

    parameter_values: dict[str, Any]

    def get_name(self) -> str: ...
    def resolve_topic_name(self, topic: str) -> str: ...
    def call_later(self, delay: float, function: Callable[[], None]) -> None: ...
    def write_parameter(self, name: str, value: bool | float | str) -> None: ...


@dataclass(eq=False)
class NodeParameter(Generic[ValueT]):
    """A parameter of an adaptive node; read as an attribute, it is the present value.

    Example:
        In the body of a node's class::

            depth_degradation = NodeParameter(0.0, "noise in metres", minimum=0.0, maximum=100.0)

    Args:
        default: the value without an override; its type is the parameter's.
        description: with its unit, for `ros2 param describe`.
        minimum: least allowed number; None for no limit.
        maximum: greatest allowed number; None for no limit.
        read_only: whether it can be set at the start only.
    """

    default: ValueT
    description: str
    _: KW_ONLY
    minimum: float | None = None
    maximum: float | None = None
    read_only: bool = False
    name: str = field(default="", init=False)

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, node: None, owner: type) -> Self: ...
    @overload
    def __get__(self, node: _Host, owner: type) -> ValueT: ...
    def __get__(self, node: _Host | None, owner: type) -> Self | ValueT:
        """Return the present value or, on the class, the parameter itself."""
        if node is None:
            return self
        value: ValueT = node.parameter_values[self.name]
        return value

    def __set__(self, node: _Host, value: ValueT) -> None:
        """Refuse an assignment, which would send no event to other nodes."""
        raise AttributeError(f"Set the parameter {self.name} with set_parameters, not by assignment.")

    def descriptor(self) -> ParameterDescriptor:
        """Return the parameter's descriptor for ROS."""
        descriptor = ParameterDescriptor(
            name=self.name, description=self.description, read_only=self.read_only
        )
        if self.minimum is None and self.maximum is None:
            return descriptor
        if isinstance(self.default, int):
            low = -(2**63) if self.minimum is None else int(self.minimum)
            high = 2**63 - 1 if self.maximum is None else int(self.maximum)
            descriptor.integer_range = [IntegerRange(from_value=low, to_value=high)]
        else:
            least = -sys.float_info.max if self.minimum is None else self.minimum
            greatest = sys.float_info.max if self.maximum is None else self.maximum
            descriptor.floating_point_range = [FloatingPointRange(from_value=least, to_value=greatest)]
        return descriptor

    def refusal(self, node: _Host, value: object) -> str:
        """Return the reason why the node refuses a value, or an empty text."""
        del node
        if isinstance(value, float) and not math.isfinite(value):
            return f"{self.name} must be a finite number, got {value}."
        return ""

    def after_set(self, node: _Host, value: ValueT) -> None:
        """React to a new value, which is the node's value already."""


@dataclass(eq=False)
class FaultParameter(NodeParameter[ValueT]):
    """A parameter that injects an internal fault; its default is the value without the fault.

    Only the cure ends a fault: setting the parameter back is refused. The experiment, in which faults grow and heal,
    gives itself access first.

    Args:
        default: the value without the fault.
        description: of the fault.
        minimum: least allowed number.
        maximum: greatest allowed number.
        ends_with: the action of the node that ends the fault, for the refusal's reason; empty if there is none.
        cured_by_restart: whether activating the node ends it.
    """

    ends_with: str = field(default="", kw_only=True)
    cured_by_restart: bool = field(default=False, kw_only=True)

    def refusal(self, node: _Host, value: object) -> str:
        """Refuse to end a present fault."""
        present = node.parameter_values[self.name]
        if present not in (self.default, value) and not node.parameter_values.get(FAULT_ACCESS):
            cures = self.ends_with, "a restart" if self.cured_by_restart else "", "a redeploy"
            cure = " or ".join(filter(None, cures))
            return f"{self.name} is {present} and ends only with {cure} of {node.get_name()}."
        return super().refusal(node, value)


class TopicParameter(NodeParameter[str]):
    """A parameter that names a topic; relative names are in the managed system's namespace."""

    def refusal(self, node: _Host, value: object) -> str:
        """Refuse other texts than topics and, in the managed system, topics on which none of its nodes publishes."""
        if not is_topic_name(str(value)):
            return f"{self.name} must be a topic's name such as {self.default}, got {value!r}."
        try:
            topic = node.resolve_topic_name(str(value))
        except NameValidationException as error:
            return str(error)
        system = current_system()
        if (
            node.get_name() in system.nodes
            and topic.startswith(f"{NAMESPACE}/")
            and topic not in system.publishers
        ):
            names = [short_name(publisher) for publisher in system.publishers]
            return (
                f"{self.name} must be a topic that a managed node publishes on: {suggestion(str(value), names)}choose "
                f"among {', '.join(names)}, got {value!r}."
            )
        return super().refusal(node, value)


class Action(NodeParameter[bool]):
    """A method that is a parameter: setting it to true calls the method, and it becomes false again.

    Example:
        The method's name is the parameter's, its docstring the description::

            @action
            def perform_autofocus(self) -> None:
                "Focus the lens."
    """

    def __init__(self, function: Callable[..., None]) -> None:
        super().__init__(False, (function.__doc__ or "").strip().split("\n", 1)[0])
        self.function = function

    def after_set(self, node: _Host, value: bool) -> None:
        """Call the method, and set the parameter back after the present call, so that observers see both values."""
        if value:
            self.function(node)
            node.call_later(0.0, lambda: node.write_parameter(self.name, value=False))


action: Final = Action


def bound_parameters(node_class: type) -> dict[str, NodeParameter[Any]]:
    """Return the parameters of a class and its bases, by name, bases first."""
    owners = reversed(node_class.__mro__)
    values = (item for owner in owners for item in vars(owner).items())
    return {name: value for name, value in values if isinstance(value, NodeParameter)}
