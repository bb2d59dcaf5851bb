"""Time without segmentation."""

from typing import Final

import numpy as np
import numpy.typing as npt

TOLERANCE_S: Final = 1e-6
"""Times that differ by less are equal: the error of arithmetic in seconds."""

_PERIODS: Final = 2  # a gap up to this many periods is the expected rate, with jitter


def downtime(times: npt.NDArray[np.float64], *, period_s: float, duration_s: float) -> float:
    """Return the total time in [0, `duration_s`] without messages at the expected rate.

    Every gap of more than two periods counts whole, as far as it lies in the experiment, also before the first message
    and after the last.

    Args:
        times: (N,) ascending, when messages left [s]. The last message before 0 begins the first gap, which begins at 0
            without such a message.
        period_s: the expected time between two messages.
        duration_s: the end of the experiment.

    Source: the paper, section 4, on the system's downtime.

    >>> downtime(np.array([0.0, 0.1, 0.2, 0.7, 0.8]), period_s=0.1, duration_s=2.0)
    1.7
    """
    before = times[times < 0]
    within = times[(times >= 0) & (times <= duration_s)]
    start = before[-1] if before.size else 0.0
    moments = np.concatenate([[start], within, [duration_s]])
    gaps = np.diff(moments)
    inside = np.diff(np.maximum(moments, 0.0))
    return round(float(inside[gaps > _PERIODS * period_s + TOLERANCE_S].sum()), 9)
