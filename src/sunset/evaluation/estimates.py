"""What several runs say together: mean, standard deviation and confidence interval."""

import math
import statistics
from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

CONFIDENCE: Final = 0.95

_LEAST_CLUSTERS: Final = 3
"""An interval of two has one degree of freedom, and is so wide that it says nothing."""

METHOD: Final = (
    "Mean ± sample standard deviation over runs; 95 % confidence interval of the mean by Student's t, "
    "with the runs of one scenario as one cluster (where there is one scenario only, each run is its own)."
)
"""How the figures of a table come about, in words."""

NO_INTERVAL: Final = f"Figures of fewer than {_LEAST_CLUSTERS} clusters have no confidence interval."
"""What stands beneath a table in which there are such."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A figure of several runs.

    Attributes:
        mean: over the runs that have the figure.
        std: their sample standard deviation (division by n - 1); None of a single run.
        low: lower end of the mean's 95 % confidence interval; None of fewer than three clusters.
        high: its upper end.
        runs: how many have the figure.
    """

    mean: float
    std: float | None
    low: float | None
    high: float | None
    runs: int

    @property
    def lacks_interval(self) -> bool:
        """Whether there are several runs, but too few clusters for an interval."""
        return self.runs > 1 and self.low is None

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        interval = None if self.low is None else [self.low, self.high]
        return {"mean": self.mean, "std": self.std, "ci95": interval, "runs": self.runs}


def estimate(values: Sequence[float | None], clusters: Sequence[Hashable]) -> Estimate | None:
    """Return the mean of the values that are there, and how sure it is; None if there is no value.

    Repetitions of one scenario resemble each other, so that they count as one cluster: the variance of the
    mean is `G / (G - 1) · Σ (Σ (x - mean))² / n²`, the inner sum over a cluster's values, the outer over
    the G clusters, and the interval is Student's with G - 1 degrees of freedom. With as many repetitions of
    each scenario it is the t interval of the scenarios' means; with clusters of one, the usual one. Fewer than three
    clusters have no interval.

    Args:
        values: one a run; None where the run has none.
        clusters: of the same length, which cluster each run belongs to.

    Raises:
        ValueError: the lengths differ.

    >>> estimate([1.0, None], ["a", "a"])
    Estimate(mean=1.0, std=None, low=None, high=None, runs=1)
    """
    known = [(value, cluster) for value, cluster in zip(values, clusters, strict=True) if value is not None]
    if not known:
        return None
    mean = math.fsum(value for value, _ in known) / len(known)
    if len(known) == 1:
        return Estimate(mean, None, None, None, 1)
    groups: dict[Hashable, list[float]] = {}
    single = len({cluster for _, cluster in known}) == 1
    for position, (value, cluster) in enumerate(known):
        groups.setdefault(position if single else cluster, []).append(value - mean)
    count = len(groups)
    deviation = statistics.stdev(value for value, _ in known)
    if count < _LEAST_CLUSTERS:
        return Estimate(mean, deviation, None, None, len(known))
    squares = math.fsum(math.fsum(deviations) ** 2 for deviations in groups.values())
    error = math.sqrt(count / (count - 1) * squares) / len(known)
    half = student_quantile(count - 1) * error
    return Estimate(mean, deviation, mean - half, mean + half, len(known))


def compare_means(
    rows: Sequence[tuple[Hashable, float | None, float | None]],
) -> tuple[float | None, float | None, Estimate | None, int]:
    """Compare a figure of pairs of runs.

    Args:
        rows: of each pair, its cluster, and the figure of its two runs; None where one has none.

    Returns:
        Over the pairs in which both have it: the mean of the first, of the second, and the estimate of first - second,
        each None where there is no such pair; and in how many more pairs only one has it.
    """
    both = [(name, one, other) for name, one, other in rows if one is not None and other is not None]
    return (
        statistics.fmean(one for _, one, _ in both) if both else None,
        statistics.fmean(other for _, _, other in both) if both else None,
        estimate([one - other for _, one, other in both], [name for name, _, _ in both]),
        sum((one is None) != (other is None) for _, one, other in rows),
    )


@lru_cache(maxsize=256)
def student_quantile(degrees: int) -> float:
    """Return the t that a Student-distributed number exceeds, in magnitude, with a probability of 5 %.

    Raises:
        ValueError: there is less than one degree of freedom.

    >>> round(student_quantile(2), 3)
    4.303
    """
    if degrees < 1:
        raise ValueError(f"There must be at least 1 degree of freedom, got {degrees}.")
    low, high = 0.0, 16.0  # of one degree of freedom it is 12.7, of more it is less
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if _within(middle, degrees) < CONFIDENCE else (low, middle)
    return high


def _within(t: float, degrees: int) -> float:
    """Return the probability of a magnitude up to t.

    Source: Abramowitz and Stegun, Handbook of Mathematical Functions, 26.7.3 and 26.7.4.
    """
    angle = math.atan2(t, math.sqrt(degrees))
    square = math.cos(angle) ** 2
    odd = degrees % 2
    term = math.cos(angle) if odd else 1.0
    total = 0.0 if degrees == 1 else term
    for k in range(1 + odd, degrees - 1, 2):
        term *= k / (k + 1) * square
        total += term
    return 2 / math.pi * (angle + math.sin(angle) * total) if odd else math.sin(angle) * total
