"""Temperatures and thresholds: what makes entropy a symptom."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.errors import DataError, ModelError
from sunset.metrics import normalised_entropy
from sunset.training.inputs import upsampling

_EVERY: Final = 3
"""Odd, so that pixels near to and far from a logit take part."""
_LIMITS: Final = (0.05, 20.0)


@dataclass(frozen=True, slots=True)
class Separation:
    """A threshold between two kinds of values.

    Attributes:
        threshold: values of the second kind should exceed it.
        false_alarms: greatest share of one set of the first kind that exceed it.
        misses: greatest share of one set of the second kind that do not.
    """

    threshold: float
    false_alarms: float
    misses: float


def _sampled(low: npt.NDArray[np.float32], width: int) -> npt.NDArray[np.float32]:
    """Return every third row and column of logits (28, h, w) interpolated to a width."""
    factor, rest = divmod(width, low.shape[2])
    if rest:
        raise ModelError(
            f"The width of a network's logits must divide that of its frames, {width}, got {low.shape[2]}: export "
            "or import it with this version."
        )
    rows = upsampling(low.shape[1], factor)[::_EVERY]
    columns = upsampling(low.shape[2], factor)[::_EVERY]
    full: npt.NDArray[np.float32] = np.einsum("ih,chw,jw->cij", rows, low, columns, optimize=True)
    return full


def _mean_entropy(logits: list[npt.NDArray[np.float32]], temperature: float) -> float:
    return float(np.mean([normalised_entropy(frame, temperature=temperature) for frame in logits]))


def temperature_for(logits: list[npt.NDArray[np.float32]], entropy: float, width: int) -> float:
    """Return the temperature, to four digits, at which the mean entropy of frames is as wanted, normalised in (0, 1).

    Logits are per frame (28, h, w); they are interpolated to the frames' width in pixels, a multiple of theirs.

    Raises:
        DataError: no temperature from 0.05 to 20 reaches it.
        ModelError: the width is not a multiple of that of the logits.
    """
    logits = [_sampled(frame, width) for frame in logits]
    low, high = _LIMITS
    if not _mean_entropy(logits, low) < entropy < _mean_entropy(logits, high):
        raise DataError(
            f"No temperature from {low} to {high} gives the networks a mean entropy of {entropy:.4f}."
        )
    for _ in range(24):  # entropy rises with temperature
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if _mean_entropy(logits, middle) < entropy else (low, middle)
    return round(float(np.sqrt(low * high)), 4)


def separate(low: list[npt.NDArray[np.float64]], high: list[npt.NDArray[np.float64]]) -> Separation:
    """Return the threshold with the smallest worst error: false alarms or misses in any one set.

    Values of the sets `low` should lie below it, those of `high` above. Where several do equally well, the middle of
    the widest gap of them is taken.

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
