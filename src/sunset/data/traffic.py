"""What moves in a town, and where it is at any moment."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.data.frame import Reals
from sunset.data.layout import PAVEMENT_M, Street, TownPlan
from sunset.data.meshes import Mesh, join, place
from sunset.data.vehicles import MOVERS, mover
from sunset.seeding import generator

__all__ = ["Traffic", "make_traffic"]

HALF_M: Final = 430.0
LOOP_M: Final = 2 * HALF_M
KINDS: Final = tuple(MOVERS)
LANE_KINDS: Final = ("saloon", "hatchback", "van", "truck", "bus")
LANE_SHARES: Final = (0.38, 0.29, 0.13, 0.11, 0.09)
PAINTS: Final = np.array(
    [
        (0.85, 0.85, 0.86), (0.1, 0.1, 0.12), (0.5, 0.52, 0.54), (0.62, 0.08, 0.08), (0.1, 0.2, 0.48),
        (0.25, 0.27, 0.3), (0.9, 0.9, 0.88), (0.12, 0.32, 0.2), (0.72, 0.55, 0.1), (0.38, 0.1, 0.14),
    ]
)  # fmt: skip
LIVERIES: Final = {
    "bus": np.array([(0.86, 0.2, 0.12), (0.9, 0.66, 0.1), (0.12, 0.42, 0.66)]),
    "truck": np.array([(0.8, 0.2, 0.1), (0.15, 0.3, 0.6), (0.85, 0.85, 0.82), (0.2, 0.45, 0.25)]),
    "carriage": np.array([(0.75, 0.12, 0.12), (0.15, 0.3, 0.55)]),
    "person": np.array(
        [
            (0.85, 0.2, 0.2),
            (0.9, 0.85, 0.3),
            (0.2, 0.4, 0.85),
            (0.9, 0.9, 0.9),
            (0.3, 0.7, 0.4),
            (0.8, 0.4, 0.7),
        ]
    ),
    "bicycle": np.array([(0.9, 0.3, 0.15), (0.2, 0.75, 0.8), (0.9, 0.8, 0.2)]),
}


@dataclass(frozen=True, slots=True)
class Traffic:
    """Everything that moves, each along a straight line of the grid at constant speed, round and round.

    Attributes:
        plan: the town.
        kinds: index into the kinds of movers (N,).
        axes: 0 along u, 1 along v (N,).
        across: the fixed grid coordinate in metres (N,).
        starts: position along the axis at time 0, in metres (N,).
        speeds: signed, in metres a second (N,).
        tints: colours (N, 3).
    """

    plan: TownPlan
    kinds: npt.NDArray[np.int64]
    axes: npt.NDArray[np.int64]
    across: npt.NDArray[np.float64]
    starts: npt.NDArray[np.float64]
    speeds: npt.NDArray[np.float64]
    tints: Reals

    def poses(self, time_s: float) -> tuple[Reals, Reals]:
        """Return the positions (N, 3) in metres and headings (N,) in radians at a time in seconds."""
        along = (self.starts + self.speeds * time_s + HALF_M) % LOOP_M - HALF_M
        grid = np.where(
            self.axes[:, None] == 0,
            np.stack([along, self.across], axis=1),
            np.stack([self.across, along], axis=1),
        )
        headings = np.where(
            self.axes == 0, self.plan.warp.headings(grid, 0), self.plan.warp.headings(grid, 1)
        ) + np.where(self.speeds < 0, np.pi, 0.0)
        world = self.plan.warp.points(grid)
        positions = np.column_stack([world, np.zeros(len(world))])
        return positions.astype(np.float32), headings.astype(np.float32)

    def mesh(self, positions: Reals, headings: Reals, seen: npt.NDArray[np.bool_]) -> Mesh:
        """Return one mesh of those that are `seen` (N,) at the given poses."""
        parts = []
        for index, name in enumerate(KINDS):
            chosen = np.flatnonzero(seen & (self.kinds == index))
            if len(chosen):
                scales = np.ones((len(chosen), 3), dtype=np.float32)
                parts.append(
                    place(mover(name), positions[chosen], headings[chosen], scales, self.tints[chosen])
                )
        return join(parts)


Row = tuple[int, int, float, float, float]


def _lane(rng: np.random.Generator, street: Street, offset: float, speed: float) -> list[Row]:
    rows: list[Row] = []
    at = -HALF_M + float(rng.uniform(0, 20))
    while at < HALF_M - 20:
        kind = str(rng.choice(LANE_KINDS, p=LANE_SHARES))
        rows.append((KINDS.index(kind), street.axis, street.at + offset, at, speed))
        at += float(rng.uniform(14, 42)) + (8 if kind in ("bus", "truck") else 0)
    return rows


def _walkers(rng: np.random.Generator, street: Street) -> list[Row]:
    person = KINDS.index("person")
    rows: list[Row] = []
    for side in (-1, 1):
        for _ in range(int(rng.integers(5, 10))):
            speed = float(rng.uniform(0.9, 1.6)) * (1 if rng.random() < 0.5 else -1)  # noqa: PLR2004  a coin
            start = float(rng.uniform(-HALF_M, HALF_M))
            for _ in range(int(rng.integers(3, 9))):
                offset = side * (street.width / 2 + float(rng.uniform(2.0, PAVEMENT_M - 0.3)))
                at = street.at + offset
                rows.append((person, street.axis, at, start + float(rng.uniform(-2.2, 2.2)), speed))
    return rows


def _street(rng: np.random.Generator, street: Street) -> list[Row]:
    rows: list[Row] = []
    # Right-hand traffic: along u, growing positions keep to the smaller v; along v, to the larger u.
    right = -1 if street.axis == 0 else 1
    offsets = (street.width / 8, street.width * 3 / 8) if street.avenue else (street.width / 4,)
    for direction in (1, -1):
        for offset in offsets:
            speed = direction * float(rng.uniform(6, 11))
            rows += _lane(rng, street, direction * right * offset, speed)
        rows += _pack(rng, street, direction, direction * right * (street.width / 2 - 0.7))
    return rows + _walkers(rng, street)


def _pack(rng: np.random.Generator, street: Street, direction: int, offset: float) -> list[Row]:
    """Two-wheelers ride in packs of four to seven along the kerb."""
    rows: list[Row] = []
    at = -HALF_M + float(rng.uniform(0, 500))
    while at < HALF_M - 30:
        kind = KINDS.index("bicycle" if rng.random() < 0.55 else "motorcycle")  # noqa: PLR2004  a share
        for place_in_pack in range(int(rng.integers(4, 8))):
            across = street.at + offset + (0.45 if place_in_pack % 2 else -0.45)
            rows.append((kind, street.axis, across, at + 1.5 * place_in_pack, direction * 5.5))
        at += float(rng.uniform(280, 620))
    return rows


def _trains(rng: np.random.Generator, plan: TownPlan) -> list[Row]:
    carriage = KINDS.index("carriage")
    rows: list[Row] = []
    for track, direction in ((-2.3, -1), (2.3, 1)):
        for start in (float(rng.uniform(-430, -150)), float(rng.uniform(0, 200))):
            rows += [
                (carriage, 1, plan.rail + track, start + 23.0 * place_in_train, direction * 14.0)
                for place_in_train in range(5)
            ]
    return rows


def _tints(rng: np.random.Generator, kinds: npt.NDArray[np.int64]) -> Reals:
    tints = np.empty((len(kinds), 3))
    for row, kind in enumerate(kinds):
        palette = LIVERIES.get(KINDS[kind], PAINTS)
        tints[row] = palette[int(rng.integers(len(palette)))]
    return np.clip(tints * rng.uniform(0.85, 1.1, (len(kinds), 1)), 0, 1).astype(np.float32)


def make_traffic(plan: TownPlan) -> Traffic:
    """Return the traffic of a town; the same plan gives the same traffic."""
    rng = generator(plan.number, "town", "traffic")
    rows = [row for street in plan.streets for row in _street(rng, street)] + _trains(rng, plan)
    kinds, axes, across, starts, speeds = (np.array(column) for column in zip(*rows, strict=True))
    return Traffic(plan, kinds, axes, across, starts, speeds, _tints(rng, kinds))
