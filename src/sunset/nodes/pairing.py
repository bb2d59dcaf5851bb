"""Matching of two streams of stamped items."""

from typing import Final, Generic, TypeVar

SET_BACK_NS: Final = 10**9
"""An item older than the newest by more than this is not late: time was set back, or the newest had a false stamp."""

LeftT = TypeVar("LeftT")
RightT = TypeVar("RightT")
OwnT = TypeVar("OwnT")
OtherT = TypeVar("OtherT")


class PairMatcher(Generic[LeftT, RightT]):
    """Finds pairs of items whose stamps differ by at most a tolerance.

    Both items of a pair are newer than both items of the pair before. Items may arrive late and out of order. An item
    more than a second older than the last pair means that time was set back: all other items are forgotten.

    Args:
        size: the number of items of each stream that wait for their partner; the first items are forgotten first.

    >>> pairs = PairMatcher()
    >>> pairs.add_left(0, "rgb", tolerance=10) is None
    True
    >>> pairs.add_right(4, "depth", tolerance=10)
    ('rgb', 'depth')
    """

    def __init__(self, size: int = 10) -> None:
        self._size = size
        self._left: _Stream[LeftT] = _Stream()
        self._right: _Stream[RightT] = _Stream()

    def add_left(self, stamp: int, item: LeftT, *, tolerance: int) -> tuple[LeftT, RightT] | None:
        """Take an item of the first stream, and return the pair that it completes, or None.

        Its stamp and the tolerance are in nanoseconds.
        """
        partner = self._find_partner(stamp, item, tolerance, self._left, self._right)
        return None if partner is None else (item, partner)

    def add_right(self, stamp: int, item: RightT, *, tolerance: int) -> tuple[LeftT, RightT] | None:
        """Take an item of the second stream, as `add_left`."""
        partner = self._find_partner(stamp, item, tolerance, self._right, self._left)
        return None if partner is None else (partner, item)

    def clear_left(self) -> None:
        """Forget the waiting items of the first stream."""
        self._left.waiting.clear()

    def reset(self) -> None:
        """Forget everything."""
        self._left.forget()
        self._right.forget()

    def _find_partner(
        self, stamp: int, item: OwnT, tolerance: int, own: "_Stream[OwnT]", others: "_Stream[OtherT]"
    ) -> OtherT | None:
        if own.last is not None and stamp <= own.last:
            if own.last - stamp <= SET_BACK_NS:
                return None  # it is late
            self.reset()
        near = [other for other in others.waiting if abs(other - stamp) <= tolerance]
        if not near:
            own.waiting[stamp] = item
            if len(own.waiting) > self._size:
                del own.waiting[next(iter(own.waiting))]
            return None
        closest = min(near, key=lambda other: (abs(other - stamp), -other))  # of two as close, the newer
        partner = others.waiting[closest]
        own.forget_until(stamp)
        others.forget_until(closest)
        return partner


class _Stream(Generic[OwnT]):
    """Items of a stream that wait for their partner, by stamp, and the stamp of the last matched item."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        self.waiting: dict[int, OwnT] = {}
        self.last: int | None = None

    def forget_until(self, last: int) -> None:
        self.last = last
        self.waiting = {stamp: item for stamp, item in self.waiting.items() if stamp > last}
