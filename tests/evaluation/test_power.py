import math

import pytest
from benchmarks.coverage import measure

from sunset.evaluation.power import (
    MOST_REPETITIONS,
    VARIANCES,
    Design,
    Variances,
    least_difference,
    power,
    repetitions_needed,
    variances,
)
from sunset.evaluation.resampling import LEAST_LEVELS, Component, Spread

SEEDS_ONLY = Variances({(2,): 0.03**2}, 1)


def repeated(repetitions: int) -> Design:
    return Design(alike=1, flights=1, repetitions=repetitions)


@pytest.mark.parametrize("repetitions", [3, 5, 20])
def test_of_one_factor_power_is_that_of_the_t_test(repetitions: int) -> None:
    stats = pytest.importorskip("scipy.stats")
    degrees = repetitions - 1
    t = stats.t.ppf(0.975, degrees)
    shift = 0.02 / (0.03 / math.sqrt(repetitions))
    expected = 1 - stats.nct.cdf(t, degrees, shift) + stats.nct.cdf(-t, degrees, shift)
    assert power(SEEDS_ONLY, repeated(repetitions)) == pytest.approx(expected, abs=0.01)


def test_the_least_difference_is_told_with_the_chance_that_was_asked_for() -> None:
    least = least_difference(SEEDS_ONLY, repeated(10))
    assert power(SEEDS_ONLY, repeated(10), least) == pytest.approx(0.8, abs=1e-3)
    assert least_difference(SEEDS_ONLY, repeated(40)) < least


def test_the_least_number_of_repetitions_is_told() -> None:
    needed = repetitions_needed(SEEDS_ONLY, repeated(3))
    assert needed is not None
    assert power(SEEDS_ONLY, repeated(needed)) >= 0.8 > power(SEEDS_ONLY, repeated(needed - 1))


def test_repetitions_do_not_help_against_degradations_that_differ() -> None:
    found = Variances({(0,): 0.05**2}, 1)
    design = Design(alike=9, flights=1, repetitions=3)
    assert repetitions_needed(found, design) is None
    assert power(found, Design(alike=9, flights=1, repetitions=MOST_REPETITIONS)) < 0.5


def test_what_varies_between_flights_is_part_of_the_truth_on_fewer_than_three() -> None:
    found = Variances({(1,): 0.5**2, (2,): 0.001**2}, 8)
    assert power(found, Design(alike=9, flights=2, repetitions=3)) == pytest.approx(1, abs=0.01)
    assert power(found, Design(alike=9, flights=3, repetitions=3)) < 0.1


def test_variances_of_few_flights_say_nothing_of_more() -> None:
    few = Variances({(2,): 0.01**2}, 1)
    assert few.reaches(Design(alike=9, flights=1, repetitions=3))
    assert not few.reaches(Design(alike=9, flights=LEAST_LEVELS, repetitions=3))


def test_variances_of_few_degradations_say_nothing_of_more() -> None:
    spread = Spread((Component((2,), 0.01, 2),), (2, 1, 3))
    assert variances(spread).reaches(Design(alike=2, flights=1, repetitions=3))
    assert not variances(spread).reaches(Design(alike=LEAST_LEVELS, flights=1, repetitions=3))


def test_variances_are_those_between_runs_and_not_of_their_mean() -> None:
    spread = Spread((Component((0,), 0.01, 8), Component((0, 2), 0.001, 16)), (9, 1, 3))
    assert variances(spread).parts == pytest.approx({(0,): 0.09, (0, 2): 0.027})
    assert variances(spread).flights == 1


def test_what_never_varies_is_always_told() -> None:
    assert power(Variances({(2,): 0.0}, 1), repeated(3)) == 1


def test_managing_systems_that_were_measured_say_how_every_factor_varies() -> None:
    for found in VARIANCES.values():
        assert len(found.parts) == 7
        assert found.reaches(Design(alike=9, flights=8, repetitions=3))


@pytest.mark.thorough
@pytest.mark.parametrize("model", ["measured", "seeds", "even"])
def test_intervals_hold_and_power_is_kept_in_simulated_campaigns(model: str) -> None:
    found = measure(model, Design(alike=9, flights=1, repetitions=3), campaigns=500)
    assert found.difference is not None
    assert found.score is not None
    assert found.promised is not None
    assert found.kept is not None
    # 93 to 97 %, and what 500 campaigns are off by chance
    assert 0.92 < found.difference < 0.98
    assert 0.92 < found.score < 0.98
    assert found.kept == pytest.approx(found.promised, abs=0.05)


def test_simulated_campaigns_with_too_few_seeds_have_no_interval() -> None:
    found = measure("even", Design(alike=27, flights=1, repetitions=2), campaigns=1)
    assert (found.difference, found.score, found.kept) == (None, None, None)
