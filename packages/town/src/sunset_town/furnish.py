"""Placing things in a town, with the solid things apart."""

from collections.abc import Callable, Sequence
from typing import Final, TypeAlias

import cv2
import numpy as np

from sunset_town.frame import Ids, Pair, Points, Reals
from sunset_town.ground import Ground, Surface
from sunset_town.layout import EXTENT_M, TownPlan
from sunset_town.meshes import WHITE, Colour, Mesh, place
from sunset_town.seeding import generator
from sunset_town.things import BUSH, LEAFY_TREES, THINGS, TREES

Place: TypeAlias = Sequence[float] | Points
CELL_M: Final = 0.5
MARGIN: Final = 3
PARKED: Final = ("saloon", "hatchback", "van")
CAR_TINTS: Final[tuple[Colour, ...]] = (
    (0.86, 0.86, 0.86),
    (0.82, 0.82, 0.82),
    (0.72, 0.73, 0.74),
    (0.6, 0.61, 0.62),
    (0.45, 0.46, 0.48),
    (0.3, 0.31, 0.33),
    (0.12, 0.12, 0.13),
    (0.08, 0.08, 0.09),
    (0.42, 0.12, 0.12),
    (0.16, 0.22, 0.36),
    (0.24, 0.3, 0.27),
    (0.5, 0.44, 0.36),
)
CLOTHES: Final[tuple[Colour, ...]] = (
    (0.14, 0.18, 0.32),
    (0.1, 0.1, 0.11),
    (0.42, 0.43, 0.45),
    (0.66, 0.6, 0.5),
    (0.84, 0.84, 0.82),
    (0.42, 0.13, 0.16),
    (0.32, 0.34, 0.2),
    (0.8, 0.28, 0.18),
)
BINS: Final = ((0.3, 0.38, 0.3), (0.55, 0.48, 0.25), (0.26, 0.32, 0.42), (0.45, 0.28, 0.2), (0.5, 0.5, 0.48))
LEAVES: Final[tuple[Colour, ...]] = (
    (0.22, 0.33, 0.12),
    (0.28, 0.38, 0.15),
    (0.34, 0.38, 0.14),
    (0.18, 0.3, 0.15),
    (0.4, 0.38, 0.16),
)
CARRIED: Final = (Surface.ASPHALT, Surface.MARKING, Surface.PAVING, Surface.KERB, Surface.DECK)
STREET_SURFACES: Final = (*CARRIED, Surface.WATER, Surface.BALLAST)
EDGE_M: Final = 345.0
"""Greatest distance in x and y of buildings from the town's centre, in metres."""
COUNTRY_M: Final = 800.0
"""The same of bushes, which also grow outside the town."""
CORNERS: Final = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
NO_TREES: Final = (*STREET_SURFACES, Surface.PATH, Surface.RAIL, Surface.SLEEPER)


class Builder:
    """Collects the things that stand in a town, and keeps the solid things apart."""

    def __init__(self, plan: TownPlan, ground: Ground) -> None:
        self.plan = plan
        self.ground = ground
        self.rng = generator(plan.number, "town", "things")
        self.meshes: list[Mesh] = []
        self._rows: dict[str, list[tuple[float, ...]]] = {}
        cells = int(2 * EXTENT_M / CELL_M)
        self._taken: Ids = np.zeros((cells, cells), dtype=np.uint8)
        shift = generator(plan.number, "town", "leaves").uniform(0.85, 1.15, 3)
        self._leaves = np.asarray(LEAVES) * shift

    def put(
        self,
        name: str,
        uv: Place,
        *,
        axis: int = 0,
        turn: float = 0.0,
        scale: Place = WHITE,
        tint: Place = WHITE,
        height: float = np.nan,
    ) -> None:
        """Stand a thing at a grid point, facing along a grid axis plus `turn`.

        Without a height in metres, it stands on the ground or the street.
        """
        self._rows.setdefault(name, []).append((*uv, height, axis, turn, *scale, *tint))

    def tree(self, uv: Place, height: float, kind: int | None = None) -> None:
        """Plant a tree of a height in metres where the ground is free."""
        x, y = self.plan.warp.points(uv)
        if self._blocked(x, y) or int(self.ground.at(x, y)) in NO_TREES:
            return
        kind = self.kind() if kind is None else kind
        leaf = self._leaves[int(self.rng.integers(len(LEAVES)))] * self.rng.uniform(0.85, 1.15)
        width = height * self.rng.uniform(0.85, 1.15)
        self.put(f"tree {kind}", uv, turn=self.rng.uniform(0, 6.28), scale=(width, width, height), tint=leaf)

    def kind(self) -> int:
        """Draw a kind of tree, seldom a conifer."""
        return int(self.rng.integers(LEAFY_TREES if self.chance(0.88) else TREES - 1))

    def car(self, uv: Place, axis: int) -> None:
        """Park a car along a grid axis."""
        name = PARKED[int(self.rng.integers(len(PARKED)))]
        tint = CAR_TINTS[int(self.rng.integers(len(CAR_TINTS)))]
        turn = np.pi * int(self.rng.integers(2)) + self.rng.normal(0, 0.03)
        self.put(name, uv, axis=axis, turn=turn, tint=tint)

    def crowd(self, uv: Place, count: int, spread: float) -> None:
        """Let people stand about a grid point, most of them within `spread` metres."""
        for _ in range(count):
            spot = np.asarray(uv) + self.rng.normal(0, spread, 2)
            tint = CLOTHES[int(self.rng.integers(len(CLOTHES)))]
            self.put("person", spot, turn=self.rng.uniform(0, 6.28), tint=tint)

    def skip(self, uv: Place, name: str = "skip", axis: int = 0) -> None:
        """Stand a rubbish skip or a container."""
        turn, tint = self.rng.normal(0, 0.1), BINS[int(self.rng.integers(len(BINS)))]
        self.put(name, uv, axis=axis, turn=turn, tint=tint)

    def chance(self, share: float) -> bool:
        """Return true in a share of all cases."""
        return bool(self.rng.random() < share)

    def line(
        self,
        name: str,
        start: Pair,
        end: Pair,
        height: float,
        *,
        tint: Colour = WHITE,
        level: Callable[[Pair], float] | None = None,
    ) -> None:
        """Put up a fence, wall or rail between two grid points that differ in one coordinate.

        It stands on the ground or the street, or at the heights that `level` returns for grid points.
        """
        axis = 0 if abs(end[0] - start[0]) > abs(end[1] - start[1]) else 1
        length = abs(end[axis] - start[axis])
        pieces = max(1, round(length / 5))
        for at in (np.arange(pieces) + 0.5) / pieces:
            uv = (start[0] + (end[0] - start[0]) * float(at), start[1] + (end[1] - start[1]) * float(at))
            base = np.nan if level is None else level(uv)
            scale = (length / pieces * 1.03, 1.0, height)
            self.put(name, uv, axis=axis, scale=scale, tint=tint, height=base)

    def build(
        self,
        make: Callable[[np.random.Generator, Pair], Mesh],
        uv: Pair,
        size: Pair,
        *,
        turned: bool = False,
    ) -> bool:
        """Put up a building of a footprint in metres if it stands free; return whether it does."""
        centre = self.plan.warp.points(uv)
        yaw = float(self.plan.warp.headings(uv, 0)) + (np.pi / 2 if turned else 0.0)
        local = CORNERS * np.asarray(size) / 2
        cos, sin = np.cos(yaw), np.sin(yaw)
        turned_x, turned_y = local[:, 0] * cos - local[:, 1] * sin, local[:, 0] * sin + local[:, 1] * cos
        corners = np.stack([turned_x, turned_y], axis=1) + centre
        inside = np.abs(corners).max() < EDGE_M
        samples = np.concatenate([corners, (corners + np.roll(corners, 1, axis=0)) / 2])
        if not inside or np.isin(self.ground.at(samples[:, 0], samples[:, 1]), STREET_SURFACES).any():
            return False
        cells = np.round((corners + EXTENT_M) / CELL_M).astype(np.int32)
        cv2.fillPoly(self._taken, [cells], 1)
        reach = np.array(size[::-1] if turned else size) / 2
        around = np.asarray(uv) + reach * CORNERS
        position = np.array([[*centre, self.plan.relief.ground(around).min()]], dtype=np.float32)
        ones = np.ones((1, 3), dtype=np.float32)
        self.meshes.append(place(make(self.rng, size), position, np.array([yaw], np.float32), ones, ones))
        return True

    def _blocked(self, x: float, y: float) -> bool:
        column, row = int((x + EXTENT_M) / CELL_M), int((y + EXTENT_M) / CELL_M)
        size = len(self._taken)
        if not (min(column, row) >= MARGIN and max(column, row) < size - MARGIN):
            return False
        return bool(self._taken[row - MARGIN : row + MARGIN + 1, column - MARGIN : column + MARGIN + 1].any())

    def _stand(self, table: Points) -> tuple[Reals, Reals]:
        """Return the positions of things (N, 3) and their headings (N,)."""
        uv, axes = table[:, :2], table[:, 3]
        world, relief = self.plan.warp.points(uv), self.plan.relief
        carried = np.isin(self.ground.at(world[:, 0], world[:, 1]), CARRIED)
        heights = np.where(carried, relief.streets(uv), relief.ground(uv))
        heights = np.where(np.isnan(table[:, 2]), heights, table[:, 2])
        headings = [self.plan.warp.headings(uv, axis) for axis in (0, 1)]
        yaws = np.where(axes == 0, *headings) + table[:, 4]
        return np.column_stack([world, heights]).astype(np.float32), yaws.astype(np.float32)

    def finish(self) -> list[Mesh]:
        """Return the meshes of everything that was put up."""
        for name, rows in self._rows.items():
            table = np.array(rows)
            positions, yaws = self._stand(table)
            reach = COUNTRY_M if name == f"tree {BUSH}" else EDGE_M
            inside = np.abs(positions[:, :2]).max(axis=1) < reach
            table = table[inside].astype(np.float32)
            scales, tints = table[:, 5:8], table[:, 8:11]
            self.meshes.append(place(THINGS[name], positions[inside], yaws[inside], scales, tints))
        return self.meshes
