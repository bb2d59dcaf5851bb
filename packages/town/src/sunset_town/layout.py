"""The plan of a town: the places of streets, blocks, the river and the railway.

A town is laid out on an uneven rectangular grid in its own coordinates (u, v) and bent into the world's
(x, y) by a smooth `Warp`, so that streets curve and no two towns align. Where a stretch of a side street is
closed, the blocks beside it merge and its ends become T-junctions.
"""

from dataclasses import dataclass
from enum import Enum
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset_town.errors import TownError
from sunset_town.frame import Pair, Points
from sunset_town.relief import Relief, Wave
from sunset_town.seeding import generator

TOWNS: Final = range(1, 9)
"""The numbers of the towns."""
EXTENT_M: Final = 300.0
"""A town covers [-300, 300) metres in x and y; fields lie beyond."""

REACH_M: Final = 430.0
PAVEMENT_M: Final = 3.2
"""Width of the pavement on each side of a street, in metres."""

AVENUE_M: Final = 12.0
"""A carriageway wider than this has four lanes."""

QUIET: Final = 0.62
"""Share of the side streets that are closed here and there."""
CLOSED: Final = 0.45
"""Share of such a street's stretches that are closed, where their junctions allow it."""


BlockKind = Enum(
    "BlockKind",
    "TOWERS PERIMETER HOUSES PARK PLAZA PARKING INDUSTRY SITE RIVERBANK RAILSIDE SPORT ALLOTMENTS",
)
"""The use of a block between streets."""


@dataclass(frozen=True, slots=True)
class Warp:
    """The map from a town's grid (u, v) to the world (x, y), both in metres."""

    angle: float
    amplitudes: Pair
    wavelengths: Pair
    phases: Pair

    def points(self, uv: npt.ArrayLike) -> Points:
        """Return world points (..., 2) of grid points (..., 2)."""
        grid = np.asarray(uv, dtype=np.float64)
        u, v = grid[..., 0], grid[..., 1]
        bent_u = u + self.amplitudes[0] * np.sin(v / self.wavelengths[0] + self.phases[0])
        bent_v = v + self.amplitudes[1] * np.sin(u / self.wavelengths[1] + self.phases[1])
        cos, sin = np.cos(self.angle), np.sin(self.angle)
        return np.stack([bent_u * cos - bent_v * sin, bent_u * sin + bent_v * cos], axis=-1)

    def headings(self, uv: npt.ArrayLike, axis: int) -> Points:
        """Return the world direction in radians (...) of growing u (axis 0) or v (axis 1) at grid points."""
        grid = np.asarray(uv, dtype=np.float64)
        step = np.zeros(2)
        step[axis] = 0.5
        delta = self.points(grid + step) - self.points(grid - step)
        return np.arctan2(delta[..., 1], delta[..., 0])


@dataclass(frozen=True, slots=True)
class Street:
    """A street along a grid line."""

    axis: int  # 0 if it runs along u (at a fixed v), 1 if along v (at a fixed u)
    at: float  # the fixed coordinate of its centre line in metres
    width: float  # of the carriageway in metres

    @property
    def avenue(self) -> bool:
        """Whether it has four lanes."""
        return self.width > AVENUE_M

    @property
    def right(self) -> int:
        """The sign of the offset that is to the right of growing positions, where traffic keeps."""
        return -1 if self.axis == 0 else 1

    def points(self, along: npt.ArrayLike, offset: npt.ArrayLike = 0.0) -> Points:
        """Return grid points (..., 2) at positions along the street, shifted sideways by `offset`."""
        s, across = np.broadcast_arrays(np.asarray(along, float), self.at + np.asarray(offset, float))
        return np.stack([s, across] if self.axis == 0 else [across, s], axis=-1)


@dataclass(frozen=True, slots=True)
class Block:
    """A rectangle of the grid between the pavements of four streets."""

    index: int
    kind: BlockKind
    low: Pair
    high: Pair

    @property
    def size(self) -> Pair:
        """Extent along u and v in metres."""
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    @property
    def sides(self) -> tuple[tuple[Pair, Pair], ...]:
        """The two sides along u, then the two along v, each from its lower end."""
        (u0, v0), (u1, v1) = self.low, self.high
        return ((u0, v0), (u1, v0)), ((u0, v1), (u1, v1)), ((u0, v0), (u0, v1)), ((u1, v0), (u1, v1))


@dataclass(frozen=True, slots=True)
class TownPlan:
    """Everything about a town that is decided before anything is painted or built.

    `closed` has the axis and position of a street, and the position of the crossing from which it is closed to the
    next. The relief has the courses of river and railway.
    """

    number: int
    warp: Warp
    streets: tuple[Street, ...]
    blocks: tuple[Block, ...]
    relief: Relief
    closed: frozenset[tuple[int, float, float]]

    def river_points(self, along: npt.ArrayLike) -> Points:
        """Return grid points (..., 2) of the river's centre line at positions u."""
        u = np.asarray(along, dtype=np.float64)
        return np.stack([u, self.relief.river_v(u)], axis=-1)

    def crossings(self, street: Street) -> list[Street]:
        """Return the streets that cross a street, in order along it."""
        return sorted((other for other in self.streets if other.axis != street.axis), key=lambda s: s.at)

    def stretches(self, street: Street) -> list[tuple[Street, Street]]:
        """Return the neighbouring crossings between which a street is open, in the town, in order along it."""
        return [
            (before, after)
            for before, after in pairwise(self.crossings(street))
            if (street.axis, street.at, before.at) not in self.closed
            and self._in_town(street.points([before.at, after.at]))
        ]

    def is_built(self, block: Block) -> bool:
        """Return whether a block lies at least partly in the town."""
        return self._in_town(block.sides)

    def is_edge(self, block: Block) -> bool:
        """Return whether a block lies at least partly outside the town."""
        return bool((np.abs(self.warp.points(block.sides)) > EXTENT_M - 10).any())

    def _in_town(self, uv: npt.ArrayLike) -> bool:
        return bool((np.abs(self.warp.points(uv)).max(axis=-1) < EXTENT_M).any())

    def through(self, street: Street) -> bool:
        """Return whether a street is open from one end of the town to the other."""
        return not any((axis, at) == (street.axis, street.at) for axis, at, _ in self.closed)


def _lines(rng: np.random.Generator, gaps: Pair, special: float) -> tuple[list[Pair], int]:
    """Return (position, width) of parallel streets, and the index of the gap that is `special` wide."""
    lines: list[Pair] = []
    at, chosen = -REACH_M, -1
    trigger = rng.uniform(-90, 60)
    while at < REACH_M:
        width = 14.0 if rng.random() < 0.24 else float(rng.choice([6.2, 7.5, 9.0]))
        lines.append((at, width))
        if chosen < 0 and at > trigger:
            chosen = len(lines) - 1
            at += special
        else:
            at += rng.uniform(*gaps)
    return lines, chosen


_INNER: Final = {
    BlockKind.PERIMETER: 0.31,
    BlockKind.HOUSES: 0.24,
    BlockKind.TOWERS: 0.12,
    BlockKind.PARK: 0.11,
    BlockKind.PLAZA: 0.035,
    BlockKind.PARKING: 0.045,
    BlockKind.INDUSTRY: 0.06,
    BlockKind.SITE: 0.025,
    BlockKind.SPORT: 0.05,
    BlockKind.ALLOTMENTS: 0.03,
}
_OUTER: Final = {
    BlockKind.HOUSES: 0.46,
    BlockKind.ALLOTMENTS: 0.14,
    BlockKind.INDUSTRY: 0.14,
    BlockKind.PARK: 0.1,
    BlockKind.SPORT: 0.1,
    BlockKind.PERIMETER: 0.06,
}
_MERGING: Final = (BlockKind.PERIMETER, BlockKind.HOUSES, BlockKind.PARK, BlockKind.INDUSTRY, BlockKind.SPORT)
"""Kinds of neighbouring blocks that merge; others keep their halves of the ground between them."""
INNER_M: Final = 215.0
"""Blocks farther out than this are the town's edge."""


def _stack(rng: np.random.Generator, shares: dict[BlockKind, float], count: int) -> list[BlockKind]:
    """Return `count` kinds of blocks in random order, with every kind in it."""
    weights = np.array(list(shares.values())) * rng.uniform(0.75, 1.3, len(shares))
    exact = weights / weights.sum() * count
    kinds = [kind for kind, share in zip(shares, exact, strict=True) for _ in range(int(share) + 1)]
    while len(kinds) > count:
        kinds.remove(max(shares, key=kinds.count))
    return [kinds[i] for i in rng.permutation(len(kinds))]


class _Layout:
    """The columns and rows of a town while it is planned."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        shortest = rng.uniform(50, 60)
        self.us, self.rail_gap = _lines(rng, (shortest, shortest + 36), 46.0)
        self.vs, self.river_gap = _lines(rng, (shortest - 4, shortest + 26), 60.0)
        self.merged: dict[tuple[int, int], tuple[int, int]] = {}
        self.closed: set[tuple[int, float, float]] = set()

    def close_stretches(self) -> None:
        """Close stretches of some side streets; no junction loses more than one arm."""
        junctions: set[tuple[int, int]] = set()
        for axis, lines, crossings in ((1, self.us, self.vs), (0, self.vs, self.us)):
            for index in range(1, len(lines) - 1):
                if lines[index][1] > AVENUE_M or self.rng.random() > QUIET:
                    continue
                for step in range(1, len(crossings) - 2):
                    ends = {(index, step + k) if axis else (step + k, index) for k in (0, 1)}
                    low, high = ((index - k, step) if axis else (step, index - k) for k in (1, 0))
                    special = self.rail_gap in (low[0], high[0]) or self.river_gap in (low[1], high[1])
                    taken = junctions & ends or {*self.merged, *self.merged.values()} & {low, high}
                    if self.rng.random() < CLOSED and not (special or taken):
                        self.merged[low] = high
                        junctions |= ends
                        self.closed.add((axis, lines[index][0], crossings[step][0]))

    def blocks(self, warp: Warp) -> tuple[Block, ...]:
        """Return the blocks, merged or touching where a street between them is closed."""
        cells = [(i, j) for i in range(len(self.us) - 1) for j in range(len(self.vs) - 1)]
        low = {(i, j): [_inside(self.us[i], 1), _inside(self.vs[j], 1)] for i, j in cells}
        high = {(i, j): [_inside(self.us[i + 1], -1), _inside(self.vs[j + 1], -1)] for i, j in cells}
        middles = warp.points([np.mean([low[cell], high[cell]], axis=0) for cell in cells])
        outer = (np.abs(middles).max(axis=1) > INNER_M).astype(int).tolist()
        kinds = dict.fromkeys([cell for cell in cells if cell[0] == self.rail_gap], BlockKind.RAILSIDE)
        kinds |= dict.fromkeys([cell for cell in cells if cell[1] == self.river_gap], BlockKind.RIVERBANK)
        free = [(cell, stack) for cell, stack in zip(cells, outer, strict=True) if cell not in kinds]
        counts = np.bincount([stack for _, stack in free], minlength=2).tolist()
        stacks = [_stack(self.rng, *both) for both in zip((_INNER, _OUTER), counts, strict=True)]
        for (i, j), stack in free:
            beside = {kinds[cell] for cell in ((i - 1, j), (i, j - 1)) if cell in kinds}
            differing = (place for place, kind in enumerate(stacks[stack]) if kind not in beside)
            kinds[i, j] = stacks[stack].pop(next(differing, 0))
        for cell, other in self.merged.items():
            axis = 0 if other[0] > cell[0] else 1
            if kinds[cell] in _MERGING and kinds[other] in _MERGING:
                high[cell] = high.pop(other)
            else:
                high[cell][axis] = low[other][axis] = (self.us, self.vs)[axis][other[axis]][0]
        return tuple(
            Block(index, kinds[cell], (low[cell][0], low[cell][1]), (high[cell][0], high[cell][1]))
            for index, cell in enumerate(cells)
            if cell in high
        )


def _inside(line: Pair, side: int) -> float:
    """Return the edge of the blocks on a side of a street of a given position and width."""
    return line[0] + side * (line[1] / 2 + PAVEMENT_M)


def _relief(rng: np.random.Generator, layout: _Layout) -> Relief:
    us, vs = layout.us, layout.vs
    waves = []
    for length in (130.0, 180.0, 260.0, 400.0):
        wavelength, direction = length * rng.uniform(0.85, 1.2), rng.uniform(0, 6.28)
        height = wavelength * rng.uniform(0.024, 0.04) / 6.28
        along = (6.28 / wavelength * float(np.cos(direction)), 6.28 / wavelength * float(np.sin(direction)))
        waves.append(Wave(height, along, rng.uniform(0, 6.28)))
    return Relief(
        waves=tuple(waves),
        river=(vs[layout.river_gap][0] + vs[layout.river_gap + 1][0]) / 2,
        river_width=rng.uniform(15, 21),
        river_bend=(rng.uniform(1, 3), rng.uniform(0, 6.28)),
        rail=(us[layout.rail_gap][0] + us[layout.rail_gap + 1][0]) / 2,
        underpasses=tuple((at, width / 2 + PAVEMENT_M + 0.5) for at, width in vs),
    )


def check_town(number: int) -> None:
    """Check that there is a town of this number.

    Raises:
        TownError: there is not.
    """
    if number not in TOWNS:
        raise TownError(f"A town must be a whole number from 1 to {TOWNS[-1]}, got {number!r}.")


def plan_town(number: int) -> TownPlan:
    """Return the plan of a town; the same number gives the same plan.

    Raises:
        TownError: there is no town of this number.
    """
    check_town(number)
    rng = generator(number, "town", "plan", 246)  # 246 selects the set of plans
    waves = [rng.uniform(65, 130) for _ in range(2)]
    warp = Warp(
        rng.uniform(-0.6, 0.6),
        (waves[0] * rng.uniform(0.1, 0.25), waves[1] * rng.uniform(0.1, 0.25)),
        (waves[0], waves[1]),
        (rng.uniform(0, 6.28), rng.uniform(0, 6.28)),
    )
    layout = _Layout(rng)
    layout.close_stretches()
    lines = [(1, *line) for line in layout.us] + [(0, *line) for line in layout.vs]
    streets = tuple(Street(*line) for line in lines)
    return TownPlan(
        number, warp, streets, layout.blocks(warp), _relief(rng, layout), frozenset(layout.closed)
    )
