"""A town, built: its ground, its solid things ready for rays, its traffic."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from sunset.data.fill import fill_blocks, plant_country
from sunset.data.frame import Ids, Reals
from sunset.data.furnish import Builder
from sunset.data.ground import Ground
from sunset.data.layout import TownPlan, plan_town
from sunset.data.meshes import Mesh, join
from sunset.data.paving import paint_ground
from sunset.data.roadside import furnish_railway, furnish_streets
from sunset.data.terrain import Terrain, make_terrain
from sunset.data.traffic import Traffic, make_traffic
from sunset.errors import MissingExtraError

try:
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene
except ModuleNotFoundError:  # it has no wheels for some platforms, on which flights can be flown all the same
    EmbreeScene = None


class Solid:
    """A mesh of T triangles, at least one, that rays can meet.

    It takes less time with corners (V, 3), each once, and faces, which of them each triangle has (T, 3).
    """

    def __init__(
        self, mesh: Mesh, corners: Reals | None = None, faces: npt.NDArray[np.int64] | None = None
    ) -> None:
        self._scene = EmbreeScene()
        self._geometry = TriangleMesh(self._scene, mesh.triangles if corners is None else corners, faces)
        first, second, third = (mesh.triangles[:, corner] for corner in range(3))
        normals = np.cross(second - first, third - first)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.float32(1e-9))
        self.normals: Reals = np.asfortranarray(normals, dtype=np.float32)
        self.colours: Reals = np.asfortranarray(mesh.colours * mesh.colours)
        self.labels: Ids = mesh.labels
        self.materials: Ids = mesh.materials
        self.anchors: Reals = np.asfortranarray(mesh.anchors)

    def meet(self, origins: Reals, directions: Reals) -> tuple[Reals, npt.NDArray[np.int32]]:
        """Return where rays (N, 3) first meet the solid.

        Returns:
            The distances (N,) in units of each ray's direction, infinite where nothing is met, and the indices of the
            triangles (N,), -1 where nothing is.
        """
        found = self._scene.run(origins, directions, output=1)
        triangle = np.where(found["geomID"] < 0, np.int32(-1), found["primID"])
        return np.where(triangle < 0, np.float32(np.inf), found["tfar"]), triangle

    def blocks(self, origins: Reals, directions: Reals) -> npt.NDArray[np.bool_]:
        """Return whether rays (N, 3) meet the solid anywhere (N,)."""
        hidden: npt.NDArray[np.bool_] = self._scene.run(origins, directions, query="OCCLUDED") >= 0
        return hidden


@dataclass(frozen=True, slots=True)
class Town:
    """A town, ready to be rendered; it never changes.

    Its solid is everything that stands still; the terrain's triangles are the first of it.
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
        MissingExtraError: rays cannot be followed, since embreex is not installed.
    """
    if EmbreeScene is None:
        raise MissingExtraError(
            "Rendering a flight needs embreex, which is not installed and has no wheels for some platforms: fly a bag "
            "(--bag, 'sunset data import'), or copy the cache folder (~/.cache/sunset, or SUNSET_CACHE_DIR) of a "
            "computer that has rendered the flight."
        )
    plan = plan_town(number)
    ground = paint_ground(plan)
    builder = Builder(plan, ground)
    fill_blocks(builder)
    plant_country(builder)
    furnish_streets(builder)
    furnish_railway(builder)
    terrain = make_terrain(plan)
    return Town(plan, ground, terrain, Solid(join(terrain.mesh, *builder.finish())), make_traffic(plan))
