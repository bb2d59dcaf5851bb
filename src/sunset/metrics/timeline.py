"""What an experiment left behind, as values: all that the metrics look at.

Times are seconds on the experiment's clock. 0 is the moment at which the faults are injected, the warm-up
before it is negative, and the experiment ends at `duration_s`. Arrays of times ascend.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASSES
from sunset.errors import RecordError
from sunset.system import DURATION_S, PERIOD_S, current_system

NUMBER_OF_CLASSES: Final = len(CLASSES)
"""28."""

Evidence: TypeAlias = Literal["symptoms", "images"]
"""What a managing system looked at: the blackboard, diagnostics and states only, or images too."""

Times = npt.NDArray[np.float64]
Values = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """A measured value over time.

    Attributes:
        times: (N,) when each sample was reported [s].
        values: (N,) the samples.

    Raises:
        RecordError: a value is not finite.
    """

    times: Times = field(default_factory=lambda: np.empty(0))
    values: Values = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        """Check the values, which nodes report as text."""
        if not np.isfinite(self.values).all():
            raise RecordError("The values of samples must be finite.")


@dataclass(frozen=True, slots=True)
class Injection:
    """A fault that was injected, and confirmed by its node.

    Attributes:
        time: when [s].
        fault: its name in the catalogue.
        failure: the name of what it shows as, such as `F1`.
        node: the node that it is in, with or without the managed system's namespace.
        internal: whether it ends with the node's process.
        redeploy_only: whether nothing cheaper than a redeploy of the node cures it.
        ended: when it ended [s]; None if it did not, or the record does not say so.
        cause: what ended it, such as `restart camera`; empty if it healed by itself, or has not ended.
        cured_away: when an adaptation kept it from coming again, if it had healed and was to come again [s]; else None.
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
        """When it healed by itself [s]; None if it did not."""
        return None if self.cause else self.ended

    def is_there(self, time: float) -> bool:
        """Return whether it has come, and has not ended."""
        return self.time <= time and (self.ended is None or time < self.ended)

    @property
    def over(self) -> float | None:
        """When there was nothing of it to be cured any more [s]; None if it has not ended."""
        return self.ended if self.cured_away is None else self.cured_away


@dataclass(frozen=True, slots=True)
class Command:
    """A request that a node of the managed system, or the launcher, received and answered.

    Attributes:
        time: when the request was received [s].
        client: the full name of the node that sent it.
        node: the node that it is about, with or without the managed system's namespace.
        kind: `set_parameters`, `activate`, `deactivate`, `configure`, `cleanup`, `shutdown` or `redeploy`.
        parameters: the names of the parameters that it sets.
        values: their values as text.
        successful: whether the answer says that it was done.
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
    """A value that a parameter of a managed node got, or a lifecycle state that the node came into.

    Attributes:
        time: when the node said so [s].
        node: the node, with or without the managed system's namespace.
        name: the parameter's name; `STATE` of a lifecycle state.
        value: the value as text, or the state.
        declared: whether it is the first value that a new process gave the parameter.
    """

    time: float
    node: str
    name: str
    value: str
    declared: bool = False


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What a managing system said was wrong.

    Attributes:
        time: when it was published [s].
        probabilities: fault → how sure it was.
    """

    time: float
    probabilities: Mapping[str, float]


def _no_counts() -> Counts:
    return np.empty((0, NUMBER_OF_CLASSES), dtype=np.int64)


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """The segmentation's frames, each compared with the truth.

    Attributes:
        times: (N,) when each picture was taken, and not when it was evaluated [s].
        iou: (N,) each frame's IoU, the mean over the classes that are in its prediction or truth.
        intersection: (N, 28) pixels of each class that are right.
        predicted: (N, 28) pixels of each class in the prediction, where the truth is not ignored.
        truth: (N, 28) pixels of each class in the truth.

    Raises:
        RecordError: an IoU is not in [0, 1].
    """

    times: Times = field(default_factory=lambda: np.empty(0))
    iou: Values = field(default_factory=lambda: np.empty(0))
    intersection: Counts = field(default_factory=_no_counts)
    predicted: Counts = field(default_factory=_no_counts)
    truth: Counts = field(default_factory=_no_counts)

    def __post_init__(self) -> None:
        """Check the IoU."""
        if not ((self.iou >= 0) & (self.iou <= 1)).all():  # also refuses NaN
            raise RecordError("The IoU of a frame must be from 0 to 1.")


def _complete(thresholds: Mapping[str, float]) -> Mapping[str, float]:
    """Return the thresholds of all signals that have one: as given, else as the system's description has them.

    Raises:
        RecordError: one is missing, or not finite.
    """
    complete = {}
    for signal in current_system().signals.values():
        if signal.has_threshold:
            threshold = thresholds.get(signal.threshold_name, signal.threshold)
            if threshold is None or not math.isfinite(threshold):
                raise RecordError(
                    f"The {signal.threshold_name} of a timeline must be finite, got {threshold}."
                )
            complete[signal.threshold_name] = threshold
    return complete


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Timeline:
    """Everything about one experiment that its metrics are made of.

    Attributes:
        duration_s: the experiment's end [s]; it begins at 0.
        period_s: the expected time between two messages of a topic [s].
        message_times: full topic name → (N,) times [s] at which its messages left; a topic that is not
            there never sent one. Those of the warm-up belong in it.
        samples: name of a signal → what was reported of it, with that of the warm-up; without an entry nothing was.
        thresholds: name of a signal's threshold → the threshold; for one that is not there that of the system's
            description is put in.
        injections: in order of time.
        commands: in order of time, of all clients.
        settings: in order of time, those of the bring-up included.
        diagnoses: in order of time.
        frames: the evaluated frames that have a truth.
        without_truth: (N,) when the pictures of which no pixel has a known class were taken [s].
        expected_frames: how many frames the experiment has, had none been lost.

    Raises:
        RecordError: a threshold is missing, or not finite.
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
    frames: Frames = field(default_factory=Frames)
    without_truth: Times = field(default_factory=lambda: np.empty(0))
    expected_frames: int = round(DURATION_S / PERIOD_S)

    def __post_init__(self) -> None:
        """Put in the thresholds of the system's description."""
        object.__setattr__(self, "thresholds", _complete(self.thresholds))

    @property
    def has_truth(self) -> bool:
        """Whether the quality of some frame could be measured, even if that frame was lost."""
        return bool(len(self.frames.times)) or not len(self.without_truth)
