"""The ground of a town as a mesh: land to the horizon, and the decks of bridges above it."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from sunset_town.frame import Flags, Pair, Points
from sunset_town.layout import PAVEMENT_M, TownPlan
from sunset_town.meshes import Finish, Mesh, shell
from sunset_town.relief import BANK_M, CROWN_M

GROUND: Final = Finish((0.5, 0.5, 0.5), "ground")
TOWN_M: Final = 432.0
FAR_M: Final = (470.0, 520.0, 580.0, 660.0, 760.0, 880.0, 1020.0, 1200.0, 1500.0)
DECK_M: Final = 0.05
"""Height of a bridge's deck above the street, so that the two never coincide."""


@dataclass(frozen=True, slots=True)
class Terrain:
    """The ground's mesh; its colours and labels are looked up in the painted ground instead.

    Its triangles that are `bare` (T,) show the ground without streets: below street bridges, and on railway bridges.
    """

    mesh: Mesh
    bare: Flags


def rail_spans(plan: TownPlan) -> list[Pair]:
    """Return the ends along v of every railway bridge, in metres."""
    half = plan.relief.river_width / 2 + BANK_M + plan.relief.river_bend[0] + 1
    spans = [(at - wide - 1, at + wide + 1) for at, wide in plan.relief.underpasses]
    middle = float(plan.relief.river_v(plan.relief.rail))
    return [*spans, (middle - half, middle + half)]


def make_terrain(plan: TownPlan) -> Terrain:
    """Return the ground's mesh of a town."""
    relief, land = plan.relief, _land(plan)
    parts, bare = [land], [relief.off_water(land.mean(axis=1)) < BANK_M - 1]
    heights = [relief.ground(land)]
    for street in plan.streets:
        if street.axis == 1:
            middle, half = float(relief.river_v(street.at)), relief.river_width / 2 + BANK_M + 2.5
            side = street.width / 2 + PAVEMENT_M
            us, vs = (street.at - side, street.at + side), (middle - half, middle + half)
            parts.append(_sheet(np.linspace(*us, 3), np.linspace(*vs, 10)))
            bare.append(np.zeros(len(parts[-1]), dtype=np.bool_))
            heights.append(relief.streets(parts[-1]) + DECK_M)
    for ends in rail_spans(plan):
        parts.append(_sheet(relief.rail + np.array([-CROWN_M, CROWN_M]), np.linspace(*ends, 6)))
        bare.append(np.ones(len(parts[-1]), dtype=np.bool_))
        heights.append(relief.railway(parts[-1][..., 1]) + DECK_M)
    grid = plan.warp.points(np.concatenate(parts))
    corners = np.concatenate([grid, np.concatenate(heights)[..., None]], axis=-1)
    return Terrain(shell(corners.astype(np.float32), GROUND), np.concatenate(bare))


def _land(plan: TownPlan) -> Points:
    """Return the land's triangles (T, 3, 2) on the grid, finer where it is steep."""
    far = np.array(FAR_M)
    broad = np.concatenate([-far, np.arange(-TOWN_M, TOWN_M + 1, 8.0), far])
    embankment = plan.relief.rail + np.array([-13.4, -9.4, -CROWN_M, 0.0, CROWN_M, 9.4, 13.4])
    reach = plan.relief.river_width / 2 + BANK_M + plan.relief.river_bend[0] + 1
    banks = np.arange(plan.relief.river - reach, plan.relief.river + reach, 1.0)
    edges = [(at, half + wall) for at, half in plan.relief.underpasses for wall in (0.0, 0.8)]
    abutments = [at + side * edge for at, edge in edges for side in (-1, 1)]
    return _sheet(np.concatenate([broad, embankment]), np.concatenate([broad, banks, np.array(abutments)]))


def _sheet(us: Points, vs: Points) -> Points:
    """Return the triangles (T, 3, 2), anticlockwise, of the grid between lines."""
    grid = np.stack(np.meshgrid(np.unique(us), np.unique(vs), indexing="ij"), axis=-1)
    a, b, c, d = grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]
    halves = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)], axis=2)
    return halves.reshape(-1, 3, 2)
