"""Fills a town's blocks: buildings, trees, parked cars, and everything else that stands still."""

from collections.abc import Callable
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from sunset.data.buildings import apartment, hall, house, tower
from sunset.data.ground import Ground, Surface, parking_stalls
from sunset.data.layout import EXTENT_M, Block, BlockKind, TownPlan
from sunset.data.meshes import Colour, Mesh, place
from sunset.data.props import PROPS, TREES, tree
from sunset.data.props import prop as prop_mesh
from sunset.data.vehicles import mover
from sunset.seeding import generator

__all__ = ["Builder", "furnish_blocks"]

CELL_M: Final = 0.5
MARGIN: Final = 3
WHITE: Final[Colour] = (1.0, 1.0, 1.0)
PARKED: Final = ("saloon", "hatchback", "van")
CAR_TINTS: Final[tuple[Colour, ...]] = (
    (0.8, 0.8, 0.82),
    (0.12, 0.12, 0.13),
    (0.5, 0.51, 0.53),
    (0.58, 0.1, 0.1),
    (0.12, 0.22, 0.45),
    (0.3, 0.33, 0.3),
)
BINS: Final[tuple[Colour, ...]] = ((0.2, 0.42, 0.24), (0.75, 0.6, 0.12), (0.2, 0.32, 0.6), (0.62, 0.25, 0.15))
LEAVES: Final[tuple[Colour, ...]] = (
    (0.22, 0.33, 0.12),
    (0.28, 0.38, 0.15),
    (0.34, 0.38, 0.14),
    (0.18, 0.3, 0.15),
    (0.4, 0.38, 0.16),
)
STREET_SURFACES: Final = (
    Surface.ASPHALT,
    Surface.MARKING,
    Surface.PAVING,
    Surface.KERB,
    Surface.WATER,
    Surface.DECK,
    Surface.BALLAST,
)
CARRIED: Final = (Surface.ASPHALT, Surface.MARKING, Surface.PAVING, Surface.KERB, Surface.DECK)
NO_TREES: Final = (*STREET_SURFACES, Surface.PATH, Surface.RAIL, Surface.SLEEPER)


class Builder:
    """Collects what stands in a town, keeping solid things apart."""

    def __init__(self, plan: TownPlan, ground: Ground) -> None:
        self.plan = plan
        self.ground = ground
        self.rng = generator(plan.number, "town", "things")
        self.meshes: list[Mesh] = []
        self._rows: dict[str, list[tuple[float, ...]]] = {}
        cells = int(2 * EXTENT_M / CELL_M)
        self._taken: npt.NDArray[np.uint8] = np.zeros((cells, cells), dtype=np.uint8)
        shift = generator(plan.number, "town", "leaves").uniform(0.85, 1.15, 3)
        self._leaves = np.asarray(LEAVES) * shift

    def put(
        self,
        name: str,
        uv: tuple[float, float],
        *,
        axis: int = 0,
        turn: float = 0.0,
        scale: Colour = WHITE,
        tint: Colour = WHITE,
        lift: float = 0.0,
    ) -> None:
        """Stand a prop, tree or parked vehicle at a grid point, facing along a grid axis plus `turn`.

        It stands `lift` metres above the ground or the street there.
        """
        x, y = self.plan.warp.points(uv)
        if max(abs(x), abs(y)) < EXTENT_M:
            yaw = float(self.plan.warp.headings(uv, axis)) + turn
            relief = self.plan.relief
            on_street = self.ground.at(x, y) in CARRIED
            z = float(relief.streets(uv) if on_street else relief.ground(uv)) + lift
            self._rows.setdefault(name, []).append((x, y, z, yaw, *scale, *tint))

    def tree(self, uv: tuple[float, float], height: float, kind: int | None = None) -> None:
        """Plant a tree of a height in metres where the ground is free."""
        x, y = self.plan.warp.points(uv)
        if self._blocked(x, y) or self.ground.at(x, y) in NO_TREES:
            return
        kind = int(self.rng.integers(TREES - 1)) if kind is None else kind
        leaf = self._leaves[int(self.rng.integers(len(LEAVES)))] * self.rng.uniform(0.85, 1.15)
        width = height * float(self.rng.uniform(0.85, 1.15))
        tint = (float(leaf[0]), float(leaf[1]), float(leaf[2]))
        self.put(
            f"tree {kind}", uv, turn=float(self.rng.uniform(0, 6.28)), scale=(width, width, height), tint=tint
        )

    def car(self, uv: tuple[float, float], axis: int) -> None:
        """Park a car along a grid axis."""
        name = PARKED[int(self.rng.integers(len(PARKED)))]
        tint = CAR_TINTS[int(self.rng.integers(len(CAR_TINTS)))]
        turn = np.pi * int(self.rng.integers(2)) + float(self.rng.normal(0, 0.03))
        self.put(name, uv, axis=axis, turn=turn, tint=tint)

    def skip(self, uv: tuple[float, float], name: str = "skip", axis: int = 0) -> None:
        """Stand a rubbish skip or a container."""
        self.put(
            name,
            uv,
            axis=axis,
            turn=float(self.rng.normal(0, 0.1)),
            tint=BINS[int(self.rng.integers(len(BINS)))],
        )

    def chance(self, share: float) -> bool:
        """Draw whether something is so, which it is in a share of all cases."""
        return bool(self.rng.random() < share)

    def line(
        self,
        name: str,
        start: tuple[float, float],
        end: tuple[float, float],
        height: float,
        tint: Colour = WHITE,
    ) -> None:
        """Put up a fence, wall or rail between two grid points that differ in one coordinate."""
        axis = 0 if abs(end[0] - start[0]) > abs(end[1] - start[1]) else 1
        length = abs(end[axis] - start[axis])
        pieces = max(1, round(length / 5))
        for at in (np.arange(pieces) + 0.5) / pieces:
            uv = (start[0] + (end[0] - start[0]) * float(at), start[1] + (end[1] - start[1]) * float(at))
            self.put(name, uv, axis=axis, scale=(length / pieces * 1.03, 1.0, height), tint=tint)

    def build(
        self,
        make: Callable[[np.random.Generator, tuple[float, float]], Mesh],
        uv: tuple[float, float],
        size: tuple[float, float],
        *,
        turned: bool = False,
    ) -> bool:
        """Put up a building of a footprint in metres if it stands free; say whether it does."""
        centre = self.plan.warp.points(uv)
        yaw = float(self.plan.warp.headings(uv, 0)) + (np.pi / 2 if turned else 0.0)
        corners = self._footprint(centre, yaw, size)
        inside = np.abs(corners).max() < EXTENT_M - 2
        samples = np.concatenate([corners, (corners + np.roll(corners, 1, axis=0)) / 2])
        if not inside or np.isin(self.ground.at(samples[:, 0], samples[:, 1]), STREET_SURFACES).any():
            return False
        cells = np.round((corners + EXTENT_M) / CELL_M).astype(np.int32)
        cv2.fillPoly(self._taken, [cells], 1)
        reach = np.array(size[::-1] if turned else size) / 2
        around = np.asarray(uv) + reach * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
        position = np.array([[*centre, self.plan.relief.ground(around).min()]], dtype=np.float32)
        ones = np.ones((1, 3), dtype=np.float32)
        self.meshes.append(place(make(self.rng, size), position, np.array([yaw], np.float32), ones, ones))
        return True

    @staticmethod
    def _footprint(
        centre: npt.NDArray[np.float64], yaw: float, size: tuple[float, float]
    ) -> npt.NDArray[np.float64]:
        local = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * np.asarray(size) / 2
        cos, sin = np.cos(yaw), np.sin(yaw)
        turned = np.stack(
            [local[:, 0] * cos - local[:, 1] * sin, local[:, 0] * sin + local[:, 1] * cos], axis=1
        )
        return turned + centre

    def _blocked(self, x: float, y: float) -> bool:
        column, row = int((x + EXTENT_M) / CELL_M), int((y + EXTENT_M) / CELL_M)
        size = len(self._taken)
        if not (min(column, row) >= MARGIN and max(column, row) < size - MARGIN):
            return False
        return bool(self._taken[row - MARGIN : row + MARGIN + 1, column - MARGIN : column + MARGIN + 1].any())

    def finish(self) -> list[Mesh]:
        """Return the meshes of everything that was put up."""
        for name, rows in self._rows.items():
            table = np.array(rows, dtype=np.float32)
            mesh = (
                prop_mesh(name)
                if name in PROPS
                else tree(int(name[5:]))
                if name[:4] == "tree"
                else mover(name)
            )
            self.meshes.append(place(mesh, table[:, :3], table[:, 3], table[:, 4:7], table[:, 7:10]))
        return self.meshes


def _scatter(builder: Builder, block: Block, per_100_m2: float, heights: tuple[float, float]) -> None:
    rng = builder.rng
    for _ in range(int(block.size[0] * block.size[1] / 100 * per_100_m2)):
        uv = (
            float(rng.uniform(block.low[0] + 2, block.high[0] - 2)),
            float(rng.uniform(block.low[1] + 2, block.high[1] - 2)),
        )
        builder.tree(uv, float(rng.uniform(*heights)))


def _perimeter(builder: Builder, block: Block) -> None:
    """Flats along the two long edges and part of the short ones, a planted yard between."""
    rng, depth = builder.rng, 12.0
    (u0, v0), (u1, v1) = block.low, block.high
    for v in (v0 + depth / 2 + 0.8, v1 - depth / 2 - 0.8):
        u = u0 + 0.8
        while u < u1 - 10:
            length = min(float(rng.uniform(13, 24)), u1 - 0.8 - u)
            builder.build(apartment, (u + length / 2, v), (length - 0.4, depth))
            u += length
    inner = v1 - v0 - 2 * depth - 6
    if inner > 12:  # noqa: PLR2004  room for one more building
        for u in (u0 + depth / 2 + 0.8, u1 - depth / 2 - 0.8):
            if builder.chance(0.6):
                builder.build(apartment, (u, (v0 + v1) / 2), (inner, depth), turned=True)
    _scatter(builder, block, 1.3, (5, 10))
    builder.skip(((u0 + u1) / 2, (v0 + v1) / 2 + 4), "container")


def _towers(builder: Builder, block: Block) -> None:
    rng = builder.rng
    (u0, v0), (u1, v1) = block.low, block.high
    count = 2 if block.size[0] > 52 else 1  # noqa: PLR2004  metres for two towers
    for index in range(count):
        u = u0 + (u1 - u0) * (index + 0.5) / count
        size = (float(rng.uniform(15, 19)), float(rng.uniform(16, 24)))
        builder.build(tower, (u, (v0 + v1) / 2 + float(rng.uniform(-4, 4))), size)
    _scatter(builder, block, 0.9, (4, 8))
    for u in np.arange(u0 + 14, u1 - 12, 8.0).tolist():
        builder.put("planter", (u, v0 + 3.5))


def _houses(builder: Builder, block: Block) -> None:
    """Two rows of gardens, each with a house, a hedge or fence, trees and a car."""
    rng = builder.rng
    (u0, v0), (u1, v1) = block.low, block.high
    middle, count = (v0 + v1) / 2, max(1, int((u1 - u0) / 16))
    plot = (u1 - u0) / count
    for row, front in ((-1, v0), (1, v1)):
        for index in range(count):
            u = u0 + plot * (index + 0.5)
            size = (float(rng.uniform(8.5, 10.5)), float(rng.uniform(7.5, 9.5)))
            builder.build(house, (u - 1.5, front - row * (size[1] / 2 + 4)), size, turned=builder.chance(0.3))
            if builder.chance(0.75):
                builder.car((u + plot / 2 - 2.2, front - row * 4), 1)
            edge = "hedge" if builder.chance(0.4) else "fence"
            tint = (0.9, 0.88, 0.84) if builder.chance(0.5) else (0.45, 0.32, 0.22)
            builder.line(edge, (u + plot / 2, front - row * 7), (u + plot / 2, middle), 1.7, tint)
            builder.line(
                edge, (u - plot / 2, front - row * 0.4), (u + plot / 2 - 4, front - row * 0.4), 1.1, tint
            )
    builder.line("fence", (u0, middle), (u1, middle), 1.8, (0.5, 0.36, 0.25))
    _scatter(builder, block, 1.5, (3.5, 8))


def _park(builder: Builder, block: Block) -> None:
    rng = builder.rng
    _scatter(builder, block, 1.9, (5, 13))
    (u0, v0), (u1, v1) = block.low, block.high
    for _ in range(25):
        builder.tree(
            (float(rng.uniform(u0, u1)), float(rng.uniform(v0, v1))), float(rng.uniform(1, 2.2)), TREES - 1
        )
    if block.index % 2:
        for start, end in (((u0, v0), (u1, v0)), ((u0, v1), (u1, v1))):
            builder.line("hedge", (start[0] + 4, start[1]), (end[0] - 4, end[1]), 1.2)


def _plaza(builder: Builder, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    centre = ((u0 + u1) / 2, (v0 + v1) / 2)
    builder.put("monument", centre)
    for u in np.arange(u0 + 5, u1 - 4, 9.0).tolist():
        builder.tree((u, v0 + 4), 6.5, 1)
        builder.tree((u, v1 - 4), 6.5, 2)
    for u, v in ((u0 + 8, centre[1] + 8), (u1 - 8, centre[1] - 8), (u0 + 10, centre[1] - 9)):
        builder.put("kiosk", (u, v), turn=float(builder.rng.uniform(0, 3)))
        builder.put("planter", (u + 5, v))


def _parking(builder: Builder, block: Block) -> None:
    """Cars stand close together at one end and ever fewer towards the other; some rows are empty."""
    stalls = parking_stalls(block)
    nearness = np.abs(stalls - np.asarray(block.low if builder.chance(0.5) else block.high)).sum(axis=1)
    share = float(builder.rng.uniform(0.4, 0.9)) * (1 - 0.85 * nearness / nearness.max())
    for stall, filled in zip(stalls, share, strict=True):
        if builder.chance(float(filled)):
            builder.car((float(stall[0]), float(stall[1])), 1)
    (u0, v0), (u1, v1) = block.low, block.high
    builder.line("rail guard", (u0 + 0.6, v0 + 2), (u0 + 0.6, v1 - 2), 0.8)
    builder.line("rail guard", (u1 - 0.6, v0 + 2), (u1 - 0.6, v1 - 2), 0.8)


def _industry(builder: Builder, block: Block) -> None:
    rng = builder.rng
    (u0, v0), (u1, v1) = block.low, block.high
    depth = (v1 - v0) * 0.5
    builder.build(hall, ((u0 + u1) / 2, v0 + depth / 2 + 4), (u1 - u0 - 9, depth))
    for u in np.arange(u0 + 6, u1 - 5, 4.2).tolist():
        chance = float(rng.random())
        if chance < 0.4:  # noqa: PLR2004  a share
            builder.put("truck", (u, v1 - 9), axis=1, tint=CAR_TINTS[int(rng.integers(len(CAR_TINTS)))])
        elif chance < 0.8:  # noqa: PLR2004  a share
            builder.skip((u, v1 - 8), "container", 1)
    for start, end in (
        ((u0, v1), (u1 - 9, v1)),
        ((u0, v0), (u1, v0)),
        ((u0, v0), (u0, v1)),
        ((u1, v0), (u1, v1)),
    ):
        builder.line("wall", start, end, 2.4, (0.62, 0.5, 0.42))


def _site(builder: Builder, block: Block) -> None:
    rng = builder.rng
    (u0, v0), (u1, v1) = block.low, block.high
    for start, end in (
        ((u0, v0), (u1, v0)),
        ((u0, v1), (u1, v1)),
        ((u0, v0), (u0, v1)),
        ((u1, v0), (u1, v1)),
    ):
        builder.line("fence", start, end, 2.0, (0.75, 0.77, 0.8))
    for _ in range(5):
        builder.skip(
            (float(rng.uniform(u0 + 6, u1 - 6)), float(rng.uniform(v0 + 5, v1 - 5))),
            "container",
            int(rng.integers(2)),
        )
    builder.build(hall, (u0 + 14, v0 + 12), (14, 10))
    for _ in range(2):
        builder.put("truck", (float(rng.uniform(u0 + 8, u1 - 8)), v1 - 7), tint=(0.85, 0.6, 0.1))


def _riverbank(builder: Builder, block: Block) -> None:
    _scatter(builder, block, 1.0, (5, 12))
    (u0, v0), (u1, v1) = block.low, block.high
    for v in (v0 + 0.3, v1 - 0.3):
        builder.line("rail guard", (u0 + 3, v), (u1 - 3, v), 1.0)


def _railside(builder: Builder, block: Block) -> None:
    (u0, v0), (u1, v1) = block.low, block.high
    for u in (u0 + 0.5, u1 - 0.5):
        builder.line("wall", (u, v0), (u, v1), 2.2, (0.66, 0.62, 0.56))
    for v in np.arange(v0 + 6, v1, 24.0).tolist():
        builder.put("mast", (builder.plan.relief.rail - 5.6, v))
    _scatter(builder, block, 0.7, (2.5, 6))


_FILLERS: Final = {
    BlockKind.PERIMETER: _perimeter,
    BlockKind.TOWERS: _towers,
    BlockKind.HOUSES: _houses,
    BlockKind.PARK: _park,
    BlockKind.PLAZA: _plaza,
    BlockKind.PARKING: _parking,
    BlockKind.INDUSTRY: _industry,
    BlockKind.SITE: _site,
    BlockKind.RIVERBANK: _riverbank,
    BlockKind.RAILSIDE: _railside,
}


def furnish_blocks(builder: Builder) -> None:
    """Fill every block of the plan that lies at least partly in the town."""
    for block in builder.plan.blocks:
        corners = builder.plan.warp.points(
            [block.low, block.high, (block.low[0], block.high[1]), (block.high[0], block.low[1])]
        )
        if (np.abs(corners).max(axis=1) < EXTENT_M).any():
            _FILLERS[block.kind](builder, block)
