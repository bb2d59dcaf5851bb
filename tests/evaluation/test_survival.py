"""Kaplan and Meier's estimate, against published figures and another way to compute it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sunset.evaluation.survival import kaplan_meier

# Weeks of remission with 6-mercaptopurine (Freireich et al., Blood 21, 1963), where 0 is not censored: the example of
# Cox and Oakes, Analysis of Survival Data, 1984, table 1.1, with the estimate that is given there.
WEEKS = [6, 6, 6, 6, 7, 9, 10, 10, 11, 13, 16, 17, 19, 20, 22, 23, 25, 32, 32, 34, 35]
CENSORED = [0, 0, 0, 1, 0, 1, 0, 1, 1, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1]
PUBLISHED = {6: 0.857, 7: 0.807, 10: 0.753, 13: 0.690, 16: 0.627, 22: 0.538, 23: 0.448}


def test_it_is_what_is_published_of_a_well_known_study() -> None:
    found = kaplan_meier([float(week) for week in WEEKS], [not censored for censored in CENSORED])
    assert dict(zip(found.times.tolist(), found.shares.round(3).tolist(), strict=True)) == PUBLISHED
    assert (found.number, found.events) == (21, 9)


def test_the_restricted_mean_is_the_area_under_the_curve() -> None:
    found = kaplan_meier([float(week) for week in WEEKS], [not censored for censored in CENSORED])
    # 6 + 0.857 · 1 + 0.807 · 3 + 0.753 · 3 + 0.690 · 3 + 0.627 · 6 + 0.538 · 1 + 0.448 · 12
    assert found.restricted_mean(35.0) == pytest.approx(23.29, abs=0.01)
    assert found.restricted_mean(6.0) == 6.0
    assert found.restricted_mean(8.0) == pytest.approx(6 + 0.857 + 0.807, abs=1e-3)


def test_where_nothing_is_censored_it_is_the_mean() -> None:
    times = [0.0, 0.5, 0.5, 3.0, 8.0]
    assert kaplan_meier(times, [True] * 5).restricted_mean(20.0) == pytest.approx(np.mean(times))
    assert kaplan_meier(times, [True] * 5).restricted_mean(4.0) == pytest.approx(
        np.mean(np.minimum(times, 4))
    )


def test_where_nothing_happened_the_mean_is_the_horizon() -> None:
    for times in ([], [1.0, 2.0]):
        found = kaplan_meier(times, [False] * len(times))
        assert (found.times.tolist(), found.restricted_mean(20.0)) == ([], 20.0)


_OBSERVED = st.lists(st.tuples(st.integers(0, 12), st.booleans()), min_size=1, max_size=30)


def redistributed(observed: list[tuple[int, bool]], time: int) -> float:
    """Return the share without an event after a time: Efron's way, in which what is censored hands on its weight."""
    weights = [1.0] * len(observed)
    order = sorted(range(len(observed)), key=lambda place: (observed[place][0], not observed[place][1]))
    for rank, place in enumerate(order):
        rest = order[rank + 1 :]
        if not observed[place][1] and rest:
            for other in rest:
                weights[other] += weights[place] / len(rest)
            weights[place] = 0.0
    lost = [weights[place] for place, (when, happened) in enumerate(observed) if happened and when <= time]
    return 1.0 - sum(lost) / len(observed)


@given(_OBSERVED)
def test_it_is_what_redistribution_to_the_right_gives(observed: list[tuple[int, bool]]) -> None:
    found = kaplan_meier([float(time) for time, _ in observed], [happened for _, happened in observed])
    for time, share in zip(found.times, found.shares, strict=True):
        assert share == pytest.approx(redistributed(observed, int(time)), abs=1e-9)
