import math
import statistics
from itertools import product

import pytest

from sunset.evaluation.differences import difference
from sunset.evaluation.intervals import Cluster, Estimate, estimate, estimate_ratio


def seeds(count: int, alike: str = "a") -> list[Cluster]:
    return [Cluster(alike, "flight", seed) for seed in range(count)]


def test_runs_of_one_scenario_have_the_ordinary_interval() -> None:
    values = [2.0, 4.0, 9.0]
    found = estimate(values, seeds(3))
    assert found is not None
    assert found.mean == 5.0
    assert found.std == pytest.approx(math.sqrt(13))  # (9 + 1 + 16) / 2
    half = 4.303 * math.sqrt(13 / 3)
    assert (found.low, found.high) == pytest.approx((5 - half, 5 + half), abs=1e-3)


def test_repetitions_that_agree_do_not_make_the_mean_surer() -> None:
    means = [1.0, 5.0, 6.0]
    clusters = [Cluster(alike, "flight", seed) for alike, seed in product("abc", range(6))]
    found = estimate([mean for mean in means for _ in range(6)], clusters)
    assert found is not None
    half = 4.303 * statistics.stdev(means) / math.sqrt(3)
    assert (found.low, found.high) == pytest.approx((4 - half, 4 + half), abs=1e-2)
    assert found.std == pytest.approx(statistics.stdev(means * 6))


def test_a_run_without_the_figure_is_left_out_and_the_number_says_so() -> None:
    found = estimate([1.0, None, 3.0, 7.0], seeds(4))
    assert found == estimate([1.0, 3.0, 7.0], [seeds(4)[place] for place in (0, 2, 3)])
    assert found is not None
    assert found.runs == 3


def test_a_single_run_has_no_deviation_and_no_interval() -> None:
    found = estimate([1.5], seeds(1))
    assert found == Estimate(1.5, None, None, None, 1)
    assert not found.lacks_interval


@pytest.mark.parametrize("alike", ["a", "abc", "abcdefghi"])
def test_fewer_than_three_seeds_have_a_deviation_but_no_interval(alike: str) -> None:
    clusters = [cluster for name in alike for cluster in seeds(2, name)]
    values = [float(place**2) for place in range(len(clusters))]
    found = estimate(values, clusters)
    assert found is not None
    assert found.std == pytest.approx(statistics.stdev(values))
    assert (found.low, found.high, found.spread) == (None, None, None)
    assert found.lacks_interval


def test_no_value_at_all_is_not_applicable() -> None:
    assert estimate([None, None], seeds(2)) is None
    assert estimate([], []) is None


def test_equal_values_have_an_interval_of_no_width() -> None:
    found = estimate([0.1] * 7, seeds(7))
    assert found is not None
    assert (found.std, found.low, found.high) == pytest.approx((0.0, 0.1, 0.1))


def test_lengths_that_differ_are_refused() -> None:
    with pytest.raises(ValueError, match="argument"):
        estimate([1.0], [])


def test_a_ratio_is_one_of_means_so_that_small_runs_weigh_little() -> None:
    found = estimate_ratio([0.3, 0.0, 0.3], [0.3, 0.02, 0.4], seeds(3))
    assert found
    assert found.mean == pytest.approx(0.6 / 0.72)
    assert (found.std, found.runs) == (None, 3)


def test_pairs_of_which_one_lacks_the_figure_are_counted() -> None:
    rows = [(seeds(3)[0], 3.0, 1.0), (seeds(3)[1], None, 1.0), (seeds(3)[2], None, None)]
    found = difference("iou", rows)
    assert (found.first, found.second, found.pairs, found.one_sided) == (3.0, 1.0, 1, 1)
    assert found.difference == Estimate(2.0, None, None, None, 1)
