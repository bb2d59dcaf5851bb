"""The values that describe a managed system: nodes, topics, signals, failures, faults, adaptations."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Final, Literal, TypeAlias

from msgspec import Meta

from sunset.errors import ExtensionError, ScenarioError
from sunset.files.schemas import check_fields, fields_of
from sunset.system.names import TOPIC_PATTERN
from sunset.texts.names import ros_text

LONGEST_DELAY_S: Final = 3600.0
"""The longest time from a node's start until it activates itself [s]."""

Value = bool | int | float | str
"""The value of a ROS parameter that faults and adaptations set."""

Name: TypeAlias = Annotated[
    str,
    Meta(
        pattern=r"^[A-Za-z_][A-Za-z0-9_]*\Z",
        description="a name of letters, digits and _ that does not begin with a digit",
    ),
]
TopicName: TypeAlias = Annotated[str, Meta(pattern=TOPIC_PATTERN, description="a topic's name")]


class _Part:
    """A dataclass whose fields are checked, since the author of an extension may not check types."""

    __slots__ = ()

    def __post_init__(self) -> None:
        try:
            check_fields(self, ExtensionError)
        except ExtensionError as error:
            part: type = type(self)
            label = str(getattr(self, next(iter(fields_of(part)))))
            raise ExtensionError(f"The {part.__name__} {label!r} is not usable: {error}") from None


@dataclass(frozen=True, slots=True)
class NodeDescription(_Part):
    """A managed node.

    Attributes:
        name: its name, without namespace.
        node_class: its class, or the class's place as `module:Class`.
        inputs: the topics that it subscribes to in a healthy system; relative names are in the managed system's
            namespace.
        outputs: the topics that it publishes on.
        activation_delay_s: time from its start until it activates itself [s]; negative if it does not.
        compute_s: time that a callback of an input takes in the simulation [s]; 0 for the time of other callbacks.
    """

    name: Name
    node_class: type | str
    inputs: tuple[str, ...]
    outputs: Annotated[
        tuple[TopicName, ...], Meta(description="a tuple of topics' names, such as ('rgb_camera',)")
    ] = ()
    activation_delay_s: Annotated[
        float, Meta(ge=-1, le=LONGEST_DELAY_S, description=f"a number from 0 to {LONGEST_DELAY_S:g} s, or -1")
    ] = 0.0
    compute_s: Annotated[float, Meta(ge=0, lt=1)] = 0.0

    @property
    def initial_state(self) -> str:
        """Its lifecycle state in a healthy system."""
        return "active" if self.activation_delay_s >= 0 else "inactive"


@dataclass(frozen=True, slots=True)
class Topic(_Part):
    """A topic that the monitor watches.

    Attributes:
        name: its name; a relative name is in the managed system's namespace.
        message_type: the type of its messages, such as `sensor_msgs/msg/Image`.
    """

    name: str
    message_type: str = "sensor_msgs/msg/Image"


@dataclass(frozen=True, slots=True)
class Signal(_Part):
    """A number that a node reports on `/diagnostics`; the blackboard has its mean over `SAMPLES`.

    Attributes:
        node: the node that reports it.
        key: its name there.
        unit: its unit; empty for a number without a unit.
        threshold: the mean beyond it is a symptom; None without a threshold, or if the model's card has it.
        below: whether a mean below the threshold is the symptom, instead of a mean above it.
        calibrated: whether the model's card has the threshold.
    """

    node: str
    key: Name
    unit: str = ""
    threshold: float | None = None
    below: bool = False
    calibrated: bool = False

    @property
    def name(self) -> str:
        """The blackboard's entry with its mean, such as `segmentation_entropy`."""
        return f"{self.node}_{self.key}"

    @property
    def has_threshold(self) -> bool:
        """Whether a mean can be a symptom."""
        return self.calibrated or self.threshold is not None

    @property
    def threshold_name(self) -> str:
        """The name of its threshold in model cards and records, such as `entropy_threshold`."""
        return f"{self.key}_threshold"

    def is_beyond(self, value: float, threshold: float) -> bool:
        """Return whether a value is on the wrong side of a threshold; the threshold itself is not."""
        return value < threshold if self.below else value > threshold


@dataclass(frozen=True, slots=True)
class Failure(_Part):
    """An observable failure (paper, section 3.3): a topic stops, or a signal is beyond its threshold.

    Attributes:
        name: such as `F1`.
        description: the observation in a few words, such as "the camera sends no images".
        symptom: the observation when it begins.
        gone: the observation when it is over.
        topic: the topic that stops; empty if a signal shows it.
        signal: the name of the signal; empty if a topic shows it.
    """

    name: Name
    description: str
    symptom: str
    gone: str
    topic: str = ""
    signal: str = ""


class FaultKind(StrEnum):
    """Where a fault is, which decides how long it lasts."""

    INTERNAL = "internal"
    """In a node: it ends with the node's process at the latest."""
    EXTERNAL = "external"
    """In the world: it outlasts a redeploy, and the pipeline can only work around it."""
    CONFIGURATION = "configuration"
    """In the connections of nodes: it outlasts a redeploy, too."""


class AdaptationKind(StrEnum):
    """The kinds of changes that a managing system can make to the managed system."""

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
        """The lifecycle state that an activation or deactivation leads to; None for other kinds."""
        return {AdaptationKind.ACTIVATE: "active", AdaptationKind.DEACTIVATE: "inactive"}.get(self)


KindOfAdaptation: TypeAlias = Annotated[
    AdaptationKind, Meta(description=f"one of {', '.join(AdaptationKind)}")
]


@dataclass(frozen=True, slots=True)
class Adaptation(_Part):
    """An adaptation of a node.

    Attributes:
        kind: the kind of change; its text will do.
        node: the node's name without namespace.
        parameter: the parameter that it sets; empty for other kinds.
        value: the parameter's new value; None for other kinds.
    """

    kind: KindOfAdaptation
    node: str
    parameter: str = ""
    value: Value | None = None

    def __post_init__(self) -> None:
        _Part.__post_init__(self)
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
"""The node of a sensor whose images a fault degrades."""


@dataclass(frozen=True, slots=True)
class View(_Part):
    """A value of the parameter that chooses the sensors of the pipeline.

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
        _Part.__post_init__(self)
        object.__setattr__(self, "sensors", frozenset(self.sensors))  # a tuple or list will do


ImageFunction: TypeAlias = Callable[..., object] | str
"""A function of an image and a strength that returns an image of the same kind, or its place as `module:function`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect(_Part):
    """The effect of a fault on the segmentation's images, with which it can be measured without nodes.

    Attributes:
        degrade: the fault's effect on an image, at a strength.
        strengths: the strengths to measure, ascending; the strength of the suites is added.
        sensor: whose images it degrades: the camera's (H, W, 3) of `uint8`, or the depth camera's (H, W) of `uint16`.
        random: whether the functions take a generator of random numbers as a third argument.
        restore: the effect of the cheapest cure on these images, at the same strength; None if it restores them fully.
        suite: for a fault whose value is not a number, its strength in the suites, or the fault whose strength it has.
        largest: for such a fault, the greatest strength.
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
class Fault(_Part):
    """A fault.

    It is *cured* when its symptom is gone and the segmentation is as good as before; adaptations outside its `cures`
    must not cure it.

    Attributes:
        name: its name in scenarios, and usually the parameter that injects it.
        failure: the name of the failure that it first shows as.
        node: the node that it is injected into, without namespace.
        description: a sentence about the fault.
        cures: sets of adaptations that cure it together; the cheapest first.
        value: the value that injects it, at the strength of the suites.
        kind: where it is.
        limits: least and greatest allowed value; None if the value is not a number.
        parameter: the parameter that injects it; by default its name.
        healthy: the value of the parameter without the fault; by default False, 0, 0.0 or an empty text.
        injection: the adaptations that inject it at the suites' strength; by default, the parameter is set.
        effect: its effect on images; None if it cannot be measured without nodes.
    """

    name: Name
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
        _Part.__post_init__(self)
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
        """Its cures in words, such as `restart camera, or redeploy camera`."""
        return ", or ".join(self.cure_texts) or "nothing"

    @property
    def redeploy_only(self) -> bool:
        """Whether a redeploy is its cheapest cure."""
        return bool(self.cures) and self.cures[0][0].kind is AdaptationKind.REDEPLOY

    def is_undone(self, strength: object, amounts: Iterable[object]) -> bool:
        """Return whether nodes with a parameter that undoes it, such as the enhancement, undo a third of it or more.

        Args:
            strength: the value of the fault's parameter, or None; only a number can be too large.
            amounts: the values of that parameter of a cure's nodes, or None for a node without it.
        """
        needed = _number(strength)
        undone = [amount for amount in map(_number, amounts) if amount is not None]
        return needed is None or all(abs(amount) >= abs(needed) / 3 for amount in undone)

    def checked(self, value: Value) -> Value:
        """Return a value that injects it, in the type of the parameter.

        Raises:
            ScenarioError: the value does not inject it.
        """
        if self.limits is None:
            if type(value) is not type(self.value) or value != self.value:
                raise ScenarioError(
                    f"The fault {self.name} has no strength: its value must be {_yaml(self.value)} or left out, got "
                    f"{_yaml(value)}."
                )
            return self.value
        low, high = self.limits
        whole = isinstance(self.value, int)
        is_number = not isinstance(value, bool | str) and low <= value <= high
        if not is_number or (whole and value != int(value)) or value == self.healthy:
            least = "above" if self.healthy == low else "at least"
            raise ScenarioError(
                f"The value of the fault {self.name} must be a {'whole ' if whole else ''}number {least} {low:g} and "
                f"at most {high:g}, got {_yaml(value)}."
            )
        return int(value) if whole else float(value)


def _yaml(value: Value) -> str:
    return repr(value) if isinstance(value, str) else ros_text(value)


def _number(value: object) -> float | None:
    try:
        return float(str(value))
    except ValueError:
        return None
