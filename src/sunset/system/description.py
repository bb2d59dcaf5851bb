"""The values that describe a managed system: nodes, topics, signals, failures, faults, adaptations.

Nothing here is code that does something. Nodes, harness, scenarios, metrics, tests and documentation read it.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any, Literal, TypeAlias

from msgspec import Meta

from sunset.errors import ExtensionError, ScenarioError
from sunset.names import ros_text
from sunset.schemas import check_fields

Value = bool | int | float | str
"""The value of a ROS parameter, as far as faults and adaptations need them."""


@dataclass(frozen=True, slots=True)
class NodeDescription:
    """One managed node.

    Attributes:
        name: its name, without namespace.
        node_class: its class, or where that is, as `module:Class`.
        inputs: the topics that it subscribes to when all is well; relative names are in the managed system's namespace.
        outputs: the topics that it publishes on.
        activation_delay_s: time from its start until it activates itself [s]; negative if it does not.
        compute_s: time that a callback of an input takes in the simulation [s]; 0 for that of any other callback.
    """

    name: str
    node_class: type | str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...] = ()
    activation_delay_s: float = 0.0
    compute_s: float = 0.0

    def __post_init__(self) -> None:
        """Check the types."""
        _check(self, self.name)

    @property
    def initial_state(self) -> str:
        """The lifecycle state that it is in when all is well."""
        return "active" if self.activation_delay_s >= 0 else "inactive"


@dataclass(frozen=True, slots=True)
class Topic:
    """A topic that the monitor watches.

    Attributes:
        name: its name; a relative one is in the managed system's namespace.
        message_type: the type of its messages, such as `sensor_msgs/msg/Image`.
    """

    name: str
    message_type: str = "sensor_msgs/msg/Image"

    def __post_init__(self) -> None:
        """Check the types."""
        _check(self, self.name)


@dataclass(frozen=True, slots=True)
class Signal:
    """A number that a node reports on `/diagnostics`, of which the blackboard has the mean over `WINDOW`.

    Attributes:
        node: the node that reports it.
        key: its name there.
        unit: its unit; empty for a number without one.
        threshold: the mean beyond it is a symptom; None if there is none, or the model's card has it.
        below: whether the symptom is a mean below the threshold, not one above it.
        calibrated: whether the model's card has the threshold.
    """

    node: str
    key: str
    unit: str = ""
    threshold: float | None = None
    below: bool = False
    calibrated: bool = False

    def __post_init__(self) -> None:
        """Check the types."""
        _check(self, self.key)

    @property
    def name(self) -> str:
        """The blackboard's entry with its mean, such as `segmentation_entropy`."""
        return f"{self.node}_{self.key}"

    @property
    def has_threshold(self) -> bool:
        """Whether there is a mean beyond which it is a symptom."""
        return self.calibrated or self.threshold is not None

    @property
    def threshold_name(self) -> str:
        """What its threshold is called in model cards and records, such as `entropy_threshold`."""
        return f"{self.key}_threshold"

    def is_beyond(self, value: float, threshold: float) -> bool:
        """Return whether a value is on the wrong side of a threshold; one that is equal to it is not."""
        return value < threshold if self.below else value > threshold


@dataclass(frozen=True, slots=True)
class Failure:
    """What is observed when something is wrong (paper, section 3.3): a topic has stopped, or a signal is off.

    Attributes:
        name: such as `F1`.
        description: what one sees, in a few words, such as "the camera sends no images".
        symptom: what one sees when it begins.
        gone: what one sees when it is over.
        topic: the topic that has stopped; empty if it is a signal.
        signal: the name of the signal that is beyond its threshold; empty if it is a topic.
    """

    name: str
    description: str
    symptom: str
    gone: str
    topic: str = ""
    signal: str = ""

    def __post_init__(self) -> None:
        """Check the types."""
        _check(self, self.name)


class FaultKind(StrEnum):
    """Where a fault lives, which decides how long it lives."""

    INTERNAL = "internal"
    """In a node: it ends with the node's process at the latest."""
    EXTERNAL = "external"
    """In the world: it outlasts a redeploy, and the pipeline can only work around it."""
    CONFIGURATION = "configuration"
    """In how the nodes are connected: it outlasts a redeploy too."""


class AdaptationKind(StrEnum):
    """What a managing system can do to the managed one."""

    RESTART = "restart"
    """Lifecycle deactivate, then activate."""
    REDEPLOY = "redeploy"
    """The node's process ends and a new one starts."""
    SET_PARAMETER = "set_parameter"
    CHANGE_TOPIC = "change_topic"
    """Set a parameter that names the topic that the node subscribes to."""
    ACTIVATE = "activate"
    DEACTIVATE = "deactivate"

    @property
    def goal_state(self) -> str | None:
        """The lifecycle state that it brings a node into; None where it is for something else."""
        return {AdaptationKind.ACTIVATE: "active", AdaptationKind.DEACTIVATE: "inactive"}.get(self)


KindOfAdaptation: TypeAlias = Annotated[
    AdaptationKind, Meta(description=f"one of {', '.join(AdaptationKind)}")
]


@dataclass(frozen=True, slots=True)
class Adaptation:
    """One adaptation of one node.

    Attributes:
        kind: what is done.
        node: the node's name without namespace.
        parameter: the parameter that is set; empty where none is.
        value: what it is set to; None where none is.
    """

    kind: KindOfAdaptation
    node: str
    parameter: str = ""
    value: Value | None = None

    def __post_init__(self) -> None:
        """Check the types, and take the text of a kind for the kind."""
        _check(self, self.node)
        object.__setattr__(self, "kind", AdaptationKind(self.kind))

    def __str__(self) -> str:
        """Return it in words, such as `set sensor_fusion.modality to 1` or `restart camera`."""
        if self.parameter:
            return f"set {self.node}.{self.parameter} to {ros_text(self.value)}"
        return f"{self.kind} {self.node}"


def restart(node: str) -> Adaptation:
    """Return the restart of a node."""
    return Adaptation(AdaptationKind.RESTART, node)


def redeploy(node: str) -> Adaptation:
    """Return the redeploy of a node."""
    return Adaptation(AdaptationKind.REDEPLOY, node)


Sensor: TypeAlias = Literal["camera", "depth"]
"""Whose images: the node of that sensor."""


@dataclass(frozen=True, slots=True)
class View:
    """A value of the parameter that chooses the sensors which the pipeline works with.

    Attributes:
        setting: the adaptation that sets it.
        sensors: the nodes of these sensors.
        is_conclusive: whether a signal on the good side of its threshold then proves that these images are good.
    """

    setting: Annotated[Adaptation, Meta(description="an Adaptation")]
    sensors: Annotated[
        frozenset[str],
        Meta(min_length=1, description="a set of names of nodes, such as frozenset({'camera'})"),
    ]
    is_conclusive: bool = True

    def __post_init__(self) -> None:
        """Check the types, and take a tuple or list of sensors for the set."""
        _check(self, str(self.setting))
        object.__setattr__(self, "sensors", frozenset(self.sensors))


ImageFunction: TypeAlias = Callable[..., Any] | str
"""What takes an image and a strength and returns an image of the same kind, or where it is, as `module:function`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """What a fault does to the images that the segmentation gets, so that it can be measured without nodes.

    Attributes:
        degrade: what the fault does to an image, at a strength.
        strengths: those that are measured, in the order of their size; that of the suites is added.
        sensor: whose images it degrades: the camera's (H, W, 3) of `uint8`, or the depth camera's (H, W) of `uint16`.
        random: whether the functions' third argument is the generator that they draw random numbers from.
        restore: what the cheapest cure does to the images then, at the same strength; None if they are as without the
            fault after it.
        suite: of a fault whose value is not a number, its strength in the suites, or the fault whose strength it has.
        largest: of such a fault, the greatest strength.
        unit: of the strength.
    """

    degrade: ImageFunction
    strengths: tuple[float, ...]
    sensor: Sensor = "camera"
    random: bool = False
    restore: ImageFunction | None = None
    suite: float | str | None = None
    largest: float = 64.0
    unit: str = "strength"


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """One fault.

    A fault is *cured* when its symptom is gone and the segmentation is as good as before; what its `cures` do not list
    must not cure it.

    Attributes:
        name: its name in scenarios, and for most the parameter that injects it.
        failure: the name of the failure that it shows as first.
        node: the node that it is injected into, without namespace.
        description: what happens, one sentence.
        cures: each entry is a set of adaptations that cure it together; the cheapest first.
        value: the value that injects it, at the strength of the suites.
        kind: where it lives.
        limits: least and greatest allowed value; None where the value is not a number.
        parameter: the parameter that injects it; that of its name if empty.
        healthy: the value of the parameter without the fault; False, 0 or 0.0 if None.
        injection: what is done to inject it at the suite's strength; the parameter is set if empty.
        effect: what it does to images; None if that cannot be measured without nodes.
    """

    name: str
    failure: str
    node: str
    description: str
    cures: Annotated[
        tuple[Annotated[tuple[Adaptation, ...], Meta(min_length=1)], ...],
        Meta(description="a tuple of tuples of adaptations, such as ((RESTART,), (REDEPLOY,))"),
    ]
    value: Value = True
    kind: Annotated[FaultKind, Meta(description="internal, external or configuration")] = FaultKind.INTERNAL
    limits: tuple[float, float] | None = None
    parameter: str = ""
    healthy: Value | None = None
    injection: tuple[Adaptation, ...] = ()
    effect: Effect | None = None

    def __post_init__(self) -> None:
        """Check the types, and put in what is left out."""
        _check(self, self.name)
        object.__setattr__(self, "kind", FaultKind(self.kind))
        parameter = self.parameter or self.name
        step = Adaptation(AdaptationKind.SET_PARAMETER, self.node, parameter, self.value)
        object.__setattr__(self, "parameter", parameter)
        object.__setattr__(self, "injection", self.injection or (step,))
        if self.healthy is None:
            object.__setattr__(self, "healthy", type(self.value)())

    @property
    def cure_texts(self) -> tuple[str, ...]:
        """Its cures in words, the cheapest first."""
        return tuple(" and ".join(str(step) for step in cure) for cure in self.cures)

    @property
    def cured_by(self) -> str:
        """What cures it, in words, such as `restart camera, or redeploy camera`."""
        return ", or ".join(self.cure_texts) or "nothing"

    def is_undone(self, strength: object, amounts: Iterable[object]) -> bool:
        """Return whether nodes that undo it are set to undo enough: at least a third of its strength.

        Such a node has a parameter of the fault's, as the image enhancement has `image_degradation`. What is not a
        number says nothing.

        Args:
            strength: what the fault's parameter is set to, or None.
            amounts: what that parameter of the nodes of a cure is set to, or None where there is none.
        """
        wanted = _number(strength)
        known = [amount for amount in map(_number, amounts) if amount is not None]
        return wanted is None or all(abs(amount) >= abs(wanted) / 3 for amount in known)

    def checked(self, value: Value) -> Value:
        """Return a value that injects it, in the type of the parameter.

        Raises:
            ScenarioError: it does not inject it.
        """
        if self.limits is None:
            if type(value) is not type(self.value) or value != self.value:
                raise ScenarioError(
                    f"The fault {self.name} has no strength: its value must be {_shown(self.value)} or left out, got "
                    f"{_shown(value)}."
                )
            return self.value
        low, high = self.limits
        whole = isinstance(self.value, int)
        if (
            isinstance(value, bool | str)
            or not low <= value <= high
            or (whole and value != int(value))
            or value == self.healthy
        ):
            least = "above" if self.healthy == low else "at least"
            raise ScenarioError(
                f"The value of the fault {self.name} must be a {'whole ' if whole else ''}number {least} {low:g} and "
                f"at most {high:g}, got {_shown(value)}."
            )
        return int(value) if whole else float(value)

    @property
    def redeploy_only(self) -> bool:
        """Whether a redeploy cures it, and nothing cheaper."""
        return bool(self.cures) and self.cures[0][0].kind is AdaptationKind.REDEPLOY


def _shown(value: Value) -> str:
    """Return a value as YAML writes it."""
    return repr(value) if isinstance(value, str) else ros_text(value)


def _check(part: object, name: object) -> None:
    """Check the types of a part's fields, since an extension's author may not check them.

    Raises:
        ExtensionError: one is not as it is annotated.
    """
    try:
        check_fields(part, ExtensionError)
    except ExtensionError as error:
        raise ExtensionError(f"The {type(part).__name__} {name!r} is not usable: {error}") from None


def _number(value: object) -> float | None:
    try:
        return float(str(value))
    except ValueError:
        return None
