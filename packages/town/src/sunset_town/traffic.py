"""The traffic of a town: vehicles, walkers and trains, and their poses at any moment.

All junctions change together: for `PHASE_S` the streets along u have green and the streets along v wait, then the
other way round. In its street's green phase every vehicle drives from its place in the queue before a stop line to the
same place before the next, and pedestrians cross the waiting streets. Nothing meets, and every position follows from
the time alone.
"""

from dataclasses import dataclass
from itertools import zip_longest
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from sunset_town.frame import Flags, Indices, Points, Reals
from sunset_town.furnish import CAR_TINTS, CLOTHES
from sunset_town.layout import BlockKind, Street, TownPlan
from sunset_town.meshes import Mesh, join, place
from sunset_town.paving import has_zebra
from sunset_town.seeding import generator
from sunset_town.things import MOVERS

HALF_M: Final = 430.0
"""Half the length of the circular railway in metres."""
PHASE_S: Final = 15.0
"""The duration of an axis's green phase in seconds."""
KINDS: Final = tuple(MOVERS)
LANE_KINDS: Final = ("saloon", "hatchback", "van", "truck", "bus")
AVENUE_SHARES: Final = (0.38, 0.29, 0.12, 0.12, 0.09)
SIDE_SHARES: Final = (0.44, 0.34, 0.14, 0.06, 0.02)
LENGTHS_M: Final = {"truck": 9.2, "bus": 12.2, "van": 5.3}
CAR_M: Final = 4.6
STOP_M: Final = 6.2
"""The distance of stop lines from a crossing's carriageway in metres."""
QUEUE_M: Final = 25.0
LIVERIES: Final = {
    "bus": ((0.62, 0.22, 0.16), (0.72, 0.58, 0.24), (0.24, 0.38, 0.52), (0.8, 0.8, 0.78)),
    "truck": ((0.55, 0.22, 0.16), (0.22, 0.3, 0.45), (0.85, 0.85, 0.82), (0.28, 0.38, 0.28), (0.8, 0.8, 0.8)),
    "carriage": ((0.62, 0.16, 0.15),),
    "person": CLOTHES,
    "bicycle": ((0.7, 0.28, 0.18), (0.3, 0.55, 0.6), (0.12, 0.12, 0.13), (0.75, 0.75, 0.74)),
    "motorcycle": ((0.1, 0.1, 0.11), (0.6, 0.12, 0.1), (0.3, 0.32, 0.34), (0.16, 0.24, 0.42)),
}

Places: TypeAlias = tuple[Points, Indices, Points]
"""Grid points (N, 2), the grid axes along which their headings lie (N,), and the signs of these (N,)."""


@dataclass(frozen=True, slots=True)
class Hops:
    """Movers that wait, go on when their axis has green, and wait again."""

    axes: Indices  # of movement: 0 along u, 1 along v (N,); each moves while its axis has green
    across: Points  # the fixed grid coordinate in metres (N,)
    # Positions of the stops along the axis, in order; after the last comes the first again (N, K).
    stops: Points
    counts: Indices  # number of used stops (N,)
    first: Indices  # index of the stop at time 0 (N,)
    signs: Indices  # of the heading along the axis, 0 for movers that turn round (N,)
    back: Points  # distance behind the stops, signed along the axis, in metres (N,)
    delays: Points  # between green and start, in seconds (N,)

    def places(self, time_s: float) -> Places:
        """Return the places at a time in seconds."""
        phase = time_s - self.axes * PHASE_S
        cycle = np.floor(phase / (2 * PHASE_S)).astype(np.int64)
        within = phase - cycle * 2 * PHASE_S
        at = (self.first + cycle) % self.counts
        rows = np.arange(len(at))
        begin, end = self.stops[rows, at], self.stops[rows, (at + 1) % self.counts]
        # Movers that return to the first stop drive on and out of sight instead.
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
    return np.where(t < 0.25, ends, np.where(t > 0.75, 1 - ends, (t - 0.125) * 4 / 3))


@dataclass(frozen=True, slots=True)
class Rounds:
    """Walkers that go round a block, on its pavement."""

    low: Points  # the least corner of each way (N, 2)
    size: Points  # extents of each way along u and v (N, 2)
    starts: Points  # positions along the way at time 0 in metres (N,)
    speeds: Points  # in metres a second, positive if anticlockwise on the grid (N,)

    def places(self, time_s: float) -> Places:
        """Return the places at a time in seconds."""
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
        """Return the places at a time in seconds."""
        along = (self.starts + self.speeds * time_s + HALF_M) % (2 * HALF_M) - HALF_M
        grid = np.stack([self.across, along], axis=1)
        return grid, np.ones(len(along), dtype=np.int64), np.sign(self.speeds)


@dataclass(frozen=True, slots=True)
class Traffic:
    """All movers of a town: first the hops, then the rounds, then the trains."""

    plan: TownPlan  # the town
    hops: Hops  # vehicles, and pedestrians who cross streets
    rounds: Rounds  # pedestrians who walk round blocks
    trains: Trains  # carriages
    kinds: Indices  # index into `KINDS` (N,)
    tints: Reals  # colours (N, 3)
    radii: Reals  # of a sphere around the place on the ground that contains the mover, in metres (N,)

    def poses(self, time_s: float) -> tuple[Reals, Reals]:
        """Return the positions (N, 3) in metres and headings (N,) in radians at a time in seconds."""
        parts = [motion.places(time_s) for motion in (self.hops, self.rounds, self.trains)]
        grid, axes, signs = (np.concatenate(column) for column in zip(*parts, strict=True))
        warp = self.plan.warp
        headings = np.where(axes == 0, warp.headings(grid, 0), warp.headings(grid, 1))
        world = warp.points(grid)
        heights = self.plan.relief.streets(grid)
        railed = len(self.trains.speeds)
        heights[-railed:] = self.plan.relief.railway(grid[-railed:, 1])
        positions = np.column_stack([world, heights])
        return positions.astype(np.float32), (headings + np.where(signs < 0, np.pi, 0)).astype(np.float32)

    def mesh(self, positions: Reals, headings: Reals, seen: Flags) -> Mesh:
        """Return a mesh of the movers that are `seen` (N,) at the given poses."""
        parts: list[Mesh] = []
        for index, name in enumerate(KINDS):
            chosen = np.flatnonzero(seen & (self.kinds == index))
            scales = np.ones((len(chosen), 3), dtype=np.float32)
            parts.append(place(MOVERS[name], positions[chosen], headings[chosen], scales, self.tints[chosen]))
        return join(*parts)


class _Hop(NamedTuple):
    """A mover of `Hops`, and its kind."""

    kind: str
    axis: int
    across: float
    stops: tuple[float, ...]
    first: int
    sign: int
    back: float
    delay: float


@dataclass(frozen=True, slots=True)
class _Lane:
    """A lane of a street in a direction, 1 or -1, at an offset from its middle in metres, with its stop lines."""

    street: Street
    direction: int
    offset: float
    stops: tuple[float, ...]

    def hop(self, kind: str, first: int, back: float, delay: float, aside: float = 0.0) -> _Hop:
        """Return a vehicle `back` metres behind a stop, and `aside` from the lane's middle."""
        across = self.street.at + self.offset + aside
        behind = self.direction * back
        return _Hop(kind, self.street.axis, across, self.stops, first, self.direction, behind, delay)


def _lanes(plan: TownPlan, street: Street, offsets: tuple[float, ...]) -> list[_Lane]:
    """Return a street's lanes; where a street is not open throughout, every queue is a separate lane that waits."""
    lanes = []
    for direction in (1, -1):
        ends = [pair[::direction][1] for pair in plan.stretches(street)[::direction]]
        stops = tuple(other.at - direction * (other.width / 2 + STOP_M) for other in ends)
        runs = [stops] if plan.through(street) else [(stop,) for stop in stops]
        side = direction * street.right
        lanes += [_Lane(street, direction, side * x, run) for x in offsets for run in runs]
    return lanes


def _queues(rng: np.random.Generator, lane: _Lane, cars: float) -> list[_Hop]:
    """Return a lane's queues, with a mean number of vehicles that varies between stop lines."""
    hops = []
    shares = AVENUE_SHARES if lane.street.avenue else SIDE_SHARES
    for first in range(len(lane.stops)):
        back = 0.0
        for index in range(int(rng.poisson(cars * rng.uniform(0.2, 1.8)))):
            kind = str(rng.choice(LANE_KINDS, p=shares))
            length = LENGTHS_M.get(kind, CAR_M)
            if back + length > QUEUE_M:
                break
            hops.append(lane.hop(kind, first, back + length / 2, 1.1 * index))
            back += length + rng.uniform(1.3, 3.5)
    return hops


def _packs(rng: np.random.Generator, lane: _Lane, share: float) -> list[_Hop]:
    """Return packs of two to five two-wheelers by the kerb, before a share of the stop lines."""
    hops = []
    for first in range(len(lane.stops)):
        if rng.random() < share:
            kind = "bicycle" if rng.random() < 0.55 else "motorcycle"
            for index in range(int(rng.integers(2, 6))):
                aside = rng.uniform(0, 0.35) * (1 if index % 2 else -1)
                hops.append(lane.hop(kind, first, 1.2 + 2.3 * index, 0.5 * index, aside))
    return hops


def _crossers(rng: np.random.Generator, plan: TownPlan, street: Street) -> list[_Hop]:
    """Return groups on a street's zebra crossings, who cross while its vehicles stand."""
    hops = []
    ends = (street.at - street.width / 2 - 0.9, street.at + street.width / 2 + 0.9)
    for before, after in plan.stretches(street):
        for side, other in ((1, before), (-1, after)):
            if not has_zebra(street, other) or rng.random() < 0.3:
                continue
            middle, first = other.at + side * (other.width / 2 + 2.4), int(rng.integers(2))
            for _ in range(int(rng.integers(1, 6))):
                across, back = middle + rng.uniform(-1.3, 1.3), rng.uniform(-0.5, 0.5)
                delay = rng.uniform(0, 4)
                hops.append(_Hop("person", 1 - street.axis, across, ends, first, 0, back, delay))
    return hops


def _street(rng: np.random.Generator, plan: TownPlan, street: Street) -> list[_Hop]:
    offsets = (street.width / 8, street.width * 3 / 8 - 0.5) if street.avenue else (street.width / 4 - 0.2,)
    cars = rng.uniform(0.9, 2.0) if street.avenue else rng.uniform(0.15, 0.9)
    hops = [hop for lane in _lanes(plan, street, offsets) for hop in _queues(rng, lane, cars)]
    kerb = (street.width / 2 - 0.6,)
    hops += [hop for lane in _lanes(plan, street, kerb) for hop in _packs(rng, lane, 0.3)]
    return hops + _crossers(rng, plan, street)


def _walkers(rng: np.random.Generator, plan: TownPlan) -> Rounds:
    """Return groups of one to four who walk round the blocks together."""
    rows: list[tuple[float, ...]] = []
    for block in plan.blocks:
        busy = block.kind in (BlockKind.PLAZA, BlockKind.TOWERS, BlockKind.PERIMETER)
        for _ in range(int(rng.poisson(10 if busy else 6))):
            out, speed = rng.uniform(0.5, 0.9), rng.uniform(0.9, 1.6)
            direction = 1 - 2 * int(rng.integers(2))
            start = rng.uniform(0, 2 * sum(block.size))
            for _ in range(min(4, int(rng.geometric(0.5)))):
                aside = out + rng.uniform(-0.45, 0.45)
                size = (block.size[0] + 2 * aside, block.size[1] + 2 * aside)
                low = (block.low[0] - aside, block.low[1] - aside)
                rows.append((*low, *size, start + rng.uniform(-0.9, 0.9), direction * speed))
    table = np.array(rows)
    return Rounds(table[:, :2], table[:, 2:4], table[:, 4], table[:, 5])


def _trains(rng: np.random.Generator, plan: TownPlan) -> Trains:
    rows = [
        (plan.relief.rail + track, start + 23.0 * place_in_train, direction * 14.0)
        for track, direction in ((-2.3, -1), (2.3, 1))
        for start in (rng.uniform(-430, -150), rng.uniform(0, 200))
        for place_in_train in range(5)
    ]
    return Trains(*np.array(rows).T)


def _tints(rng: np.random.Generator, kinds: Indices) -> Reals:
    tints = np.empty((len(kinds), 3))
    for row, kind in enumerate(kinds):
        palette = LIVERIES.get(KINDS[kind], CAR_TINTS)
        tints[row] = palette[int(rng.integers(len(palette)))]
    return np.clip(tints * rng.uniform(0.85, 1.1, (len(kinds), 1)), 0, 1).astype(np.float32)


def _hops(rows: list[_Hop]) -> Hops:
    _, axes, across, stops, *others = zip(*rows, strict=True)
    filled = np.array(list(zip_longest(*stops, fillvalue=0.0))).T
    counts = [len(positions) for positions in stops]
    return Hops(np.array(axes), np.array(across), filled, np.array(counts), *map(np.array, others))


def make_traffic(plan: TownPlan) -> Traffic:
    """Return the traffic of a town; the same plan gives the same traffic."""
    rng = generator(plan.number, "town", "traffic")
    rows = [row for street in plan.streets for row in _street(rng, plan, street)]
    rounds, trains = _walkers(rng, plan), _trains(rng, plan)
    names = [row.kind for row in rows] + ["person"] * len(rounds.speeds) + ["carriage"] * len(trains.speeds)
    kinds = np.array([KINDS.index(name) for name in names])
    radii = np.array([np.linalg.norm(MOVERS[name].triangles, axis=-1).max() for name in KINDS], np.float32)
    return Traffic(plan, _hops(rows), rounds, trains, kinds, _tints(rng, kinds), radii[kinds])
