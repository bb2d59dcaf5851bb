"""How often the intervals of reports hold what is true, and whether power is kept: simulated campaigns of known truth.

A campaign's differences in IoU_net, and what repairing wins in it, are drawn from a model of crossed random effects: of
degradations, flights, seeds, each two of them, and all three. A campaign on fewer than three flights speaks of these
flights only, so that their effects are part of its truth. The models:

- those of two managing systems, which differ as much as theirs did on the panel of flights (`VARIANCES`);
- `seeds`: seeds matter as much as degradations do;
- `even`: every effect is the same.

Effects are of a normal distribution, or with `--effects skewed` of a lognormal one, of which most are small and a few
great: as if a managing system failed with few degradations, and totally. Intervals hold less often then.

Prints, for 3, 5 and 9 degradations, the least and the most often that the 95 % intervals of a paired difference and of
a score hold the true one, over campaigns on 1 to 4 flights with 3 to 5 seeds; and how often a difference is told of
which reports say that such campaigns detect it with 80 %.
"""

import argparse
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.evaluation import Cluster
from sunset.evaluation.intervals import LEAST_LEVELS, Design, Spread, spread
from sunset.evaluation.power import POWER, VARIANCES, detectable
from sunset.seeding import generator
from sunset.tables import aligned

_Array = npt.NDArray[np.float64]
_Parts = Mapping[tuple[int, ...], float]

DEGRADATIONS: Final = (3, 5, 9)
FLIGHTS: Final = (1, 2, 3, 4)
SEEDS: Final = (3, 4, 5)
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
SCORE: Final = 0.7
LEVEL: Final = 0.05
GAIN: Final = 0.35
"""What repairing can win in the mean; it varies as much as differences do, by effects of its own."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """The shares of simulated campaigns in which something held.

    Attributes:
        difference: the interval of a difference held the true one.
        score: likewise of a score.
        power: a difference was told that is detectable with `POWER`.
    """

    difference: float
    score: float
    power: float


def _standardised(drawn: _Array) -> _Array:
    """Return numbers of a lognormal distribution with mean 0 and variance 1."""
    return (drawn - math.sqrt(math.e)) / math.sqrt((math.e - 1) * math.e)


def measure(parts: _Parts, size: Design, campaigns: int, seed: int = 1, effects: str = "normal") -> Coverage:
    """Return how often the intervals of campaigns of a size hold."""
    clusters = [Cluster(*levels) for levels in product(*map(range, size))]
    random = generator(seed, "coverage", *size)
    step = detectable(Spread(parts, size))
    held = np.zeros(3)
    for _ in range(campaigns):
        values, truth = draw(parts, size, random, effects)
        gains, gain = draw(parts, size, random, effects)
        gains, gain = GAIN + gains, GAIN + gain
        mean = float(values.mean())
        speaks_against = _test(values, np.ones_like(values), clusters)
        scored = _test(SCORE * gains + values, gains, clusters)
        ratio = float((SCORE * gains + values).sum() / gains.sum())
        held += (
            not speaks_against(mean - truth),
            not scored(ratio - SCORE - truth / gain),
            speaks_against(mean - truth + step),
        )
    return Coverage(*(held / campaigns).tolist())


def draw(
    parts: _Parts, size: Design, random: np.random.Generator, effects: str = "normal"
) -> tuple[_Array, float]:
    """Return the values of a campaign by degradations, flight and seed, and what they are in the mean of all campaigns.

    Args:
        parts: factors → variance.
        size: of the campaign.
        random: what is drawn from.
        effects: their distribution, of `EFFECTS`.
    """
    values, truth = np.zeros(size), 0.0
    for factors, variance in parts.items():
        levels = tuple(size[place] if place in factors else 1 for place in range(3))
        drawn = np.sqrt(variance) * EFFECTS[effects](random, levels)
        values = values + drawn
        if factors == (1,) and size.flights < LEAST_LEVELS:
            truth = float(drawn.mean())
    return values, truth


def _test(tops: _Array, bottoms: _Array, clusters: Sequence[Cluster]) -> Callable[[float], bool]:
    """Return whether Σ tops / Σ bottoms is so far from something that its interval excludes that: p is under 5 %."""
    found = spread(tops.ravel().tolist(), bottoms.ravel().tolist(), clusters)
    if found is None:
        raise SystemExit("A campaign of this size has no interval.")
    return lambda distance: found.p_value(distance) < LEVEL


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
    parser.add_argument("--campaigns", type=int, default=4000, help="of each size and model (default: 4000)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--effects", choices=EFFECTS, default="normal", help="(default: normal)")
    arguments = parser.parse_args()
    head = ["degradations", "model", "difference", "score", f"detected of {100 * POWER:g} %"]
    rows = _rows(arguments.campaigns, arguments.seed, arguments.effects)
    print("\n".join(aligned([head, *rows], left=(1,))))


if __name__ == "__main__":
    main()
