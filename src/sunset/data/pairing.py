"""Matching of the images of several sensors by their stamps."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

_LONE_PERIOD_NS: Final = 100_000_000
"""The assumed period of a single image."""

Stamps = npt.NDArray[np.int64]


def pair(first: Sequence[int], *others: Sequence[int]) -> list[tuple[int, ...]]:
    """Return for each moment, in order, the position of its stamp in each sensor's stamps.

    Two stamps match if each is the nearest to the other and they are less than half a period of the first
    sensor apart (its median distance of stamps); incomplete moments are left out. Stamps are in nanoseconds, and
    increase.

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
    """Return for each wanted stamp the position of the nearest given stamp; of two as near, the earlier."""
    right = np.minimum(np.searchsorted(given, wanted), len(given) - 1)
    left = np.maximum(right - 1, 0)
    return np.where(wanted - given[left] <= given[right] - wanted, left, right)
