"""Figures of several runs: mean, standard deviation and confidence interval."""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from sunset.evaluation.intervals import LEAST_LEVELS, Cluster, Spread, spread

DEVIATIONS: Final = "±: the sample standard deviation over runs."
INTERVALS: Final = (
    "In brackets: the 95 % confidence interval of the mean, that of crossed random effects (Searle, Casella and "
    "McCulloch 1992) with degrees of freedom after Satterthwaite (1946). Runs with the same degradations, on the same "
    "flight, and of the same seed are correlated; without degradations, those with the same failures. Where at least "
    f"{LEAST_LEVELS} degradations or flights were run, the interval holds for others, too; else for these only."
)
"""Notes for tables with deviations and intervals."""

NO_INTERVAL: Final = (
    f"Figures of fewer than {LEAST_LEVELS} seeds have no confidence interval: nothing says how much repetitions "
    "differ. A seed with less than half as many runs as another does not count."
)
"""A note for tables with such figures."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure of several runs.

    Attributes:
        mean: over the runs that have the figure.
        std: their sample standard deviation (division by n - 1); None for a single run or a ratio.
        low: lower end of the mean's 95 % confidence interval; None for fewer than three seeds.
        high: its upper end.
        runs: the number of runs that have the figure.
        spread: the variances behind the interval; None without an interval.
    """

    mean: float
    std: float | None
    low: float | None
    high: float | None
    runs: int
    spread: Spread | None = field(default=None, repr=False, compare=False)

    @property
    def interval(self) -> tuple[float, float] | None:
        """The ends of the interval, or None."""
        return None if self.low is None or self.high is None else (self.low, self.high)

    @property
    def lacks_interval(self) -> bool:
        """Whether several runs have too few seeds for an interval."""
        return self.runs > 1 and self.low is None

    def limited(self, least: float, most: float) -> "Estimate":
        """Return it with an interval within the limits of the figure."""
        if self.low is None or self.high is None:
            return self
        return replace(self, low=max(self.low, least), high=min(self.high, most))

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {"mean": self.mean, "std": self.std, "ci95": self.interval, "runs": self.runs}


def estimate(values: Sequence[float | None], clusters: Sequence[Cluster]) -> Estimate | None:
    """Return the mean of the values that are not None, with its interval; None without a value.

    Args:
        values: of each run.
        clusters: of each run.

    >>> estimate([1.0, None], [Cluster("noise", "town", 1)] * 2)
    Estimate(mean=1.0, std=None, low=None, high=None, runs=1)
    """
    known = [(value, cluster) for value, cluster in zip(values, clusters, strict=True) if value is not None]
    if not known:
        return None
    tops = [value for value, _ in known]
    deviation = statistics.stdev(tops) if len(tops) > 1 else None
    return _estimate(tops, [1.0] * len(tops), [cluster for _, cluster in known], deviation)


def estimate_ratio(tops: Sequence[float], bottoms: Sequence[float], clusters: Sequence[Cluster]) -> Estimate:
    """Return the mean of the tops over the mean of the bottoms, which is above 0, with its interval.

    Args:
        tops: of each run; at least one.
        bottoms: of each run.
        clusters: of each run.
    """
    return _estimate(tops, bottoms, clusters, None)


def _estimate(
    tops: Sequence[float], bottoms: Sequence[float], clusters: Sequence[Cluster], std: float | None
) -> Estimate:
    figure = math.fsum(tops) / math.fsum(bottoms)
    variances = spread(tops, bottoms, clusters)
    if variances is None:
        return Estimate(figure, std, None, None, len(tops))
    half = variances.half_width
    return Estimate(figure, std, figure - half, figure + half, len(tops), variances)
