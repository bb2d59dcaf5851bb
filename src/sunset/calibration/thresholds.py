"""The thresholds of entropy and sharpness: what parts healthy windows of frames from faulty ones."""

from collections.abc import Callable
from typing import Final, TypeAlias

import numpy as np

from sunset.calibration.conditions import ENTROPY, SHARPNESS, Condition, CurvesPlan, effects, signal_of
from sunset.calibration.separation import Separation, Values, separate
from sunset.errors import DataError
from sunset.system import current_system, get_fault

Means: TypeAlias = Callable[[Condition], Values]
"""Returns the means over windows of frames in a condition."""

_SMALLEST: Final = 1e-6


def healthy_conditions(plan: CurvesPlan) -> tuple[Condition, ...]:
    """Return the conditions whose entropy is that of healthy operation.

    They are those without a fault, with every network, and those of degraded frames that a cure restores.
    """
    restored = (
        plan.before(fault).cured_of(fault) for fault in unsure_faults(plan) if effects()[fault].restore
    )
    return (*(Condition(network) for network in plan.networks), *restored)


def unsure_faults(plan: CurvesPlan) -> tuple[str, ...]:
    """Return the faults that show in the entropy."""
    return tuple(fault for fault, _ in plan.points if signal_of(fault) == ENTROPY)


def blurring_faults(plan: CurvesPlan) -> tuple[str, ...]:
    """Return the faults that show in the sharpness."""
    return tuple(fault for fault, _ in plan.points if signal_of(fault) == SHARPNESS)


def part_entropy(plan: CurvesPlan, means: Means) -> Separation:
    """Return the threshold of the entropy that parts `healthy_conditions` best from each fault that shows in it.

    Raises:
        DataError: all means are the same.
    """
    return _parted(
        "entropy",
        list(map(means, healthy_conditions(plan))),
        [means(plan.before(fault)) for fault in unsure_faults(plan)],
    )


def part_sharpness(plan: CurvesPlan, means: Means) -> Separation:
    """Return the threshold of the sharpness that parts sharp frames best from blurred ones.

    Sharp are frames without a fault and those of a camera with a fault that shows in entropy, such as darkened ones.
    Sharpness is compared by its logarithm, since it spans decades.

    Raises:
        DataError: all means are the same.
    """
    camera = current_system().signals[SHARPNESS].node
    degraded = [plan.before(fault) for fault in unsure_faults(plan) if get_fault(fault).node == camera]
    blurred = [plan.before(fault) for fault in blurring_faults(plan)]
    if not blurred:  # the model does not look at colour images
        return Separation(0.0, 0.0, 0.0)
    low, high = (
        [np.log(np.maximum(means(condition), _SMALLEST)) for condition in conditions]
        for conditions in (blurred, [Condition(plan.networks[0]), *degraded])
    )
    logs = _parted("sharpness", low, high)  # the faulty ones are the low ones here
    return Separation(float(np.exp(logs.threshold)), logs.misses, logs.false_alarms)


def _parted(what: str, low: list[Values], high: list[Values]) -> Separation:
    if len(np.unique(np.concatenate([*low, *high]))) == 1:
        raise DataError(
            f"These frames tell nothing about a threshold of the {what}, which is the same in all of them, faulty or "
            "not: give others."
        )
    return separate(low, high)
