"""Image degradations, as pure functions on arrays.

All functions saturate instead of wrapping around. They do not write to their arguments; with strength 0 they return
the argument without a copy. They do not check strengths: the parameters of nodes and the descriptions of faults do.

The paper (section 3.3) names the degradations: a shifted colour space, the enhancement applied to a good
image, a misaligned image, Gaussian noise on the depth, and a blur. Their strengths are decided here.
"""

import math
from typing import Final

import cv2
import numpy as np
import numpy.typing as npt

from sunset.errors import ParameterError

Image = npt.NDArray[np.uint8]
Depth = npt.NDArray[np.uint16]

REFERENCE_WIDTH: Final = 256
"""The image width to which lengths in pixels refer."""

DEPTH_COUNTS_PER_METRE: Final = 65.535
"""A 16-bit depth image counts 65535 steps on 1000 m."""

_DARKENING = 0.5  # of the brightness, per unit of strength: the published exemplar's figure
_MIXING = 0.2  # of each channel replaced by the next channel, per unit of strength


def _mixture(strength: float) -> npt.NDArray[np.float64]:
    """Return the (3, 3) matrix that degrades a pixel (b, g, r).

    Each row sums to the remaining brightness, so that grey stays grey and nothing exceeds 255.
    """
    share = _MIXING * strength
    mixing = (1.0 - share) * np.eye(3) + share * np.roll(np.eye(3), 1, axis=1)
    matrix: npt.NDArray[np.float64] = (1.0 - _DARKENING * strength) * mixing
    return matrix


def degrade_image(bgr: Image, strength: float) -> Image:
    """Darken an image and shift its colours.

    The brightness falls to `1 - 0.5 * strength`, and a share of `0.2 * strength` of each channel is
    taken from the next channel (blue from green, green from red, red from blue).

    Args:
        bgr: (H, W, 3).
        strength: in [0, 1.9].

    >>> degrade_image(np.array([[[200, 100, 0]]], dtype=np.uint8), 1.0)
    array([[[90, 40, 20]]], dtype=uint8)
    """
    if strength == 0:
        return bgr
    degraded: Image = cv2.transform(bgr, _mixture(strength))
    return degraded


def enhance_image(bgr: Image, strength: float) -> Image:
    """Undo `degrade_image` of the same strength, up to rounding.

    It harms an image that was not degraded: bright pixels saturate and colours shift.

    Args:
        bgr: (H, W, 3).
        strength: in [0, 1.9].

    >>> enhance_image(np.array([[[90, 40, 20]]], dtype=np.uint8), 1.0)
    array([[[200, 100,   0]]], dtype=uint8)
    """
    if strength == 0:
        return bgr
    enhanced: Image = cv2.transform(bgr, np.linalg.inv(_mixture(strength)))
    return enhanced


def degrade_depth(depth: Depth, strength: float, rng: np.random.Generator) -> Depth:
    """Add zero-mean Gaussian noise to a depth image.

    Args:
        depth: (H, W), 65535 counts on 1000 m.
        strength: the noise's standard deviation in metres, in [0, 100].
        rng: draws the noise; not used when the strength is 0.
    """
    if strength == 0:
        return depth
    noisy = rng.standard_normal(depth.shape, dtype=np.float32)
    noisy *= np.float32(strength * DEPTH_COUNTS_PER_METRE)
    noisy += depth
    return np.clip(np.rint(noisy), 0, 65535).astype(np.uint16)


def shift_image(bgr: Image, px: int) -> Image:
    """Shift an image to the right, or to the left if negative, and fill the rest with black.

    Args:
        bgr: (H, W, 3).
        px: in pixels.

    >>> shift_image(np.arange(1, 10, dtype=np.uint8).reshape(1, 3, 3), 1)
    array([[[0, 0, 0],
            [1, 2, 3],
            [4, 5, 6]]], dtype=uint8)
    """
    if px == 0:
        return bgr
    shifted = np.zeros_like(bgr)
    if abs(px) < bgr.shape[1]:
        if px > 0:
            shifted[:, px:] = bgr[:, :-px]
        else:
            shifted[:, :px] = bgr[:, -px:]
    return shifted


def misalign_image(bgr: Image, px: float) -> Image:
    """Shift an image, as `shift_image`, by pixels of an image `REFERENCE_WIDTH` wide."""
    return shift_image(bgr, round(px * bgr.shape[1] / REFERENCE_WIDTH))


def blur(bgr: Image, sigma: float) -> Image:
    """Blur an image with a Gaussian; its borders are mirrored.

    Args:
        bgr: (H, W, 3).
        sigma: standard deviation in pixels, not negative.

    Raises:
        ParameterError: sigma is negative or not finite.
    """
    if not 0 <= sigma < math.inf:
        raise ParameterError(f"The sigma of a blur must be a finite number from 0 on, got {sigma!r}.")
    if sigma == 0:
        return bgr
    blurred: Image = cv2.GaussianBlur(bgr, (0, 0), sigma)
    return blurred


def defocus_image(bgr: Image, sigma: float) -> Image:
    """Blur an image, as `blur`, by pixels of an image `REFERENCE_WIDTH` wide."""
    return blur(bgr, sigma * bgr.shape[1] / REFERENCE_WIDTH)


def sharpness(bgr: Image) -> float:
    """Return an image's sharpness: the variance of its grey image's Laplacian over the variance of the grey image.

    It does not depend on brightness and contrast, as long as nothing saturates and rounding is small. It is 0 for an
    image of a single colour, and at most 64, for a chequerboard of single pixels.

    Args:
        bgr: (H, W, 3), not empty.
    """
    grey = cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY)
    _, deviation = cv2.meanStdDev(grey)
    contrast = float(deviation[0, 0])
    if contrast == 0:
        return 0.0
    _, detail = cv2.meanStdDev(cv2.Laplacian(grey, cv2.CV_16S))
    return (float(detail[0, 0]) / contrast) ** 2
