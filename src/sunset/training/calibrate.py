"""Temperatures: what makes the entropies of networks comparable."""

from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.errors import DataError, ModelError
from sunset.metrics import normalised_entropy
from sunset.training.inputs import upsampling

_EVERY: Final = 3
"""Odd, so that pixels near to and far from a logit take part."""
_LIMITS: Final = (0.05, 20.0)


def _sampled(low: npt.NDArray[np.float32], width: int) -> npt.NDArray[np.float32]:
    """Return every third row and column of logits (28, h, w) interpolated to a width."""
    factor, rest = divmod(width, low.shape[2])
    if rest:
        raise ModelError(
            f"The width of a network's logits must divide that of its frames, {width}, got {low.shape[2]}: export "
            "or import it with this version."
        )
    rows = upsampling(low.shape[1], factor)[::_EVERY]
    columns = upsampling(low.shape[2], factor)[::_EVERY]
    full: npt.NDArray[np.float32] = np.einsum("ih,chw,jw->cij", rows, low, columns, optimize=True)
    return full


def _mean_entropy(logits: list[npt.NDArray[np.float32]], temperature: float) -> float:
    return float(np.mean([normalised_entropy(frame, temperature=temperature) for frame in logits]))


def temperature_for(logits: list[npt.NDArray[np.float32]], entropy: float, width: int) -> float:
    """Return the temperature, to four digits, at which the mean entropy of frames is as wanted, normalised in (0, 1).

    Logits are per frame (28, h, w); they are interpolated to the frames' width in pixels, a multiple of theirs.

    Raises:
        DataError: no temperature from 0.05 to 20 reaches it.
        ModelError: the width is not a multiple of that of the logits.
    """
    logits = [_sampled(frame, width) for frame in logits]
    low, high = _LIMITS
    if not _mean_entropy(logits, low) < entropy < _mean_entropy(logits, high):
        raise DataError(
            f"No temperature from {low} to {high} gives the networks a mean entropy of {entropy:.4f}."
        )
    for _ in range(24):  # entropy rises with temperature
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if _mean_entropy(logits, middle) < entropy else (low, middle)
    return round(float(np.sqrt(low * high)), 4)
