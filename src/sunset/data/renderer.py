"""The renderer: a town, a pose, a moment and the light → a frame.

The same arguments give the same bytes in any process with any number of threads on one model of processor.
Another model may take other vector instructions and differ in last bits.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.classes import CARLA_IDS
from sunset.data.camera import Pose, rays
from sunset.data.frame import DEPTH_RANGE_M, FRAME_SIZE, Frame, Ids, Reals
from sunset.data.ground import SURFACE_LABELS, Surface
from sunset.data.layout import EXTENT_M
from sunset.data.light import Light, light
from sunset.data.shading import Seen, ground_colours, shade, solid_colours
from sunset.data.town import Hits, Solid, Town
from sunset.seeding import generator

__all__ = ["View", "render"]

SKY: Final = CARLA_IDS["sky"]
SENSOR_NOISE: Final = 1.6
EXPOSURE: Final = 1.5
MARGIN_M: Final = 30.0
NO_HIT: Final = np.float32(np.inf)


@dataclass(frozen=True, slots=True)
class View:
    """One picture to take.

    Attributes:
        pose: of the camera.
        time_s: how long the traffic has moved, in seconds.
        seed: of the sensor's noise.
        time: time of day, one of `TIMES`.
        weather: one of `WEATHERS`.
    """

    pose: Pose
    time_s: float
    seed: int
    time: str = "noon"
    weather: str = "clear"


@dataclass(frozen=True, slots=True)
class _Scene:
    """A town at one moment: what moves there, if anything does in view, and the light."""

    town: Town
    moving: Solid | None
    light: Light


@dataclass(frozen=True, slots=True)
class _Met:
    """What every ray met: `kind` (N,) is -1 sky, 0 ground, 1 the town, 2 traffic."""

    kind: npt.NDArray[np.int8]
    depth: Reals
    triangle: npt.NDArray[np.int32]


def render(town: Town, view: View, *, size: tuple[int, int] = FRAME_SIZE) -> Frame:
    """Return what a camera sees; the same arguments give the same bytes.

    Labels and depth are those of the point under each pixel's centre. Colour is the mean of the centre (half)
    and the four corners (an eighth each).

    Args:
        town: where.
        view: from where, when, in what light.
        size: height H and width W in pixels.
    """
    directions = rays(view.pose, size)
    origin = np.array([view.pose.x, view.pose.y, view.pose.z], dtype=np.float32)
    scene = _Scene(town, _traffic(town, view, size), light(view.time, view.weather))
    met = _meet(scene, origin, directions)
    seen, labels = _look(scene, met, origin, directions)
    colours = shade(seen, directions, scene.light)
    pixels = size[0] * size[1]
    counts = np.minimum(met.depth[:pixels], DEPTH_RANGE_M) * np.float32(65535 / DEPTH_RANGE_M)
    depth = np.round(counts).astype(np.uint16).reshape(size)
    return Frame(_develop(colours, size, view.seed), depth, labels[:pixels].reshape(size))


def _traffic(town: Town, view: View, size: tuple[int, int]) -> Solid | None:
    """Return what moves and is in view, or near enough to cast a shadow into it."""
    positions, headings = town.traffic.poses(view.time_s)
    pose = view.pose
    relative = positions - np.array([pose.x, pose.y, pose.z], dtype=np.float32)
    right, down, forward = ((relative * axis.astype(np.float32)).sum(axis=1) for axis in pose.axes())
    ahead = forward > -MARGIN_M
    reach = np.maximum(forward, 0) + MARGIN_M
    seen = ahead & (np.abs(right) < reach) & (np.abs(down) < reach * (size[0] / size[1]) + MARGIN_M)
    seen &= np.abs(positions[:, :2]).max(axis=1) < EXTENT_M
    seen &= forward < 400  # noqa: PLR2004  metres; nothing that moves is a pixel wide beyond
    mesh = town.traffic.mesh(positions, headings, seen)
    return Solid(mesh) if len(mesh) else None


def _meet(scene: _Scene, origin: Reals, directions: Reals) -> _Met:
    origins = np.ascontiguousarray(np.broadcast_to(origin, directions.shape))
    hits = scene.town.solid.meet(origins, directions)
    kind = np.where(hits.triangle >= 0, np.int8(1), np.int8(-1))
    depth, triangle = hits.distance, hits.triangle
    if scene.moving is not None:
        other: Hits = scene.moving.meet(origins, directions)
        nearer = other.distance < depth
        kind[nearer] = 2
        depth = np.where(nearer, other.distance, depth)
        triangle = np.where(nearer, other.triangle, triangle)
    falling = np.minimum(directions[:, 2], np.float32(-1e-6))
    down = np.where(directions[:, 2] < 0, -origin[2] / falling, NO_HIT)
    down = np.where(down < np.float32(DEPTH_RANGE_M), down, NO_HIT)
    below = down < depth
    kind[below] = 0
    return _Met(kind, np.where(below, down, depth), triangle)


def _look(scene: _Scene, met: _Met, origin: Reals, directions: Reals) -> tuple[Seen, Ids]:
    """Return what the rays saw and its CARLA ids (N,)."""
    count = len(directions)
    reach = np.where(met.kind < 0, np.float32(0), met.depth)
    points = origin + directions * reach[:, None]
    normals = np.zeros((count, 3), dtype=np.float32)
    normals[:, 2] = 1
    colours, gloss = np.zeros((count, 3), dtype=np.float32), np.zeros(count, dtype=np.float32)
    labels = np.full(count, SKY, dtype=np.uint8)
    ground = np.flatnonzero(met.kind == 0)
    surfaces = scene.town.ground.at(points[ground, 0], points[ground, 1])
    colours[ground] = ground_colours(surfaces, points[ground])
    gloss[ground] = np.where(surfaces == Surface.WATER, np.float32(0.35), np.float32(0))
    labels[ground] = SURFACE_LABELS[surfaces]
    for kind, solid in ((1, scene.town.solid), (2, scene.moving)):
        rows = np.flatnonzero(met.kind == kind)
        if solid is None or not len(rows):
            continue
        triangles = met.triangle[rows]
        facing = solid.normals[triangles]
        away = (facing * directions[rows]).sum(axis=1) > 0
        facing = np.where(away[:, None], -facing, facing)
        normals[rows] = facing
        colours[rows], gloss[rows] = solid_colours(
            solid.materials[triangles], solid.colours[triangles], points[rows], facing, met.depth[rows]
        )
        labels[rows] = solid.labels[triangles]
    lit = _lit(scene, met, points, normals)
    return Seen(points, normals, colours, gloss, lit, met.depth), labels


def _lit(scene: _Scene, met: _Met, points: Reals, normals: Reals) -> npt.NDArray[np.bool_]:
    """Return which points (N,) the sun reaches."""
    towards = np.asarray(scene.light.sun_direction, dtype=np.float32)
    facing = normals[:, 0] * towards[0] + normals[:, 1] * towards[1] + normals[:, 2] * towards[2]
    rows = np.flatnonzero((met.kind >= 0) & (facing > 0))
    origins = points[rows] + normals[rows] * np.float32(0.03)
    directions = np.ascontiguousarray(np.broadcast_to(towards, origins.shape))
    dark = scene.town.solid.blocks(origins, directions)
    if scene.moving is not None:
        dark |= scene.moving.blocks(origins, directions)
    lit = np.zeros(len(points), dtype=np.bool_)
    lit[rows[~dark]] = True
    return lit


@lru_cache(maxsize=4)
def _vignette(size: tuple[int, int]) -> Reals:
    y, x = np.linspace(-1, 1, size[0]), np.linspace(-1, 1, size[1])
    return (1 - 0.09 * (x[None, :] ** 2 + y[:, None] ** 2)).astype(np.float32)[..., None]


def _develop(colours: Reals, size: tuple[int, int], seed: int) -> npt.NDArray[np.uint8]:
    """Return the picture (H, W, 3), blue first, as a sensor records linear colours of centres and corners."""
    height, width = size
    centres = colours[: height * width].reshape(height, width, 3)
    corners = colours[height * width :].reshape(height + 1, width + 1, 3)
    around = corners[:-1, :-1] + corners[1:, :-1] + corners[:-1, 1:] + corners[1:, 1:]
    linear = (centres * np.float32(0.5) + around * np.float32(0.125)) * _vignette(size) * np.float32(EXPOSURE)
    display = np.sqrt(linear / (1 + linear * np.float32(0.25))) * np.float32(255)
    display += generator(seed, "sensor").standard_normal(display.shape, dtype=np.float32) * np.float32(
        SENSOR_NOISE
    )
    levels = np.clip(np.round(display), 0, 255).astype(np.uint8)
    return np.ascontiguousarray(levels[..., ::-1])
