"""A town, built: its ground, its solid things ready for rays, its traffic."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from sunset_town.errors import MissingEmbreeError
from sunset_town.fill import fill_blocks, furnish_railway, furnish_streets, plant_country
from sunset_town.frame import Flags, Ids, Reals
from sunset_town.furnish import Builder
from sunset_town.ground import Ground
from sunset_town.layout import TownPlan, plan_town
from sunset_town.meshes import Mesh, join
from sunset_town.paving import paint_ground
from sunset_town.terrain import Terrain, make_terrain
from sunset_town.traffic import Traffic, make_traffic

try:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene
except ModuleNotFoundError:  # it has no wheels for some platforms
    EmbreeScene = None


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
