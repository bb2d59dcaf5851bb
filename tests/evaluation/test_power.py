from dataclasses import replace

import pytest
from benchmarks.coverage import MODELS, measure

from sunset.evaluation.differences import (
    DIFFERENCE,
    MOST_REPETITIONS,
    VARIANCES,
    detectable,
    power,
    reaches,
    repetitions_needed,
)
from sunset.evaluation.intervals import LEAST_LEVELS, Design, Spread


def repeated(repetitions: int) -> Spread:
    """Return a spread to which seeds alone contribute."""
    return Spread({(2,): 0.03**2}, Design(alike=1, flights=1, repetitions=repetitions))


@pytest.mark.parametrize("repetitions", [5, 10, 20])
def test_of_one_factor_power_is_that_of_the_t_test(repetitions: int) -> None:
    stats = pytest.importorskip("scipy.stats")
    found, degrees = repeated(repetitions), repetitions - 1
    t, shift = stats.t.ppf(0.975, degrees), detectable(found) / found.error
    expected = 1 - stats.nct.cdf(t, degrees, shift) + stats.nct.cdf(-t, degrees, shift)
    assert power(found, detectable(found)) == pytest.approx(0.8)
    assert expected == pytest.approx(0.8, abs=0.01)


def test_what_is_detectable_is_computed_by_hand() -> None:
    # of nine degrees of freedom, 2.262 is the t of 95 %, and 0.883 that of 80 % on one side
    assert detectable(repeated(10)) == pytest.approx((2.262 + 0.883) * 0.03 / 10**0.5, rel=1e-3)


def test_a_difference_far_under_what_is_detectable_is_hardly_detected() -> None:
    # a t that is beyond that of 95 % on the right side by chance alone
    assert power(repeated(3), 1e-6) == pytest.approx(0.025, abs=1e-4)
    assert power(repeated(100), 0.1) == pytest.approx(1)


def test_the_least_number_of_repetitions_is_found() -> None:
    needed = repetitions_needed(repeated(3))
    assert needed is not None
    assert power(repeated(needed)) >= 0.8 > power(repeated(needed - 1))
    assert detectable(repeated(needed)) <= DIFFERENCE < detectable(repeated(needed - 1))


def test_repetitions_do_not_help_against_degradations_that_differ() -> None:
    found = Spread({(0,): 0.05**2}, Design(alike=9, flights=1, repetitions=3))
    assert repetitions_needed(found) is None
    assert power(replace(found, sizes=found.sizes._replace(repetitions=MOST_REPETITIONS))) < 0.5


def test_variances_of_few_flights_or_degradations_say_nothing_of_more() -> None:
    few = Spread({(2,): 0.01**2}, Design(alike=2, flights=1, repetitions=3))
    assert reaches(few, Design(alike=1, flights=2, repetitions=3))
    assert not reaches(few, Design(alike=2, flights=LEAST_LEVELS, repetitions=3))
    assert not reaches(few, Design(alike=LEAST_LEVELS, flights=1, repetitions=3))


def test_what_never_varies_is_always_detected() -> None:
    assert power(Spread({(2,): 0.0}, Design(alike=1, flights=1, repetitions=3))) == 1


def test_managing_systems_that_were_measured_say_how_every_factor_varies() -> None:
    for found in VARIANCES.values():
        assert reaches(found, Design(alike=9, flights=8, repetitions=3))
        assert {place for factors in found.parts for place in factors} == {0, 1, 2}


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("alike", [3, 5, 9])
def test_intervals_hold_in_simulated_campaigns_and_nearly_the_power_is_kept(model: str, alike: int) -> None:
    found = measure(MODELS[model], Design(alike=alike, flights=4, repetitions=3), campaigns=2000)
    # 93 to 97 %, and what 2000 campaigns are off by chance
    assert 0.915 < found.difference < 0.98
    assert 0.915 < found.score < 0.98
    assert 0.65 < found.power < 0.9
