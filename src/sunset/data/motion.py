"""How things move: vehicles from queue to queue, walkers round their block, trains along their line.

All junctions change together: for `PHASE_S` the streets along u have green and those along v stand, then the
other way round. In its street's green phase every vehicle drives from its place in the queue before one stop
line to the same place before the next, and pedestrians cross what stands. Nobody meets anybody, and every
position follows from the time alone.
"""

from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np
import numpy.typing as npt

from sunset.data.frame import Points

HALF_M: Final = 430.0
"""Half the length of the railway on which trains run round and round, in metres."""
PHASE_S: Final = 15.0
"""How long one axis of the grid has green, in seconds."""

Axes: TypeAlias = npt.NDArray[np.int64]
Places: TypeAlias = tuple[Points, Axes, Points]
"""Grid points (N, 2), the grid axes along which their headings lie (N,), and the signs of these (N,)."""


@dataclass(frozen=True, slots=True)
class Hops:
    """Movers that wait, go on when their axis has green, and wait again.

    Attributes:
        axes: along which each moves: 0 along u, 1 along v (N,); it moves while this axis has green.
        across: the fixed grid coordinate in metres (N,).
        stops: places along the axis where each waits, in order, and from the last anew to the first (N, K).
        counts: how many of the stops are used (N,).
        first: index of the stop at time 0 (N,).
        signs: of the heading along the axis, 0 for those who turn round (N,).
        back: how far behind a stop each waits, signed along the axis, in metres (N,).
        delays: how long after green each starts, in seconds (N,).
    """

    axes: Axes
    across: Points
    stops: Points
    counts: Axes
    first: Axes
    signs: Axes
    back: Points
    delays: Points

    def places(self, time_s: float) -> Places:
        """Return where each is at a time in seconds."""
        phase = time_s - self.axes * PHASE_S
        cycle = np.floor(phase / (2 * PHASE_S)).astype(np.int64)
        within = phase - cycle * 2 * PHASE_S
        at = (self.first + cycle) % self.counts
        rows = np.arange(len(at))
        begin, end = self.stops[rows, at], self.stops[rows, (at + 1) % self.counts]
        # Who goes back to the first stop drives on and out of sight instead.
        end = np.where(self.signs * (end - begin) < 0, begin + 60.0 * self.signs, end)
        duration = np.minimum(2.5 + np.abs(end - begin) / 10, PHASE_S - 0.5 - self.delays)
        along = begin + (end - begin) * _eased((within - self.delays) / duration) - self.back
        signs = np.where(self.signs == 0, np.where(end < begin, -1, 1), self.signs).astype(np.float64)
        grid = np.stack([along, self.across], axis=1)
        return np.where(self.axes[:, None] == 0, grid, grid[:, ::-1]), self.axes, signs


def _eased(share: Points) -> Points:
    """Return the share of the way after a share of the time: quicken for a quarter, coast, slow down."""
    t = np.clip(share, 0, 1)
    ends = np.minimum(t, 1 - t) ** 2 * 8 / 3
    quarter = 0.25
    return np.where(t < quarter, ends, np.where(t > 1 - quarter, 1 - ends, (t - 0.125) * 4 / 3))


@dataclass(frozen=True, slots=True)
class Rounds:
    """Walkers that go round a block, on its pavement.

    Attributes:
        low: the least corner of each one's way (N, 2).
        size: extents of the way along u and v (N, 2).
        starts: how far along each is at time 0, in metres (N,).
        speeds: in metres a second, positive if anticlockwise on the grid (N,).
    """

    low: Points
    size: Points
    starts: Points
    speeds: Points

    def places(self, time_s: float) -> Places:
        """Return where each is at a time in seconds."""
        width, height = self.size[:, 0], self.size[:, 1]
        at = (self.starts + self.speeds * time_s) % (2 * (width + height))
        corners = np.stack([width, width + height, 2 * width + height], axis=1)
        side = (at[:, None] >= corners).sum(axis=1)
        u = np.choose(side, [at, width, 2 * width + height - at, np.zeros_like(at)])
        v = np.choose(side, [np.zeros_like(at), at - width, height, 2 * (width + height) - at])
        forth = np.array([1.0, 1.0, -1.0, -1.0])[side]
        return self.low + np.stack([u, v], axis=1), side % 2, forth * np.sign(self.speeds)


@dataclass(frozen=True, slots=True)
class Trains:
    """Carriages that run along the railway without a halt, round and round.

    They have u of their tracks and v at time 0 in metres, and signed speeds in metres a second, each (N,).
    """

    across: Points
    starts: Points
    speeds: Points

    def places(self, time_s: float) -> Places:
        """Return where each is at a time in seconds."""
        along = (self.starts + self.speeds * time_s + HALF_M) % (2 * HALF_M) - HALF_M
        grid = np.stack([self.across, along], axis=1)
        return grid, np.ones(len(along), dtype=np.int64), np.sign(self.speeds)
