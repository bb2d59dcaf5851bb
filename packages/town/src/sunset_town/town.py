"""A town, built: its ground with the decks of bridges, its solid things ready for rays, its traffic."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset_town.errors import MissingEmbreeError
from sunset_town.fill import fill_blocks, furnish_railway, furnish_streets, plant_country
from sunset_town.frame import Flags, Ids, Points, Reals
from sunset_town.furnish import Builder
from sunset_town.ground import Ground
from sunset_town.layout import PAVEMENT_M, TownPlan, plan_town
from sunset_town.meshes import Finish, Mesh, join, shell
from sunset_town.paving import paint_ground
from sunset_town.relief import BANK_M, CROWN_M
from sunset_town.traffic import Traffic, make_traffic

try:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene
except ModuleNotFoundError:  # it has no wheels for some platforms
    EmbreeScene = None

GROUND: Final = Finish((0.5, 0.5, 0.5), "ground")
TOWN_M: Final = 432.0
FAR_M: Final = (470.0, 520.0, 580.0, 660.0, 760.0, 880.0, 1020.0, 1200.0, 1500.0)
DECK_M: Final = 0.05
"""Height of a bridge's deck above the street, so that the two never coincide."""


class Solid:
    """A mesh of T triangles, at least one, that rays can meet."""

    def __init__(self, mesh: Mesh) -> None:
        self._scene = EmbreeScene()
        self._geometry = TriangleMesh(self._scene, mesh.triangles)
        first, second, third = (mesh.triangles[:, corner] for corner in range(3))
        normals = np.cross(second - first, third - first)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.float32(1e-9))
        self.normals: Reals = np.asfortranarray(normals, dtype=np.float32)
        self.colours: Reals = np.asfortranarray(mesh.colours * mesh.colours)
        self.labels: Ids = mesh.labels
        self.materials: Ids = mesh.materials
        self.anchors: Reals = np.asfortranarray(mesh.anchors)

    def meet(self, origins: Reals, directions: Reals) -> tuple[Reals, npt.NDArray[np.int32]]:
        """Return the distances (N,) at which rays (N, 3) meet the solid, and the triangles (N,) that they meet.

        Distances are in units of each ray's direction. Without a hit, the distance is infinite and the triangle -1.
        """
        hits = self._scene.run(origins, directions, output=1)
        triangle = np.where(hits["geomID"] < 0, np.int32(-1), hits["primID"])
        return np.where(triangle < 0, np.float32(np.inf), hits["tfar"]), triangle

    def blocks(self, origins: Reals, directions: Reals) -> Flags:
        """Return whether rays (N, 3) meet the solid anywhere (N,)."""
        hidden: Flags = self._scene.run(origins, directions, query="OCCLUDED") >= 0
        return hidden


@dataclass(frozen=True, slots=True)
class Terrain:
    """The ground's mesh; its colours and labels are looked up in the painted ground instead.

    Its triangles that are `bare` (T,) show the ground without streets: below street bridges, and on railway bridges.
    """

    mesh: Mesh
    bare: Flags


@dataclass(frozen=True, slots=True)
class Town:
    """A town, ready to be rendered; it never changes.

    Its solid is everything that stands still, beginning with the terrain's triangles.
    """

    plan: TownPlan
    ground: Ground
    terrain: Terrain
    solid: Solid
    traffic: Traffic


@lru_cache(maxsize=2)
def build_town(number: int) -> Town:
    """Return a town; the same number gives the same town, built once and kept.

    Raises:
        InvalidInputError: there is no town of this number.
        MissingEmbreeError: embreex is not installed.
    """
    if EmbreeScene is None:
        raise MissingEmbreeError("Rendering needs embreex, which is not installed.")
    plan = plan_town(number)
    ground = paint_ground(plan)
    builder = Builder(plan, ground)
    fill_blocks(builder)
    plant_country(builder)
    furnish_streets(builder)
    furnish_railway(builder)
    terrain = make_terrain(plan)
    return Town(plan, ground, terrain, Solid(join(terrain.mesh, *builder.finish())), make_traffic(plan))


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
    for ends in relief.rail_spans:
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
