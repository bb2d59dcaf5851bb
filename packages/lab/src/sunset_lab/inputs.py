"""The constants of the networks' inputs, shared by the torch side and the ONNX side."""

from typing import Final

import numpy as np
import numpy.typing as npt

WIDTH: Final = 256
HEIGHT: Final = 144

RGB_MEAN: Final = (0.485, 0.456, 0.406)
RGB_STD: Final = (0.229, 0.224, 0.225)

FAR_PLANE_M: Final = 1000.0
"""The depth of 65535 counts."""

REFERENCE_DEPTH_M: Final = 50.0
"""Channel 0 of the depth input is the logarithm of the depth over this."""

DEPTH_LIMIT_M: Final = 200.0
"""Larger depths count as this depth in the local contrasts."""

CONTRASTS: Final = ((16, 5.0, 2.0), (8, 1.0, 2.0))
"""Channels 1 and 2: depth minus its mean over blocks of so many pixels (interpolated), in units of so many metres,
cut at so many units. A car is 1.5 m high at a distance of 50 m: it only shows locally."""


def upsampling(size: int, factor: int) -> npt.NDArray[np.float32]:
    """Return the matrix (size · factor, size) float32 of bilinear interpolation along one axis.

    Pixels are areas: the centres of the first and last coarse pixel lie inside, and the border repeats beyond them
    (torch's `align_corners=False`).

    >>> upsampling(2, 2).tolist()
    [[1.0, 0.0], [0.75, 0.25], [0.25, 0.75], [0.0, 1.0]]
    """
    centres = (np.arange(size * factor) + 0.5) / factor - 0.5
    low = np.floor(centres).astype(int)
    fraction = centres - low
    matrix = np.zeros((size * factor, size), dtype=np.float32)
    rows = np.arange(size * factor)
    np.add.at(matrix, (rows, np.clip(low, 0, size - 1)), 1 - fraction)
    np.add.at(matrix, (rows, np.clip(low + 1, 0, size - 1)), fraction)
    return matrix
