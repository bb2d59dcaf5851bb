"""How often the intervals of reports hold what is true, and whether power is kept: simulated campaigns of known truth.

A campaign's differences in utility, and what repairing wins in it, are drawn from a model of crossed random effects: of
degradations, flights, seeds, each two of them, and all three. A campaign on fewer than three flights speaks of these
flights only, so that their effects are part of its truth. The models:

- those of two managing systems, which differ as much as theirs did on the panel of flights (`VARIANCES`);
- `seeds`: seeds matter as much as degradations do;
- `even`: every effect is the same.

Effects are of a normal distribution, or with `--effects skewed` of a lognormal one, of which most are small and a few
great: as if a managing system failed with few degradations, and totally.

Prints, for 3, 5 and 9 degradations, the lowest and the highest coverage of the 95 % intervals of a paired difference
and of a score, over campaigns on 1, 3 and 4 flights with 3 and 5 seeds; and how often a difference is detected that
reports call detectable with 80 %.
"""

import argparse
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, product
from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.evaluation.differences import POWER, VARIANCES, detectable
from sunset.evaluation.intervals import LEAST_LEVELS, Cluster, Design, Spread, quantile, spread
from sunset.texts.tables import aligned
from sunset_ros.seeding import generator

_Array = npt.NDArray[np.float64]
_Parts = Mapping[tuple[int, ...], float]

DEGRADATIONS: Final = (3, 5, 9)
FLIGHTS: Final = (1, 3, 4)  # two are held as they are, as one is
SEEDS: Final = (3, 5)
EVERY: Final = tuple(factors for count in (1, 2, 3) for factors in combinations(range(3), count))
MODELS: Final[Mapping[str, _Parts]] = MappingProxyType(
    {
        **{pair: found.parts for pair, found in VARIANCES.items()},
        "seeds": {**dict.fromkeys(EVERY, 0.01**2), (0,): 0.03**2, (2,): 0.03**2},
        "even": dict.fromkeys(EVERY, 0.02**2),
    }
)
EFFECTS: Final[Mapping[str, Callable[[np.random.Generator, tuple[int, ...]], _Array]]] = MappingProxyType(
    {
        "normal": lambda random, shape: random.standard_normal(shape),
        "skewed": lambda random, shape: _standardised(random.lognormal(size=shape)),
    }
)
"""Distributions of mean 0 and variance 1."""
_SEEDS: Final = 3
SCORE: Final = 0.7
GAIN: Final = 0.35
"""What repairing can win in the mean; it varies as much as differences do, by effects of its own."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """The shares of simulated campaigns in which something held.

    Attributes:
        difference: the interval of a difference held the true one.
        score: likewise of a score.
        power: a difference was detected that is detectable with `POWER`.
    """

    difference: float
    score: float
    power: float


def _standardised(drawn: _Array) -> _Array:
    """Return numbers of a lognormal distribution with mean 0 and variance 1."""
    return (drawn - math.sqrt(math.e)) / math.sqrt((math.e - 1) * math.e)


def measure(parts: _Parts, size: Design, campaigns: int, seed: int = 1, effects: str = "normal") -> Coverage:
    """Return how often the intervals of campaigns of a size hold."""
    random = generator(seed, "coverage", *size)
    values, truth = draw(parts, size, campaigns, random, effects)
    gains, gain = draw(parts, size, campaigns, random, effects)
    gains, gain = GAIN + gains, GAIN + gain
    means, halves = intervals(values, np.ones_like(values))
    scores, score_halves = intervals(SCORE * gains + values, gains)
    step = detectable(Spread(parts, size))
    return Coverage(
        difference=float(np.mean(abs(means - truth) <= halves)),
        score=float(np.mean(abs(scores - SCORE - truth / gain) <= score_halves)),
        power=float(np.mean(abs(means - truth + step) > halves)),
    )


def draw(
    parts: _Parts, size: Design, campaigns: int, random: np.random.Generator, effects: str = "normal"
) -> tuple[_Array, _Array]:
    """Return the values of campaigns, and for each campaign what they are in the mean of all campaigns.

    Args:
        parts: factors → variance.
        size: of the campaigns.
        campaigns: how many.
        random: what is drawn from.
        effects: their distribution, of `EFFECTS`.

    Returns:
        (campaigns, degradations, flights, seeds), and (campaigns,).
    """
    values, truth = np.zeros((campaigns, *size)), np.zeros(campaigns)
    for factors, variance in parts.items():
        levels = tuple(size[place] if place in factors else 1 for place in range(3))
        drawn = np.sqrt(variance) * EFFECTS[effects](random, (campaigns, *levels))
        values += drawn
        if factors == (1,) and size.flights < LEAST_LEVELS:
            truth = drawn.mean((1, 2, 3))
    return values, truth


def intervals(tops: _Array, bottoms: _Array) -> tuple[_Array, _Array]:
    """Return Σ tops / Σ bottoms of campaigns, and half the width of their intervals.

    These are the intervals of reports, written for many campaigns at once and without gaps: the first is compared.
    """
    whole = bottoms.sum((1, 2, 3), keepdims=True)
    ratios = tops.sum((1, 2, 3), keepdims=True) / whole
    held = tuple(axis for axis in (1, 2, 3) if tops.shape[axis] < LEAST_LEVELS)
    apart = ((tops - ratios * bottoms) / whole).sum(held, keepdims=True)
    free = [axis for axis in (1, 2, 3) if axis not in held]
    sizes, cells = {axis: apart.shape[axis] for axis in free}, math.prod(apart.shape[1:])
    sums = {axis: apart.sum(tuple(other for other in (1, 2, 3) if other != axis)) for axis in free}
    squares = {axis: (sums[axis] ** 2).sum(1) * sizes[axis] / (sizes[axis] - 1) for axis in free}
    explained = np.sum([(sums[axis] ** 2).sum(1) * sizes[axis] for axis in free], axis=0) / cells
    left = cells - 1 - sum(size - 1 for size in sizes.values())
    rest = ((apart**2).sum((1, 2, 3)) - explained) * cells / left
    errors = np.sqrt(rest + np.sum([np.maximum(0, square - rest) for square in squares.values()], axis=0))
    squares |= {axis: np.maximum(square, rest) for axis, square in squares.items() if axis != _SEEDS}
    known = np.sum([square**2 / (sizes[axis] - 1) for axis, square in squares.items()], axis=0)
    halves = errors * _t(np.sum(list(squares.values()), axis=0) ** 2 / known)
    _compare(tops[0], bottoms[0], float(halves[0]))
    return ratios[:, 0, 0, 0], halves


def _t(degrees: _Array) -> _Array:
    """Return Student's t of 95 %, interpolated between knots that are close."""
    knots = np.linspace(1e-3, 0.5, 300)
    return np.interp(1 / degrees, knots, _quantiles(tuple(knots.tolist())))


@lru_cache(maxsize=1)
def _quantiles(knots: tuple[float, ...]) -> _Array:
    return np.array([quantile(0.95, 1 / knot) for knot in knots])


def _compare(tops: _Array, bottoms: _Array, half: float) -> None:
    clusters = [Cluster(*levels) for levels in np.ndindex(tops.shape)]
    found = spread(tops.ravel().tolist(), bottoms.ravel().tolist(), clusters)
    if found is None or not math.isclose(found.half_width, half, rel_tol=1e-3):
        raise SystemExit(f"Reports have {found and found.half_width}, and the simulation {half}.")


def _rows(campaigns: int, seed: int, effects: str) -> Iterator[list[str]]:
    for alike in DEGRADATIONS:
        every: list[Coverage] = []
        for model, parts in MODELS.items():
            found = [
                measure(parts, Design(alike, flights, seeds), campaigns, seed, effects)
                for flights, seeds in product(FLIGHTS, SEEDS)
            ]
            every += found
            yield [str(alike), model, *_ranges(found)]
        yield [str(alike), "all", *_ranges(every)]


def _ranges(found: Sequence[Coverage]) -> list[str]:
    shares = ([one.difference for one in found], [one.score for one in found], [one.power for one in found])
    return [f"{100 * min(each):.1f} – {100 * max(each):.1f} %" for each in shares]


def main() -> None:
    """Simulate, and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--campaigns", type=int, default=10000, help="of each size and model (default: 10000)"
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--effects", choices=EFFECTS, default="normal", help="(default: normal)")
    arguments = parser.parse_args()
    head = ["degradations", "model", "difference", "score", f"detected of {100 * POWER:g} %"]
    rows = _rows(arguments.campaigns, arguments.seed, arguments.effects)
    print("\n".join(aligned([head, *rows], left=(1,))))


if __name__ == "__main__":
    main()
