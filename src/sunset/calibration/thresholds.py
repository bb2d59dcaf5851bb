"""Thresholds of entropy and sharpness between healthy and faulty windows of frames."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from sunset.calibration.conditions import ENTROPY, SHARPNESS, Condition, CurvesPlan, effects, signal_of
from sunset.errors import DataError
from sunset.system import SAMPLES, current_system, get_fault

Values: TypeAlias = npt.NDArray[np.float64]

Means: TypeAlias = Callable[[Condition], Values]
"""Returns the means over windows of frames in a condition."""

_SMALLEST: Final = 1e-6


@dataclass(frozen=True, slots=True)
class Separation:
    """A threshold between two kinds of values.

    Attributes:
        threshold: values of the second kind should exceed it.
        false_alarms: greatest share, over the sets of the first kind, of values above the threshold.
        misses: greatest share, over the sets of the second kind, of values not above it.
    """

    threshold: float
    false_alarms: float
    misses: float


def chosen_frames(count: int, every: int) -> list[int]:
    """Return the frames to look at: the first group of five of every `every` groups; all if `every` is 1.

    >>> chosen_frames(23, 2)
    [0, 1, 2, 3, 4, 10, 11, 12, 13, 14]
    """
    whole = count if every == 1 else count - count % SAMPLES
    return [index for index in range(whole) if index // SAMPLES % every == 0]


def window_means(values: Values, every: int) -> Values:
    """Return the means over windows of the frames that `chosen_frames` returned.

    >>> window_means(np.arange(10.0), 1).tolist(), window_means(np.arange(10.0), 2).tolist()
    ([2.0, 3.0, 4.0, 5.0, 6.0, 7.0], [2.0, 7.0])
    """
    step = 1 if every == 1 else SAMPLES
    windows = np.lib.stride_tricks.sliding_window_view(values, SAMPLES)[::step]
    means: Values = windows.mean(axis=1)
    return means


def separate(low: list[Values], high: list[Values]) -> Separation:
    """Return the threshold with the smallest worst error, false alarms or misses, in any set.

    Among equally good thresholds, it is the middle of the widest gap.

    >>> separate([np.array([0.0, 0.25])], [np.array([0.75, 1.0]), np.array([0.5])]).threshold
    0.375
    """

    def errors_at(edge: float) -> tuple[float, float]:
        alarms = max(float((values > edge).mean()) for values in low)
        return alarms, max(float((values <= edge).mean()) for values in high)

    values = np.unique(np.concatenate([*low, *high]))
    edges = (values[1:] + values[:-1]) / 2
    errors = np.array([errors_at(edge) for edge in edges])
    worst = errors.max(axis=1)
    best = np.flatnonzero(worst == worst.min())
    chosen = best[int(np.argmax(values[best + 1] - values[best]))]
    alarms, misses = errors[chosen]
    return Separation(float(edges[chosen]), float(alarms), float(misses))


def roc_auc(negative: Values, positive: Values) -> float:
    """Return the chance that a positive exceeds a negative; ties count half.

    >>> roc_auc(np.array([1.0, 2.0]), np.array([2.0, 3.0]))
    0.875
    """
    difference = positive[:, None] - negative[None, :]
    return float((difference > 0).mean() + 0.5 * (difference == 0).mean())


def healthy_conditions(plan: CurvesPlan) -> tuple[Condition, ...]:
    """Return the conditions with the entropy of healthy operation.

    They are the conditions without a fault, with every network, and those after a cure that restores degraded frames.
    """
    restored = (
        plan.before(fault).cured_of(fault) for fault in unsure_faults(plan) if effects()[fault].restore
    )
    return (*(Condition(network) for network in plan.networks), *restored)


def unsure_faults(plan: CurvesPlan) -> tuple[str, ...]:
    """Return the faults with the entropy as their signal."""
    return tuple(fault for fault, _ in plan.points if signal_of(fault) == ENTROPY)


def part_entropy(plan: CurvesPlan, means: Means) -> Separation:
    """Return the threshold of the entropy between `healthy_conditions` and each fault with this signal.

    Raises:
        DataError: all means are the same.
    """
    return _parted(
        "entropy",
        list(map(means, healthy_conditions(plan))),
        [means(plan.before(fault)) for fault in unsure_faults(plan)],
    )


def part_sharpness(plan: CurvesPlan, means: Means) -> Separation:
    """Return the threshold of the sharpness between sharp and blurred frames.

    Sharp are frames without a fault, and of a camera with a fault that shows in the entropy, such as darkened frames.
    The logarithms of the sharpness are compared, since it spans decades.

    Raises:
        DataError: all means are the same.
    """
    camera = current_system().signals[SHARPNESS].node
    degraded = [plan.before(fault) for fault in unsure_faults(plan) if get_fault(fault).node == camera]
    blurred = [plan.before(fault) for fault, _ in plan.points if signal_of(fault) == SHARPNESS]
    if not blurred:  # the model takes no colour images
        return Separation(0.0, 0.0, 0.0)
    low, high = (
        [np.log(np.maximum(means(condition), _SMALLEST)) for condition in conditions]
        for conditions in (blurred, [Condition(plan.networks[0]), *degraded])
    )
    logs = _parted("sharpness", low, high)  # faulty values are the low values here
    return Separation(float(np.exp(logs.threshold)), logs.misses, logs.false_alarms)


def _parted(signal: str, low: list[Values], high: list[Values]) -> Separation:
    if len(np.unique(np.concatenate([*low, *high]))) == 1:
        raise DataError(
            f"These frames tell nothing about a threshold of the {signal}, which is the same in all of them, faulty or "
            "not: give others."
        )
    return separate(low, high)
