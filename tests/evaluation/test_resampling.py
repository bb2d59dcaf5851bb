from collections.abc import Iterator
from itertools import combinations, product

import numpy as np
import numpy.typing as npt
import pytest

from sunset.evaluation.resampling import Cluster, Spread, spread
from sunset.seeding import generator


def crossed(sizes: tuple[int, int, int]) -> list[Cluster]:
    return [Cluster(*levels) for levels in product(*map(range, sizes))]


def found(values: npt.NDArray[np.float64], clusters: list[Cluster] | None = None) -> Spread:
    """Return the spread of the mean of values by (degradations, flight, seed)."""
    clusters = clusters or crossed(values.shape)
    one = spread(values.ravel().tolist(), [1.0] * values.size, clusters)
    assert one is not None
    return one


def mean_squares(values: npt.NDArray[np.float64]) -> Iterator[tuple[tuple[int, ...], float, int]]:
    """Give the mean squares of an analysis of variance, over the number of values, from its textbook."""
    places = range(values.ndim)
    for size in range(1, values.ndim + 1):
        for factors in combinations(places, size):
            effect = np.zeros((1,) * values.ndim)
            for less in range(size + 1):
                for inner in combinations(factors, less):
                    others = tuple(place for place in places if place not in inner)
                    effect = effect + (-1) ** (size - less) * values.mean(others, keepdims=True)
            degrees = int(np.prod([values.shape[place] - 1 for place in factors]))
            squares = float((np.broadcast_to(effect, values.shape) ** 2).sum())
            yield factors, squares / degrees / values.size, degrees


def test_components_are_those_of_an_analysis_of_variance() -> None:
    random = generator(1, "test")
    noise = random.standard_normal((9, 5, 3))
    values = noise + 3 * random.standard_normal((9, 1, 1)) + 2 * random.standard_normal((1, 5, 1))
    squares = {factors: square for factors, square, _ in mean_squares(values)}
    for part in found(values).components:
        above = [
            (-1) ** (len(more) - len(part.factors)) * square
            for more, square in squares.items()
            if set(part.factors) <= set(more)
        ]
        assert part.variance == pytest.approx(max(0.0, sum(above)), abs=0.01)


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
    assert found(apart).half_width > 4.303 * 2 / np.sqrt(3)
    assert found(values).half_width < 1.2


def test_few_degradations_or_flights_are_held_as_they_are() -> None:
    values = generator(4, "test").standard_normal((2, 2, 4)) + np.arange(2).reshape(2, 1, 1) * 100
    spread_of_seeds = found(values)
    assert {part.factors for part in spread_of_seeds.components} == {(2,)}
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
    assert found(values, nested).half_width == pytest.approx(expected, rel=0.1)


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
    assert one.half_width == pytest.approx(linear.half_width, rel=0.05)


def test_no_difference_at_all_is_not_significant() -> None:
    one = found(np.zeros((9, 1, 3)))
    assert one.p_value(0.0) == 1.0
    assert one.p_value(0.01) < 0.001


def test_p_is_five_percent_where_the_interval_ends_at_nothing() -> None:
    one = found(generator(9, "test").standard_normal((9, 1, 3)))
    assert one.p_value(one.half_width) == pytest.approx(0.05, rel=0.02)
    assert one.p_value(-one.half_width) == one.p_value(one.half_width)
    assert one.p_value(0.0) == 1.0
    assert one.p_value(2 * one.half_width) < 0.01 < one.p_value(1.2 * one.half_width) < 0.05
    assert one.p_value(1e9) == pytest.approx(1e-6)


def test_what_does_not_vary_is_certain() -> None:
    one = found(np.ones((9, 1, 3)))
    assert one.half_width == 0
    assert one.p_value(0.1) == pytest.approx(1e-6)


def test_the_width_is_that_of_the_textbooks_quantiles() -> None:
    t = pytest.importorskip("scipy.stats").t
    random = generator(10, "test")
    values = random.standard_normal((9, 5, 3)) + 2 * random.standard_normal((9, 1, 1))
    values += random.standard_normal((1, 5, 1)) + random.standard_normal((1, 1, 3))
    squares = {factors: (square, degrees) for factors, square, degrees in mean_squares(values)}
    parts = [
        (
            max(
                0.0,
                sum(
                    (-1) ** (len(more) - len(factors)) * square
                    for more, (square, _) in squares.items()
                    if set(factors) <= set(more)
                ),
            ),
            degrees,
        )
        for factors, (_, degrees) in squares.items()
    ]
    total = sum(part for part, _ in parts)
    joint = total**2 / sum(part**2 / degrees for part, degrees in parts)
    banerjee = sum(part * t.ppf(0.975, degrees) ** 2 for part, degrees in parts)
    expected = np.sqrt((banerjee + total * t.ppf(0.975, joint) ** 2) / 2)
    assert found(values).half_width == pytest.approx(expected, rel=0.02)


def test_a_bootstrap_that_draws_run_by_run_finds_the_same_width() -> None:
    random = generator(11, "test")
    gains = random.uniform(0.3, 0.4, 6)
    wins = 0.7 * gains + 0.02 * random.standard_normal(6)
    ratios = []
    for _ in range(4000):
        drawn = [int(random.integers(6)) for _ in range(6)]
        ratios.append(sum(wins[seed] for seed in drawn) / sum(gains[seed] for seed in drawn))
    one = spread(wins.tolist(), gains.tolist(), crossed((1, 1, 6)))
    assert one is not None
    # 2.571 is the t of five degrees of freedom
    assert one.half_width == pytest.approx(2.571 * np.std(ratios) * np.sqrt(6 / 5), rel=0.05)
