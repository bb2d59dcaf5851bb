"""The moment at which a page opens."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from sunset.viewing.document import RunView

_ABOUT_S: Final = 2.0
"""How long two runs are compared about a moment."""
_ALIKE: Final = 0.05
"""Two runs whose IoU differs by less look alike."""


def opening(runs: Sequence[RunView]) -> float:
    """Return where two runs differ most in their IoU, else when the first fault showed, or came.

    Args:
        runs: one, or two of the same faults and flight.
    """
    came = min((since for run in runs for fault in run.faults for since, _ in fault.spans), default=0.0)
    if len(runs) > 1:
        differing = _differing(*runs)
        if differing is not None:
            return differing
    return min(
        (one.time for run in runs for one in run.events if one.kind == "symptom" and one.time >= came),
        default=came,
    )


def _differing(one: RunView, other: RunView) -> float | None:
    """Return the moment about which the IoU of two runs differs most; None where it never does much."""
    pairs = zip(one.frames.times, one.frames.iou, other.frames.iou, strict=False)  # live, one may have more
    times, ours, theirs = np.array([(time, a or 0.0, b or 0.0) for time, a, b in pairs]).reshape(-1, 3).T
    frames = max(round(_ABOUT_S / one.period), 1)
    if len(times) < frames:
        return None
    means = np.convolve(np.abs(ours - theirs), np.full(frames, 1 / frames), "same")
    return float(times[means.argmax()]) if means.max() >= _ALIKE else None
