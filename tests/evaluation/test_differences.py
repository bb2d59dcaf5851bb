from itertools import combinations

import numpy as np
import pytest

from sunset.evaluation.differences import Experiment, differences, holm
from sunset.evaluation.intervals import Cluster
from sunset_ros.seeding import generator


def rejected(p_values: list[float], level: float) -> set[int]:
    """Return which hypotheses Holm's procedure rejects, step by step as in his article."""
    left = sorted(range(len(p_values)), key=lambda place: p_values[place])
    gone: set[int] = set()
    while left and p_values[left[0]] <= level / len(left):
        gone.add(left.pop(0))
    return gone


def test_holm_gives_the_level_from_which_on_a_hypothesis_is_rejected() -> None:
    random = generator(1, "test")
    for _ in range(50):
        p_values = random.uniform(0, 0.2, 6).tolist()
        for place, level in enumerate(holm(p_values)):
            assert place in rejected(p_values, level * 1.000001) or level == 1
            assert place not in rejected(p_values, level * 0.999999)


def test_holm_of_nothing_and_of_one_changes_nothing() -> None:
    assert holm([]) == []
    assert holm([0.3]) == [0.3]


def test_pairs_are_won_by_whoever_has_more_and_ties_count_half() -> None:
    for leads, won in (([0.25, 0.5, -1.0], 2 / 3), ([0.0, 0.0, 0.1, -0.1], 0.5)):
        clusters: dict[Experiment, Cluster] = {
            (place,): Cluster("a", "flight", place) for place in range(len(leads))
        }
        first = dict(zip(clusters, leads, strict=True))
        (one,) = differences({"a": first, "b": dict.fromkeys(clusters, 0.0)}, {}, clusters, [("a", "b")])
        assert one.pairs_won == pytest.approx(won)


def test_differences_are_of_the_runs_that_both_have() -> None:
    clusters: dict[Experiment, Cluster] = {
        (a, s): Cluster(a, "flight", s) for a in range(9) for s in range(3)
    }
    keys: list[tuple[object, ...]] = list(clusters)
    noise = 0.01 * generator(4, "test").standard_normal(len(keys))
    worse = dict(zip(keys, noise.tolist(), strict=True))
    better = {key: 0.1 + 2 * value for key, value in worse.items()}
    extra = {**better, ("alone", 1): 9.0}
    gains = dict.fromkeys(keys, 0.5)
    (one,) = differences({"better": extra, "worse": worse}, gains, clusters, [("better", "worse")])
    assert (one.first, one.second, one.pairs) == ("better", "worse", 27)
    assert one.utility is not None
    assert one.score is not None
    assert one.utility.mean == pytest.approx(0.1 + noise.mean())
    assert one.score.mean == pytest.approx(2 * one.utility.mean)
    assert one.pairs_won == 1
    assert one.p_holm is not None
    assert one.p_holm < 0.001
    assert one.detectable is not None
    assert 0 < one.detectable < 0.02
    assert one.runs_needed == 27
    assert one.to_json()["p_holm"] == one.p_holm


def test_p_values_are_adjusted_over_all_pairs() -> None:
    clusters: dict[Experiment, Cluster] = {
        (a, s): Cluster(a, "flight", s) for a in range(9) for s in range(3)
    }
    random = generator(5, "test")
    systems = {
        name: dict(zip(clusters, random.normal(mean, 0.1, len(clusters)).tolist(), strict=True))
        for name, mean in (("a", 0.05), ("b", 0.03), ("c", 0.0))
    }
    found = differences(systems, {}, clusters, combinations(systems, 2))
    raw = [
        one.utility.spread.p_value(one.utility.mean) for one in found if one.utility and one.utility.spread
    ]
    assert [one.p_holm for one in found] == holm(raw)
    assert np.all([one.score is None for one in found])


def test_two_seeds_have_a_mean_but_no_p_and_no_number_of_runs() -> None:
    clusters: dict[Experiment, Cluster] = {
        (a, s): Cluster(a, "flight", s) for a in range(9) for s in range(2)
    }
    first, second = dict.fromkeys(clusters, 0.4), dict.fromkeys(clusters, 0.3)
    (one,) = differences({"first": first, "second": second}, {}, clusters, [("first", "second")])
    assert one.utility is not None
    assert one.utility.low is None
    assert (one.p_holm, one.detectable, one.runs_needed) == (None, None, None)


def test_systems_without_a_common_run_have_no_difference() -> None:
    clusters: dict[Experiment, Cluster] = {(place, 1): Cluster(place, "flight", 1) for place in range(2)}
    systems: dict[str, dict[Experiment, float]] = {"first": {(0, 1): 0.4}, "second": {(1, 1): 0.3}}
    (one,) = differences(systems, {}, clusters, [("first", "second")])
    assert (one.pairs, one.utility, one.pairs_won, one.p_holm) == (0, None, None, None)
