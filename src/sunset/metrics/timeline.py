"""The record of a run as values: the input of all metrics.

Times are in seconds. The measured time is from 0 to `duration_s`, after the warm-up. Arrays of times ascend.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Final, Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from msgspec import Meta

from sunset.classes import CLASSES
from sunset.errors import RecordError
from sunset.system import DURATION_S, PERIOD_S, current_system

NUMBER_OF_CLASSES: Final = len(CLASSES)
"""28."""

TOLERANCE_S: Final = 1e-6
"""Times that differ by less are equal: the error of arithmetic in seconds."""

MOST: Final = 10**6
"""The largest number of a run; twelve days for times."""

Share: TypeAlias = Annotated[float, Meta(ge=0, le=1)]
Amount: TypeAlias = Annotated[float, Meta(ge=0, le=MOST)]
Positive: TypeAlias = Annotated[float, Meta(gt=0, le=MOST)]
Count: TypeAlias = Annotated[int, Meta(ge=0, le=MOST)]
Tokens: TypeAlias = Annotated[int, Meta(ge=0, le=2**53)]
"""The limits by which stored numbers are checked."""

Evidence: TypeAlias = Literal["symptoms", "images"]
"""What a managing system used: the blackboard, diagnostics and states only, or images too."""

Times = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """A measured value over time: (N,) values, and when each was reported [s].

    Raises:
        RecordError: a value is not finite.
    """

    times: Times = field(default_factory=lambda: np.empty(0))
    values: Times = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        """Check the values."""
        if not np.isfinite(self.values).all():
            raise RecordError("The values of samples must be finite.")


@dataclass(frozen=True, slots=True)
class Injection:
    """A fault of the catalogue that was injected at a time [s], and confirmed by its node.

    Attributes:
        failure: the failure that it shows as, such as `F1`.
        node: with or without the managed system's namespace.
        internal: whether it ends with the node's process.
        redeploy_only: whether only a redeploy of the node cures it.
        ended: when it ended [s]; None if it did not, or the record does not say so.
        cause: the adaptation that ended it, such as `restart camera`; empty if it healed, or has not ended.
        cured_away: when an adaptation kept it from coming again while it was away [s]; else None.
    """

    time: float
    fault: str
    failure: str
    node: str
    internal: bool = True
    redeploy_only: bool = False
    ended: float | None = None
    cause: str = ""
    cured_away: float | None = None

    @property
    def healed(self) -> float | None:
        """When it healed [s]; None if it did not."""
        return None if self.cause else self.ended

    def is_there(self, time: float) -> bool:
        """Return whether it has come, and has not ended."""
        return self.time <= time and (self.ended is None or time < self.ended)

    @property
    def over(self) -> float | None:
        """When it ended for good [s]; None if it has not ended."""
        return self.ended if self.cured_away is None else self.cured_away


@dataclass(frozen=True, slots=True)
class Command:
    """A request that a node of the managed system, or the launcher, received and answered.

    Attributes:
        time: when the request was received [s].
        client: the full name of the node that sent it.
        node: the node to be changed, with or without the managed system's namespace.
        kind: `set_parameters`, `activate`, `deactivate`, `configure`, `cleanup`, `shutdown` or `redeploy`.
        values: of the parameters that it sets, as text.
        successful: whether the answer is positive.
    """

    time: float
    client: str
    node: str
    kind: str
    parameters: tuple[str, ...] = ()
    values: tuple[str, ...] = ()
    successful: bool = True


@dataclass(frozen=True, slots=True)
class Setting:
    """A new value of a parameter or a new lifecycle state of a managed node.

    Attributes:
        time: when the node reported it [s].
        node: the node, with or without the managed system's namespace.
        name: the parameter's name; `STATE` for a lifecycle state.
        value: the value as text, or the state.
        declared: whether it is a parameter's first value in a new process.
    """

    time: float
    node: str
    name: str
    value: str
    declared: bool = False


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """A diagnosis that the managing system published at a time [s]: fault → its probability."""

    time: float
    probabilities: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class Cost:
    """What a decision of the managing system has cost, as it said.

    Attributes:
        time: when it was published [s].
        model: the language model that was asked; empty if none was.
        tokens_in: the length of the questions.
        tokens_out: the length of the answers.
        price: in a currency of its own.
        think_s: the time by which its adaptations were delayed [s].
    """

    time: float
    model: str = ""
    tokens_in: int = 0
    tokens_out: int = 0
    price: float = 0.0
    think_s: float = 0.0


def _no_counts() -> Counts:
    return np.empty((0, NUMBER_OF_CLASSES), dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """The segmentation's frames, each compared with the truth.

    Attributes:
        times: (N,) when each frame was published [s].
        iou: (N,) each frame's IoU, the mean over the classes in its prediction or truth.
        intersection: (N, 28) correct pixels of each class.
        predicted: (N, 28) pixels of each class in the prediction, where the truth is not ignored.
        truth: (N, 28) pixels of each class in the truth.
    """

    times: Times = field(default_factory=lambda: np.empty(0))
    iou: Times = field(default_factory=lambda: np.empty(0))
    intersection: Counts = field(default_factory=_no_counts)
    predicted: Counts = field(default_factory=_no_counts)
    truth: Counts = field(default_factory=_no_counts)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Timeline:
    """The input of the metrics of a run. Sequences are in order of time, and include the warm-up.

    Attributes:
        period_s: the expected time between two messages of a topic [s].
        message_times: full topic name → (N,) times [s] at which its messages left; without silent topics.
        samples: name of a signal → its samples; without silent signals.
        thresholds: name of a signal's threshold → the threshold; missing thresholds are the system description's.
        commands: of all clients.
        settings: of the bring-up, too.
        frames: the evaluated frames that have a truth.
        without_truth: (N,) when frames without a pixel of a known class were published [s].
        expected_frames: the number of frames of the measured time, with lost frames.
    """

    duration_s: float = DURATION_S
    period_s: float = PERIOD_S
    message_times: Mapping[str, Times] = field(default_factory=dict)
    samples: Mapping[str, Samples] = field(default_factory=dict)
    thresholds: Mapping[str, float]
    injections: tuple[Injection, ...] = ()
    commands: tuple[Command, ...] = ()
    settings: tuple[Setting, ...] = ()
    diagnoses: tuple[Diagnosis, ...] = ()
    costs: tuple[Cost, ...] = ()
    frames: Frames = field(default_factory=Frames)
    without_truth: Times = field(default_factory=lambda: np.empty(0))
    expected_frames: int = round(DURATION_S / PERIOD_S)

    def __post_init__(self) -> None:
        """Complete the thresholds."""
        signals = [signal for signal in current_system().signals.values() if signal.has_threshold]
        known = {signal.threshold_name: signal.threshold for signal in signals}
        object.__setattr__(self, "thresholds", known | dict(self.thresholds))

    @property
    def has_truth(self) -> bool:
        """Whether the flight has labels, also if all evaluated frames were lost."""
        return bool(len(self.frames.times)) or not len(self.without_truth)
