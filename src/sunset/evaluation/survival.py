"""Times to an event of which some are only known to be longer: the estimate of Kaplan and Meier."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True, eq=False)
class Survival:
    """The share that has not had the event yet, over time.

    Attributes:
        times: (K,) ascending, when there were events.
        shares: (K,) the share without the event from each of these times on; before the first it is 1.
        number: of what was observed.
        events: how many had the event.
    """

    times: npt.NDArray[np.float64]
    shares: npt.NDArray[np.float64]
    number: int
    events: int

    def restricted_mean(self, horizon: float) -> float:
        """Return the mean time to the event, where every time beyond a horizon counts as that.

        It is the area under the curve up to the horizon. Where observation ended before, the curve stays as it is.

        >>> kaplan_meier([1.0, 3.0], [True, False]).restricted_mean(4.0)
        2.5
        """
        inside = self.times < horizon
        edges = np.concatenate([[0.0], self.times[inside], [horizon]])
        shares = np.concatenate([[1.0], self.shares[inside]])
        return float((np.diff(edges) * shares).sum())


def kaplan_meier(durations: Sequence[float], happened: Sequence[bool]) -> Survival:
    """Estimate which share has not had an event yet, over time.

    Args:
        durations: (N,) how long each was observed, at least 0: to its event, or to the end of its observation.
        happened: (N,) whether it had its event then. One whose observation ends at the time of another's event was
            still without it at that time.

    Source: Kaplan and Meier, Nonparametric estimation from incomplete observations, 1958.

    >>> kaplan_meier([1.0, 2.0, 2.0, 3.0], [True, True, False, True]).shares.tolist()
    [0.75, 0.5, 0.0]
    """
    observed = np.asarray(durations, dtype=np.float64)
    events = np.asarray(happened, dtype=bool)
    times, counts = np.unique(observed[events], return_counts=True)
    at_risk = len(observed) - np.searchsorted(np.sort(observed), times, side="left")
    shares = np.cumprod(1.0 - counts / at_risk, dtype=np.float64)
    return Survival(times, shares, len(observed), int(events.sum()))
