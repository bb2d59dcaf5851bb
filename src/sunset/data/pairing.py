"""Which images of several sensors belong to one moment."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

_LONE_PERIOD_NS: Final = 100_000_000
"""The period that is assumed where there is only one image."""

Stamps = npt.NDArray[np.int64]


def pair(first: Sequence[int], *others: Sequence[int]) -> list[tuple[int, ...]]:
    """Match every stamp of the first sensor with the nearest one of each other sensor.

    Two stamps match if each is the nearest to the other and they are less than half a period of the first
    sensor apart (its median distance of stamps); a moment that one sensor lacks is left out. Stamps are in
    nanoseconds, and increase.

    Returns:
        For each moment, in order, the position of its stamp in each sequence.

    >>> pair([0, 100, 200], [1, 198], [0, 100, 201])
    [(0, 0, 0), (2, 1, 2)]
    """
    if not first or not all(others):
        return []
    own = np.asarray(first, dtype=np.int64)
    period = float(np.median(np.diff(own))) if len(own) > 1 else _LONE_PERIOD_NS
    complete = np.ones(len(own), dtype=bool)
    columns = [np.arange(len(own))]
    for other in others:
        theirs = np.asarray(other, dtype=np.int64)
        nearest = _nearest(own, theirs)
        mutual = _nearest(theirs, own)[nearest] == columns[0]
        complete &= mutual & (2 * np.abs(theirs[nearest] - own) < period)
        columns.append(nearest)
    return [tuple(row) for row in np.stack(columns, axis=1)[complete].tolist()]


def _nearest(wanted: Stamps, given: Stamps) -> npt.NDArray[np.intp]:
    """Return, for each wanted stamp, the position of the nearest given one; the earlier of two as near."""
    right = np.minimum(np.searchsorted(given, wanted), len(given) - 1)
    left = np.maximum(right - 1, 0)
    return np.where(wanted - given[left] <= given[right] - wanted, left, right)
