"""How often the intervals of reports hold what is true, and whether power is kept: simulated campaigns of known truth.

A campaign's differences in IoU_net, and what repairing wins in it, are drawn from a model of crossed random effects: of
degradations, flights, seeds, each two of them, and all three. A campaign on fewer than three flights speaks of these
flights only, so that their effects are part of its truth. The models:

- `measured`: as much as managing systems of this package differed on the panel of flights (`VARIANCES`);
- `seeds`: seeds matter as much as degradations do;
- `even`: every effect is the same.

Effects are of a normal distribution, or with `--effects skewed` of a lognormal one, of which most are small and a few
great: as if a managing system failed with few degradations, and totally. Intervals of means hold less often then.

Prints, for each size of a campaign, how many of the 95 % intervals of a paired difference and of a score hold the true
one, the power that was promised for a difference of 0.02 and for the difference that is told with 80 %, and how
often such differences were told. A size without an interval has none that could hold.
"""

import argparse
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.evaluation import Cluster, Estimate, estimate
from sunset.evaluation.estimates import estimate_ratio
from sunset.evaluation.power import DIFFERENCE, POWER, VARIANCES, Design, Variances, least_difference, power
from sunset.evaluation.resampling import LEAST_LEVELS, subsets
from sunset.seeding import generator
from sunset.tables import aligned

_Array = npt.NDArray[np.float64]

SIZES: Final = (
    Design(alike=27, flights=1, repetitions=3),
    Design(alike=27, flights=5, repetitions=3),
    Design(alike=9, flights=1, repetitions=3),
    Design(alike=9, flights=8, repetitions=3),
    Design(alike=9, flights=1, repetitions=10),
    Design(alike=6, flights=1, repetitions=3),
    Design(alike=27, flights=1, repetitions=1),
)
EVERY: Final = tuple(subsets(range(3)))
MODELS: Final[Mapping[str, Mapping[tuple[int, ...], float]]] = MappingProxyType(
    {
        "measured": next(iter(VARIANCES.values())).parts,
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
GAIN: Final = 0.35
"""What repairing can win in the mean; it varies as much as differences do, by effects of its own."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Coverage:
    """What came of the simulated campaigns of a size; None where it has no interval."""

    model: str
    size: Design
    difference: float | None
    score: float | None
    promised: tuple[float, float] | None
    kept: tuple[float, float] | None


def _standardised(drawn: _Array) -> _Array:
    """Return numbers of a lognormal distribution with mean 0 and variance 1."""
    return (drawn - math.sqrt(math.e)) / math.sqrt((math.e - 1) * math.e)


def measure(model: str, size: Design, campaigns: int, seed: int = 1, effects: str = "normal") -> Coverage:
    """Return how often the intervals of campaigns of a size hold."""
    parts = MODELS[model]
    clusters = [
        Cluster(*levels)
        for levels in product(range(size.alike), range(size.flights), range(size.repetitions))
    ]
    if not size.is_enough:
        lacking = estimate([0.0] * len(clusters), clusters)
        assert lacking is not None and lacking.low is None  # noqa: S101, PT018  that is what is measured
        return Coverage(model=model, size=size, difference=None, score=None, promised=None, kept=None)
    random = generator(seed, "coverage", model, size.alike, size.flights, size.repetitions)
    found = Variances(parts, LEAST_LEVELS)
    told = (DIFFERENCE, least_difference(found, size))
    holds: list[bool] = []
    scored: list[bool] = []
    kept: tuple[list[bool], list[bool]] = ([], [])
    for _ in range(campaigns):
        values, truth = draw(parts, size, random, effects)
        gains, gain = draw(parts, size, random, effects)
        one = estimate(values.ravel().tolist(), clusters)
        holds.append(_holds(one, truth))
        wins = SCORE * (GAIN + gains) + values
        ratio = estimate_ratio(wins.ravel().tolist(), (GAIN + gains).ravel().tolist(), clusters)
        scored.append(_holds(ratio, SCORE + truth / (GAIN + gain)))
        for difference, tells in zip(told, kept, strict=True):
            tells.append(not _holds(one, truth - difference))
    return Coverage(
        model=model,
        size=size,
        difference=float(np.mean(holds)),
        score=float(np.mean(scored)),
        promised=(power(found, size, told[0]), power(found, size, told[1])),
        kept=(float(np.mean(kept[0])), float(np.mean(kept[1]))),
    )


def draw(
    parts: Mapping[tuple[int, ...], float], size: Design, random: np.random.Generator, effects: str = "normal"
) -> tuple[_Array, float]:
    """Return the values of a campaign by degradations, flight and seed, and what they are in the mean of all campaigns.

    Args:
        parts: factors → variance.
        size: of the campaign.
        random: what is drawn from.
        effects: their distribution, of `EFFECTS`.
    """
    shape = (size.alike, size.flights, size.repetitions)
    values, truth = np.zeros(shape), 0.0
    for factors, variance in parts.items():
        levels = tuple(shape[place] if place in factors else 1 for place in range(3))
        drawn = np.sqrt(variance) * EFFECTS[effects](random, levels)
        values = values + drawn
        if factors == (1,) and size.flights < LEAST_LEVELS:
            truth = float(drawn.mean())
    return values, truth


def _holds(found: Estimate | None, truth: float) -> bool:
    if found is None or found.low is None or found.high is None:
        raise SystemExit("A campaign of this size has no interval.")
    return found.low <= truth <= found.high


def _row(one: Coverage) -> Sequence[str]:
    size = f"{one.size.alike} x {one.size.flights} x {one.size.repetitions}"
    if one.difference is None or one.score is None or one.promised is None or one.kept is None:
        return [one.model, size, *["no interval"] * 2, *["N/A"] * 4]
    shares = (
        one.difference,
        one.score,
        *(share for pair in zip(one.promised, one.kept, strict=True) for share in pair),
    )
    return [one.model, size, *(f"{100 * share:.1f} %" for share in shares)]


def main() -> None:
    """Simulate, and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--campaigns", type=int, default=4000, help="of each size and model (default: 4000)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--effects", choices=EFFECTS, default="normal", help="(default: normal)")
    arguments = parser.parse_args()
    head = ["model", "degradations x flights x seeds", "difference", "score"]
    head += [f"promised for {DIFFERENCE:g}", "kept", f"promised for {100 * POWER:g} %", "kept"]
    rows = [
        _row(measure(model, size, arguments.campaigns, arguments.seed, arguments.effects))
        for model, size in product(MODELS, SIZES)
    ]
    print("\n".join(aligned([head, *rows], left=(0, 1))))


if __name__ == "__main__":
    main()
