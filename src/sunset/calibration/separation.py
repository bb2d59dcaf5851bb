"""Telling healthy windows of frames from faulty ones: means over a window, a threshold, how well it parts them."""

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from sunset.system import WINDOW

SAMPLES: Final = WINDOW.samples
"""So many consecutive frames make a symptom."""

Values: TypeAlias = npt.NDArray[np.float64]


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


def chosen_frames(count: int, every: int) -> list[int]:
    """Return the frames to look at: all, or of every so many groups of five the first.

    >>> chosen_frames(23, 2)
    [0, 1, 2, 3, 4, 10, 11, 12, 13, 14]
    """
    whole = count if every == 1 else count - count % SAMPLES
    return [index for index in range(whole) if index // SAMPLES % every == 0]


def window_means(values: Values, every: int) -> Values:
    """Return the means over five consecutive frames of those that `chosen_frames` chose.

    >>> window_means(np.arange(10.0), 1).tolist(), window_means(np.arange(10.0), 2).tolist()
    ([2.0, 3.0, 4.0, 5.0, 6.0, 7.0], [2.0, 7.0])
    """
    step = 1 if every == 1 else SAMPLES
    windows = np.lib.stride_tricks.sliding_window_view(values, SAMPLES)[::step]
    means: Values = windows.mean(axis=1)
    return means


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


def roc_auc(negative: npt.NDArray[np.float64], positive: npt.NDArray[np.float64]) -> float:
    """Return the chance that a positive exceeds a negative, ties counting half.

    >>> roc_auc(np.array([1.0, 2.0]), np.array([2.0, 3.0]))
    0.875
    """
    difference = positive[:, None] - negative[None, :]
    return float((difference > 0).mean() + 0.5 * (difference == 0).mean())
