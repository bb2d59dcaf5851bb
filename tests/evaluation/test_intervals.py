from itertools import product

import numpy as np
import numpy.typing as npt
import pytest

from sunset.evaluation.intervals import Cluster, Design, Spread, spread
from sunset_ros.seeding import generator


def crossed(sizes: tuple[int, int, int]) -> list[Cluster]:
    return [Cluster(*levels) for levels in product(*map(range, sizes))]


def found(values: npt.NDArray[np.float64], clusters: list[Cluster] | None = None) -> Spread:
    """Return the spread of the mean of values by (degradations, flight, seed)."""
    clusters = clusters or crossed(values.shape)
    one = spread(values.ravel().tolist(), [1.0] * values.size, clusters)
    assert one is not None
    return one


def textbook(values: npt.NDArray[np.float64]) -> tuple[dict[int, float], float]:
    """Return the mean squares of factors and of the rest in an analysis of variance, over the number of values."""
    mean, places = values.mean(), range(values.ndim)
    effects = {
        place: values.mean(tuple(other for other in places if other != place), keepdims=True) - mean
        for place in places
    }
    squares = {
        place: float((np.broadcast_to(effect, values.shape) ** 2).sum()) / (values.shape[place] - 1)
        for place, effect in effects.items()
    }
    residual = values - mean - sum(effects.values())
    left = values.size - 1 - sum(size - 1 for size in values.shape)
    rest = float((residual**2).sum()) / left
    return {place: square / values.size for place, square in squares.items()}, rest / values.size


def test_the_variance_is_the_sum_of_the_components_of_an_analysis_of_variance() -> None:
    random = generator(1, "test")
    noise = random.standard_normal((9, 5, 3))
    values = noise + 3 * random.standard_normal((9, 1, 1)) + 2 * random.standard_normal((1, 5, 1))
    squares, rest = textbook(values)
    variance = rest + sum(max(0.0, square - rest) for square in squares.values())
    assert found(values).error == pytest.approx(np.sqrt(variance))


def test_the_degrees_of_freedom_are_those_of_the_sum_of_mean_squares() -> None:
    random = generator(12, "test")
    values = 0.1 * random.standard_normal((5, 4, 3)) + random.standard_normal((5, 1, 1))
    values = values + random.standard_normal((1, 4, 1)) + random.standard_normal((1, 1, 3))
    squares, _ = textbook(values)
    expected = sum(squares.values()) ** 2 / (squares[0] ** 2 / 4 + squares[1] ** 2 / 3 + squares[2] ** 2 / 2)
    assert found(values).degrees == pytest.approx(expected)


def test_three_degradations_and_seeds_have_the_interval_that_is_computed_by_hand() -> None:
    # effects of degradations −1, 0, 1 and of seeds −2, 0, 2: of nine values the mean squares are 3 and 12, and no rest
    one = found(np.add.outer([-1.0, 0.0, 1.0], [-2.0, 0.0, 2.0])[:, np.newaxis, :])
    assert one.error == pytest.approx(np.sqrt(1 / 3 + 4 / 3))
    assert one.degrees == pytest.approx((1 + 4) ** 2 / (1 / 2 + 16 / 2))


def test_of_one_factor_the_interval_is_students() -> None:
    values = np.array([1.1, 3.2, 8.1]).reshape(1, 1, 3)
    # 4.303 is the t of two degrees of freedom
    assert found(values).half_width == pytest.approx(4.303 * np.std(values, ddof=1) / np.sqrt(3), rel=1e-3)


def test_runs_that_always_come_together_count_once() -> None:
    values = generator(2, "test").standard_normal((9, 1, 3))
    twins = [cluster for cluster in crossed((9, 1, 3)) for _ in range(6)]
    repeated = found(values.repeat(6), twins)
    assert repeated.half_width == pytest.approx(found(values).half_width)


def test_seeds_that_differ_widen_the_interval() -> None:
    values = generator(3, "test").standard_normal((9, 1, 3))
    apart = values + np.array([-2.0, 0.0, 2.0])
    # between the t of two degrees of freedom and the normal quantile
    assert 1.96 * 2 / np.sqrt(3) < found(apart).half_width < 1.1 * 4.303 * 2 / np.sqrt(3)
    assert found(values).half_width < 1.2


def test_few_degradations_or_flights_are_held_as_they_are() -> None:
    values = generator(4, "test").standard_normal((2, 2, 4)) + np.arange(2).reshape(2, 1, 1) * 100
    spread_of_seeds = found(values)
    assert set(spread_of_seeds.parts) == {(2,)}
    seeds = values.mean((0, 1))
    # 3.182 is the t of three degrees of freedom
    assert spread_of_seeds.half_width == pytest.approx(3.182 * np.std(seeds, ddof=1) / 2, rel=1e-3)


@pytest.mark.parametrize("seeds", [1, 2])
def test_fewer_than_three_seeds_have_no_spread(seeds: int) -> None:
    assert spread([1.0] * 9 * seeds, [1.0] * 9 * seeds, crossed((9, 1, seeds))) is None


def test_a_seed_that_was_hardly_run_does_not_count() -> None:
    clusters = crossed((9, 1, 3))
    values = [float(place) for place in range(len(clusters))]

    def spread_with(last: int) -> Spread | None:
        kept = [place for place, one in enumerate(clusters) if one.seed != 2 or one.alike in range(last)]
        return spread(
            [values[place] for place in kept], [1.0] * len(kept), [clusters[place] for place in kept]
        )

    assert spread_with(4) is None
    assert spread_with(5) is not None


def test_no_run_has_no_spread() -> None:
    assert spread([], [], []) is None


def test_the_order_of_runs_changes_nothing() -> None:
    values = generator(5, "test").standard_normal((4, 3, 3))
    order = generator(5, "order").permutation(values.size)
    clusters = crossed((4, 3, 3))
    shuffled = spread(values.ravel()[order].tolist(), [1.0] * 36, [clusters[place] for place in order])
    assert shuffled is not None
    assert shuffled.half_width == pytest.approx(found(values).half_width, rel=1e-12)


def test_a_flight_of_its_own_for_each_scenario_does_not_make_the_mean_surer() -> None:
    scenarios = generator(6, "test").standard_normal((40, 1))
    values = (scenarios + 0.01 * generator(6, "noise").standard_normal((40, 3))).ravel()
    nested = [Cluster(scenario, scenario, seed) for scenario in range(40) for seed in range(3)]
    # 2.023 is the t of 39 degrees of freedom
    expected = 2.023 * np.std(scenarios, ddof=1) / np.sqrt(40)
    assert found(values, nested).half_width == pytest.approx(expected, rel=0.01)


def test_a_ratio_of_proportional_sums_is_certain() -> None:
    tops = generator(7, "test").uniform(1, 2, 27).tolist()
    one = spread(tops, [2 * top for top in tops], crossed((9, 1, 3)))
    assert one is not None
    assert one.half_width == pytest.approx(0, abs=1e-12)


def test_a_ratio_is_as_sure_as_the_delta_method_says() -> None:
    random = generator(8, "test")
    gains = random.uniform(0.2, 0.4, (9, 1, 3))
    wins = 0.7 * gains + 0.02 * random.standard_normal((9, 1, 1)) + 0.005 * random.standard_normal((9, 1, 3))
    ratio = wins.sum() / gains.sum()
    one = spread(wins.ravel().tolist(), gains.ravel().tolist(), crossed((9, 1, 3)))
    assert one is not None
    linear = found((wins - ratio * gains) / gains.mean())
    assert one.half_width == pytest.approx(linear.half_width)


def test_no_difference_at_all_is_not_significant() -> None:
    one = found(np.zeros((9, 1, 3)))
    assert one.p_value(0.0) == 1.0
    assert one.p_value(0.01) < 0.001


def test_p_is_five_percent_where_the_interval_ends_at_nothing() -> None:
    one = found(generator(9, "test").standard_normal((9, 1, 3)))
    assert one.p_value(one.half_width) == pytest.approx(0.05)
    assert one.p_value(-one.half_width) == one.p_value(one.half_width)
    assert one.p_value(0.0) == 1.0
    assert one.p_value(2 * one.half_width) < 0.01 < one.p_value(1.2 * one.half_width) < 0.05
    assert one.p_value(1e9) == pytest.approx(1e-6)


def test_what_does_not_vary_is_certain() -> None:
    one = found(np.ones((9, 1, 3)))
    assert one.half_width == 0
    assert one.p_value(0.1) == pytest.approx(1e-6)


def test_flights_that_have_degradations_of_their_own_cluster_for_both() -> None:
    flights = generator(10, "test").standard_normal((5, 1, 1))
    values = (flights + 0.001 * generator(10, "noise").standard_normal((5, 4, 3))).ravel()
    nested = [
        Cluster((flight, one), flight, seed) for flight, one, seed in product(range(5), range(4), range(3))
    ]
    # 2.776 is the t of four degrees of freedom
    expected = 2.776 * np.std(flights, ddof=1) / np.sqrt(5)
    assert found(values, nested).half_width == pytest.approx(expected, rel=0.01)


def test_a_campaign_with_gaps_has_an_interval_like_the_whole_ones() -> None:
    random = generator(11, "test")
    values = random.standard_normal((9, 4, 3)) + random.standard_normal((9, 1, 1))
    clusters, kept = crossed((9, 4, 3)), random.permutation(108)[:100]
    left = spread(values.ravel()[kept].tolist(), [1.0] * 100, [clusters[place] for place in kept])
    assert left is not None
    assert left.half_width == pytest.approx(found(values).half_width, rel=0.15)


def test_what_does_not_vary_with_the_seed_stays_with_more_repetitions() -> None:
    sizes = Design(alike=9, flights=1, repetitions=3)
    one = Spread({(0,): 0.09, (0, 2): 0.27}, sizes)
    assert one.error == pytest.approx(np.sqrt(0.01 + 0.01))
    assert Spread(one.parts, sizes._replace(repetitions=6)).error == pytest.approx(np.sqrt(0.01 + 0.005))


@pytest.mark.parametrize("apart", [0.5, 3.0])
def test_on_one_flight_all_but_the_degradations_lessens_with_more_repetitions(apart: float) -> None:
    noise = generator(5, "test").standard_normal((9, 3))
    values = noise + (apart - 1) * noise.mean(0) + 2 * generator(5, "degradations").standard_normal((9, 1))
    squares, rest = textbook(values)
    one = found(values[:, np.newaxis, :])
    assert (squares[1] < rest) == (apart < 1)
    for less in (1, 2, 10):
        more = Spread(one.parts, one.sizes._replace(repetitions=3 * less))
        of_degradations = squares[0] - rest
        variance = of_degradations + (rest + max(0.0, squares[1] - rest)) / less
        assert more.error == pytest.approx(np.sqrt(variance))
        known = of_degradations + rest / less, squares[1] / less
        expected = sum(known) ** 2 / (known[0] ** 2 / 8 + known[1] ** 2 / (3 * less - 1))
        assert more.degrees == pytest.approx(expected)
    assert all(Spread(one.parts, one.sizes._replace(alike=size)).degrees >= 2 for size in range(10, 100))


def test_what_varies_between_flights_is_part_of_the_truth_on_fewer_than_three() -> None:
    parts = {(1,): 0.12, (0, 1): 0.24}
    assert Spread(parts, Design(alike=12, flights=2, repetitions=3)).error == pytest.approx(0.1)
    assert Spread(parts, Design(alike=12, flights=3, repetitions=3)).error == pytest.approx(
        np.sqrt(0.04 + 0.02 / 3)
    )
