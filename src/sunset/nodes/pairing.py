"""Matching two streams of stamped items: the newest pair, each once, never a stale one."""

from typing import Final, Generic, TypeVar

SET_BACK_NS: Final = 10**9
"""What is older than the newest by more than this is not late: time was set back, or the newest had a false stamp."""

LeftT = TypeVar("LeftT")
RightT = TypeVar("RightT")


class PairMatcher(Generic[LeftT, RightT]):
    """Finds pairs of items whose stamps differ by at most a tolerance.

    A pair is given once, and no pair is given after a newer one: both items of a pair are newer than
    both of the pair before. Items may arrive late and out of order, and are forgotten when they are of
    no use any more. An item that is more than a second older than the last pair's means that time was set back:
    everything is forgotten but that item.

    Args:
        size: how many items of each stream wait for their partner; those that came first are forgotten first.

    >>> pairs = PairMatcher()
    >>> pairs.add_left(0, "rgb", tolerance=10) is None
    True
    >>> pairs.add_right(4, "depth", tolerance=10)
    ('rgb', 'depth')
    """

    def __init__(self, size: int = 10) -> None:
        self._size = size
        self._left: dict[int, LeftT] = {}
        self._right: dict[int, RightT] = {}
        self._last_left: int | None = None
        self._last_right: int | None = None

    def add_left(self, stamp: int, item: LeftT, *, tolerance: int) -> tuple[LeftT, RightT] | None:
        """Take an item of the first stream; return the pair that it completes, or None.

        Args:
            stamp: its time in nanoseconds.
            item: the item.
            tolerance: greatest difference in nanoseconds of the stamps of a pair.
        """
        if self._is_late(stamp, self._last_left):
            return None
        partner = _closest(stamp, self._right, tolerance)
        if partner is None:
            _keep(self._left, stamp, item, self._size)
            return None
        pair = item, self._right[partner]
        self._forget_until(stamp, partner)
        return pair

    def add_right(self, stamp: int, item: RightT, *, tolerance: int) -> tuple[LeftT, RightT] | None:
        """Take an item of the second stream; return the pair that it completes, or None.

        Args:
            stamp: its time in nanoseconds.
            item: the item.
            tolerance: greatest difference in nanoseconds of the stamps of a pair.
        """
        if self._is_late(stamp, self._last_right):
            return None
        partner = _closest(stamp, self._left, tolerance)
        if partner is None:
            _keep(self._right, stamp, item, self._size)
            return None
        pair = self._left[partner], item
        self._forget_until(partner, stamp)
        return pair

    def clear_left(self) -> None:
        """Forget the waiting items of the first stream, not which pairs were given."""
        self._left.clear()

    def reset(self) -> None:
        """Forget everything, as if nothing had been taken."""
        self._left.clear()
        self._right.clear()
        self._last_left = self._last_right = None

    def _is_late(self, stamp: int, last: int | None) -> bool:
        """Return whether something as new was given; forget everything if time was set back."""
        if last is None or stamp > last:
            return False
        if last - stamp <= SET_BACK_NS:
            return True
        self.reset()
        return False

    def _forget_until(self, left: int, right: int) -> None:
        self._last_left, self._last_right = left, right
        self._left = {stamp: item for stamp, item in self._left.items() if stamp > left}
        self._right = {stamp: item for stamp, item in self._right.items() if stamp > right}


def _closest(stamp: int, waiting: dict[int, LeftT], tolerance: int) -> int | None:
    """Return the waiting stamp that is closest and within the tolerance; of two as close, the newer."""
    near = [other for other in waiting if abs(other - stamp) <= tolerance]
    return min(near, key=lambda other: (abs(other - stamp), -other), default=None)


def _keep(waiting: dict[int, LeftT], stamp: int, item: LeftT, size: int) -> None:
    waiting[stamp] = item
    if len(waiting) > size:
        del waiting[next(iter(waiting))]
