import math
import statistics

import pytest

from sunset.evaluation import Estimate, estimate
from sunset.evaluation.estimates import student_quantile


def apart(count: int) -> list[int]:
    return list(range(count))


# from printed tables of Student's t, two-sided 5 %
@pytest.mark.parametrize(
    ("degrees", "t"),
    [
        (1, 12.706),
        (2, 4.303),
        (3, 3.182),
        (4, 2.776),
        (5, 2.571),
        (9, 2.262),
        (26, 2.056),
        (53, 2.006),
        (100, 1.984),
        (161, 1.975),
        (1000, 1.962),
    ],
)
def test_quantiles_are_those_of_the_tables(degrees: int, t: float) -> None:
    assert student_quantile(degrees) == pytest.approx(t, abs=6e-4)


def test_no_degrees_of_freedom_are_refused() -> None:
    with pytest.raises(ValueError, match="at least 1 degree of freedom, got 0"):
        student_quantile(0)


def test_independent_runs_have_the_ordinary_interval() -> None:
    values = [2.0, 4.0, 9.0]
    found = estimate(values, apart(3))
    assert found is not None
    assert found.mean == 5.0
    assert found.std == pytest.approx(math.sqrt(13))  # (9 + 1 + 16) / 2
    half = 4.303 * math.sqrt(13 / 3)
    assert (found.low, found.high) == pytest.approx((5 - half, 5 + half), abs=1e-3)


def test_balanced_clusters_have_the_interval_of_their_means() -> None:
    values = [1.0, 1.2, 3.0, 3.4, 8.0, 8.2]
    found = estimate(values, ["a", "a", "b", "b", "c", "c"])
    means = [1.1, 3.2, 8.1]
    half = 4.303 * statistics.stdev(means) / math.sqrt(3)
    assert found is not None
    assert found.low == pytest.approx(statistics.mean(means) - half, abs=2e-3)
    assert found.high == pytest.approx(statistics.mean(means) + half, abs=2e-3)
    assert found.std == pytest.approx(statistics.stdev(values))


def test_repetitions_that_agree_do_not_make_the_mean_surer() -> None:
    once = estimate([1.0, 5.0, 6.0], ["a", "b", "c"])
    thrice = estimate([1.0, 5.0, 6.0] * 3, ["a", "b", "c"] * 3)
    assert once is not None
    assert thrice is not None
    assert (thrice.low, thrice.high) == pytest.approx((once.low, once.high))


def test_runs_of_the_only_scenario_are_their_own_clusters() -> None:
    assert estimate([1.0, 2.0, 4.0], ["a"] * 3) == estimate([1.0, 2.0, 4.0], apart(3))


def test_a_run_without_the_figure_is_left_out_and_the_number_says_so() -> None:
    found = estimate([1.0, None, 3.0], apart(3))
    assert found == estimate([1.0, 3.0], [0, 2])
    assert found is not None
    assert found.runs == 2


def test_a_single_run_has_no_deviation_and_no_interval() -> None:
    assert estimate([1.5], ["a"]) == Estimate(1.5, None, None, None, 1)


@pytest.mark.parametrize("clusters", [["a", "b"], ["a", "b", "b"], ["a", "a"]])
def test_fewer_than_three_clusters_have_a_deviation_but_no_interval(clusters: list[str]) -> None:
    values = [1.0, 2.0, 4.5][: len(clusters)]
    found = estimate(values, clusters)
    assert found is not None
    assert found.std == pytest.approx(statistics.stdev(values))
    assert (found.low, found.high) == (None, None)
    assert found.lacks_interval


def test_no_value_at_all_is_not_applicable() -> None:
    assert estimate([None, None], ["a", "b"]) is None
    assert estimate([], []) is None


def test_equal_values_have_an_interval_of_no_width() -> None:
    found = estimate([0.1] * 7, apart(7))
    assert found is not None
    assert (found.std, found.low, found.high) == pytest.approx((0.0, 0.1, 0.1))


def test_lengths_that_differ_are_refused() -> None:
    with pytest.raises(ValueError, match="argument"):
        estimate([1.0], [])
