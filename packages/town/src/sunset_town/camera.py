"""The camera: its pose, and the rays through its pixels."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from sunset_town.frame import Points, Reals

FIELD_OF_VIEW_DEG: Final = 90.0
"""Horizontal angle of view in degrees."""


@dataclass(frozen=True, slots=True)
class Pose:
    """The place and direction of a camera.

    Attributes:
        x: east of the town's centre in metres.
        y: north of it in metres.
        z: height above the ground in metres.
        heading: direction of view in radians, anticlockwise from east.
        pitch: angle of view below the horizon in radians, in [0, π/2].
        roll: turn about the line of sight in radians.
    """

    x: float
    y: float
    z: float
    heading: float
    pitch: float
    roll: float = 0.0

    def axes(self) -> Points:
        """Return the unit vectors right, down and forward (3, 3) in world coordinates."""
        ch, sh, cp, sp = np.cos(self.heading), np.sin(self.heading), np.cos(self.pitch), np.sin(self.pitch)
        forward = np.array([ch * cp, sh * cp, -sp])
        right = np.array([sh, -ch, 0.0])
        down = np.array([-ch * sp, -sh * sp, -cp])
        cr, sr = np.cos(self.roll), np.sin(self.roll)
        return np.stack([right * cr + down * sr, down * cr - right * sr, forward])


def pixel_width(width: int) -> float:
    """Return the distance of neighbouring pixels' rays at distance 1, in pictures `width` pixels wide."""
    return float(2 * np.tan(np.radians(FIELD_OF_VIEW_DEG) / 2) / width)


def rays(pose: Pose, size: tuple[int, int]) -> Reals:
    """Return the directions (H·W + (H+1)·(W+1), 3) of the rays of a frame of H rows and W columns of pixels.

    Rays through pixel centres come first, then rays through pixel corners, both row by row. A direction's component
    along the line of sight is 1, so that a distance in units of the direction is the planar depth.
    """
    height, width = size
    scale = pixel_width(width)
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
