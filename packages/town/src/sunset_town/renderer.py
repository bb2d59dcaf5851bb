"""The renderer: a town, a pose, a moment and the light → a frame.

The same arguments give the same bytes in any process with any number of threads on the same model of processor.
Another model may take other vector instructions and differ in last bits.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from sunset_town.frame import CARLA_IDS, DEPTH_RANGE_M, FRAME_SIZE, Frame, Ids, Indices, Points, Reals
from sunset_town.ground import SURFACE_LABELS
from sunset_town.layout import EXTENT_M
from sunset_town.light import Light, Seen, light, shade
from sunset_town.meshes import Material
from sunset_town.seeding import generator
from sunset_town.textures import Surfaces, finish_solids, ground_look
from sunset_town.town import Solid, Town
from sunset_town.vectors import dot, pick

FIELD_OF_VIEW_DEG: Final = 90.0
"""Horizontal angle of view in degrees."""


@dataclass(frozen=True, slots=True)
class Pose:
    """The place and direction of a camera."""

    x: float  #: east of the town's centre in metres
    y: float  #: north of it in metres
    z: float  #: height above the ground in metres
    heading: float  #: direction of view in radians, anticlockwise from east
    pitch: float  #: angle of view below the horizon in radians, in [0, π/2]
    roll: float = 0.0  #: turn about the line of sight in radians

    def axes(self) -> Points:
        """Return the unit vectors right, down and forward (3, 3) in world coordinates."""
        ch, sh, cp, sp = np.cos(self.heading), np.sin(self.heading), np.cos(self.pitch), np.sin(self.pitch)
        forward = np.array([ch * cp, sh * cp, -sp])
        right = np.array([sh, -ch, 0.0])
        down = np.array([-ch * sp, -sh * sp, -cp])
        cr, sr = np.cos(self.roll), np.sin(self.roll)
        return np.stack([right * cr + down * sr, down * cr - right * sr, forward])


def rays(pose: Pose, size: tuple[int, int]) -> Reals:
    """Return the directions (H·W + (H+1)·(W+1), 3) of the rays of a frame of H rows and W columns of pixels.

    Rays through pixel centres come first, then rays through pixel corners, both row by row. A direction's component
    along the line of sight is 1, so that a distance in units of the direction is the planar depth.
    """
    height, width = size
    scale = float(2 * np.tan(np.radians(FIELD_OF_VIEW_DEG) / 2) / width)  # of pixels, at distance 1
    axes = pose.axes()
    parts = []
    for extra, shift in ((0, 0.5), (1, 0.0)):
        x = (np.arange(width + extra) + shift - width / 2) * scale
        y = (np.arange(height + extra) + shift - height / 2) * scale
        grid = np.empty((3, height + extra, width + extra), dtype=np.float32)
        for axis, (right, down, forward) in enumerate(axes.T):
            grid[axis] = forward + x * right + y[:, None] * down
        parts.append(grid.reshape(3, -1))
    return np.concatenate(parts, axis=1).T


RENDER_VERSION: Final = 2
"""Increases whenever a rendered byte changes."""

SKY: Final = CARLA_IDS["sky"]
HIDDEN_SKY: Final = 0.7
"""The share of the sky's light that is lost where every sampled direction is hidden."""
CONTRAST: Final = 0.4
"""By how much recorded shadows are darker, and highlights lighter, than they are."""
MARGIN_M: Final = 14.0
"""Greatest distance from the view in metres at which movers are drawn for their shadows."""
SLACK: Final = 1.5
"""The reach of a mover and its shadow across slanting edges of the view, as a multiple of that on level ground."""
F: Final = np.float32


@dataclass(frozen=True, slots=True)
class View:
    """A picture to take: the moment `time_s` of the traffic in seconds, and the seed of the sensor's noise.

    Time of day and weather are of `TIMES` and `WEATHERS`.
    """

    pose: Pose
    time_s: float
    seed: int
    time: str = "noon"
    weather: str = "clear"


@dataclass(frozen=True, slots=True)
class _Scene:
    """A town at a moment: the movers in view, if any, and the light."""

    town: Town
    moving: Solid | None
    light: Light


@dataclass(frozen=True, slots=True)
class _Met:
    """The hits of all rays: `kind` (N,) is -1 sky, 0 ground, 1 the town, 2 traffic."""

    kind: npt.NDArray[np.int8]
    depth: Reals
    triangle: npt.NDArray[np.int32]


def render(town: Town, view: View, *, size: tuple[int, int] = FRAME_SIZE) -> Frame:
    """Return the frame of a view, H x W pixels in size; the same arguments give the same bytes.

    Labels and depth belong to the point under each pixel's centre. Colour is the mean of the centre (half)
    and the four corners (an eighth each).
    """
    directions = rays(view.pose, size)
    origin = np.array([view.pose.x, view.pose.y, view.pose.z], dtype=np.float32)
    sunlight = light(view.time, view.weather)
    scene = _Scene(town, _traffic(town, view, sunlight, size), sunlight)
    met = _meet(scene, origin, directions)
    seen, labels = _look(scene, met, origin, directions, size)
    colours = shade(seen, directions, scene.light)
    pixels = size[0] * size[1]
    counts = np.minimum(met.depth[:pixels], DEPTH_RANGE_M) * np.float32(65535 / DEPTH_RANGE_M)
    depth = np.round(counts).astype(np.uint16).reshape(size)
    return Frame(
        _develop(colours * F(scene.light.exposure), size, view.seed), depth, labels[:pixels].reshape(size)
    )


def _traffic(town: Town, view: View, sunlight: Light, size: tuple[int, int]) -> Solid | None:
    """Return the movers in view or near enough to cast a shadow into it."""
    positions, headings = town.traffic.poses(view.time_s)
    pose = view.pose
    relative = positions - np.array([pose.x, pose.y, pose.z], dtype=np.float32)
    right, down, forward = ((relative * axis.astype(np.float32)).sum(axis=1) for axis in pose.axes())
    margin = np.minimum(town.traffic.radii * F(SLACK * (1 + sunlight.shadow)), F(MARGIN_M))
    reach = np.maximum(forward, 0) + margin
    seen = (np.abs(right) < reach) & (np.abs(down) < reach * (size[0] / size[1]) + margin)
    seen &= (np.abs(positions[:, :2]).max(axis=1) < EXTENT_M) & (forward > -margin) & (forward < 400)
    mesh = town.traffic.mesh(positions, headings, seen)
    return Solid(mesh) if len(mesh) else None


def _meet(scene: _Scene, origin: Reals, directions: Reals) -> _Met:
    origins = np.broadcast_to(origin, directions.shape)
    distance, triangle = scene.town.solid.meet(origins, directions)
    known = distance < np.float32(DEPTH_RANGE_M)
    kind = np.where(triangle < len(scene.town.terrain.mesh), np.int8(0), np.int8(1))
    kind[~known] = -1
    depth = np.where(known, distance, F(np.inf))
    if scene.moving is not None:
        distance, other = scene.moving.meet(origins, directions)
        nearer = distance < depth
        kind[nearer], depth[nearer], triangle[nearer] = 2, distance[nearer], other[nearer]
    return _Met(kind, depth, triangle)


def _look(
    scene: _Scene, met: _Met, origin: Reals, directions: Reals, size: tuple[int, int]
) -> tuple[Seen, Ids]:
    """Return the points that the rays met, and their CARLA ids (N,)."""
    count = len(directions)
    reach = np.where(met.kind < 0, F(0), met.depth)
    points = origin + directions * reach[:, None]
    normals, colours = (np.zeros((count, 3), dtype=F, order="F") for _ in range(2))
    gloss = np.zeros(count, dtype=F)
    normals[:, 2] = 1
    labels, lift = np.full(count, SKY, dtype=np.uint8), np.full(count, F(0.03))
    ground = np.flatnonzero(met.kind == 0)
    land = met.triangle[ground]
    places = pick(points, ground)
    surfaces = scene.town.ground.at(places[:, 0], places[:, 1], scene.town.terrain.bare.take(land))
    rippled = pick(scene.town.solid.normals, land)
    bare, gloss[ground] = ground_look(surfaces, places, rippled)
    colours[ground] = bare
    normals[ground] = rippled
    labels[ground] = SURFACE_LABELS[surfaces]
    for kind, solid in ((1, scene.town.solid), (2, scene.moving)):
        rows = np.flatnonzero(met.kind == kind)
        if solid is None or not len(rows):
            continue
        surface = _surfaces(solid, met, rows, points, directions)
        finish_solids(surface)
        normals[rows] = surface.normals
        colours[rows] = surface.colours
        gloss[rows] = surface.gloss
        labels[rows] = solid.labels.take(met.triangle[rows])
        lift[rows] = np.where(surface.materials == Material.FOLIAGE, F(0.3), F(0.03))
    starts = points + normals * lift[:, None]
    lit = _lit(scene, met, starts, normals, size)
    return Seen(normals, colours, gloss, lit, _openness(scene, met, starts, normals, size), met.depth), labels


def _surfaces(solid: Solid, met: _Met, rows: Indices, points: Reals, directions: Reals) -> Surfaces:
    triangles = met.triangle[rows]
    facing = pick(solid.normals, triangles)
    facing *= np.where(dot(facing, pick(directions, rows)) > 0, F(-1), F(1))[:, None]
    return Surfaces(
        materials=solid.materials.take(triangles),
        points=pick(points, rows),
        anchors=pick(solid.anchors, triangles),
        depth=met.depth.take(rows),
        normals=facing,
        colours=pick(solid.colours, triangles),
        gloss=np.zeros(len(rows), dtype=F),
    )


@lru_cache(maxsize=4)
def _jitter(count: int) -> Reals:
    """Return points (N, 3) spread in the unit ball, the same for every frame."""
    return np.asfortranarray(generator(0, "penumbra").uniform(-1, 1, (count, 3)).astype(F) * F(0.6))


def _lit(scene: _Scene, met: _Met, starts: Reals, normals: Reals, size: tuple[int, int]) -> Reals:
    """Return the share of the sun (N,) that each point sees.

    Rays to random points of the sun start from the pixels' corners; a pixel's centre takes the mean of its corners
    that face the sun.
    """
    pixels = size[0] * size[1]
    towards = np.asarray(scene.light.sun_direction, dtype=F)
    rows = pixels + np.flatnonzero((met.kind[pixels:] >= 0) & (dot(normals[pixels:], towards) > 0))
    directions = towards + pick(_jitter(len(normals)), rows) * F(scene.light.sun_radius)
    origins = pick(starts, rows)
    dark = scene.town.solid.blocks(origins, directions)
    if scene.moving is not None:
        dark |= scene.moving.blocks(origins, directions)
    corners = np.zeros((2, len(normals) - pixels), dtype=F)
    corners[0, rows - pixels] = ~dark
    corners[1, rows - pixels] = 1
    grids = corners.reshape(2, size[0] + 1, size[1] + 1)
    light, weight = (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:] for grid in grids)
    centres = np.where(weight > 0, light / np.maximum(weight, 1), F(1))
    return np.concatenate([centres.ravel(), corners[0]])


@lru_cache(maxsize=4)
def _skyward(size: tuple[int, int]) -> tuple[Indices, Reals]:
    """Return every second pixel (M,) of every second row and a direction (M, 3) into the sky, of four, for each."""
    row, column = (axis[::2, ::2] for axis in np.indices(size))
    azimuth = (column // 2 % 2 + row % 4) * (np.pi / 2) + 0.4
    flat = np.stack([0.74 * np.cos(azimuth), 0.74 * np.sin(azimuth), np.full(row.shape, 0.67)])
    return (row * size[1] + column).ravel(), flat.reshape(3, -1).astype(F).T


def _openness(scene: _Scene, met: _Met, starts: Reals, normals: Reals, size: tuple[int, int]) -> Reals:
    """Return the share of the sky (N,) that the town leaves open, averaged over neighbouring pixels."""
    rows, directions = _skyward(size)
    outward = pick(normals, rows)
    inward = np.minimum(dot(directions, outward), 0)
    directions = directions - F(2) * inward[:, None] * outward
    hidden = scene.town.solid.blocks(pick(starts, rows), directions) & (met.kind.take(rows) >= 0)
    coarse = hidden.reshape((size[0] + 1) // 2, -1).astype(F)
    coarse = cv2.blur(coarse, (4, 4), borderType=cv2.BORDER_REFLECT)
    image = cv2.resize(coarse, size[::-1], interpolation=cv2.INTER_LINEAR)
    wide = np.pad(image, 1, mode="edge")
    corners = (wide[:-1, :-1] + wide[1:, :-1] + wide[:-1, 1:] + wide[1:, 1:]) * F(0.25)
    return 1 - F(HIDDEN_SKY) * np.concatenate([image.ravel(), corners.ravel()])


@lru_cache(maxsize=4)
def _vignette(size: tuple[int, int]) -> Reals:
    y, x = np.linspace(-1, 1, size[0]), np.linspace(-1, 1, size[1])
    return (1 - 0.09 * (x[None, :] ** 2 + y[:, None] ** 2)).astype(np.float32)


def _develop(colours: Reals, size: tuple[int, int], seed: int) -> npt.NDArray[np.uint8]:
    """Return the picture (H, W, 3), blue first, as a sensor records linear colours of centres and corners."""
    height, width = size
    centres = colours.T[:, : height * width].reshape(3, height, width)
    corners = colours.T[:, height * width :].reshape(3, height + 1, width + 1)
    around = corners[:, :-1, :-1] + corners[:, 1:, :-1] + corners[:, :-1, 1:] + corners[:, 1:, 1:]
    linear = (centres * np.float32(0.5) + around * np.float32(0.125)) * _vignette(size)
    display = np.sqrt(linear / (1 + linear * np.float32(0.3)))
    display += np.float32(CONTRAST) * display * (1 - display) * (2 * display - 1)
    display *= np.float32(255)
    noise = generator(seed, "sensor").standard_normal((height, width, 3), dtype=np.float32)
    display += noise.transpose(2, 0, 1) * np.float32(1.6)
    levels = np.clip(np.round(display), 0, 255).astype(np.uint8)
    return np.ascontiguousarray(levels[::-1].transpose(1, 2, 0))
