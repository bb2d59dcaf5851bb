import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sunset.metrics import downtime


def down(times: npt.ArrayLike) -> float:
    return downtime(np.asarray(times, dtype=float), period_s=0.1, duration_s=20.0)


def steady(start: float, stop: float) -> npt.NDArray[np.float64]:
    """Return 10 Hz message times in [start, stop)."""
    return np.arange(round(start * 10), round(stop * 10)) / 10 + 0.05


def test_nominal_flight_has_none() -> None:
    assert down(steady(-3, 20)) == 0.0


def test_never_anything_is_the_whole_run() -> None:
    assert down([]) == 20.0


def test_permanent_outage_is_the_rest_of_the_run() -> None:
    assert down(steady(-3, 5)) == pytest.approx(20 - 4.95)


def test_outage_from_the_injection_on_counts_from_zero() -> None:
    assert down(steady(-3, 0)) == 20.0  # the last message, at -0.05, lies before


def test_outage_in_the_middle_counts_whole() -> None:
    assert down(np.concatenate([steady(-3, 5), steady(9, 20)])) == pytest.approx(9.05 - 4.95)


def test_outage_from_zero_to_a_repair() -> None:
    assert down(np.concatenate([steady(-3, 0), steady(6, 20)])) == pytest.approx(6.05)


def test_two_outages_add_up_and_one_reaches_the_end() -> None:
    times = np.concatenate([steady(-3, 1), steady(3, 15)])
    assert down(times) == pytest.approx((3.05 - 0.95) + (20 - 14.95))


@pytest.mark.parametrize(("second", "expected"), [(1.2, 0.0), (1.2001, 0.2001)])
def test_gap_of_two_periods_is_still_the_expected_rate(second: float, expected: float) -> None:
    times = np.concatenate([steady(-3, 1), [1.0, second], steady(1.2, 20)])
    assert down(times) == pytest.approx(expected)


@pytest.mark.parametrize("k", range(20))
def test_gap_of_two_periods_does_not_depend_on_rounding(k: int) -> None:
    times = np.concatenate([steady(-3, 0), np.arange(k % 2, 200, 2) * 0.1, [19.99]])
    assert down(times) == 0.0


def test_gap_across_zero_is_judged_whole_and_counted_from_zero() -> None:
    assert down([-0.15, 0.1, *steady(0.1, 20)]) == pytest.approx(0.1)  # 0.25 s long, 0.1 s of it within
    assert down([-0.05, 0.1, *steady(0.1, 20)]) == 0.0  # 0.15 s long


def test_first_message_late_with_no_warm_up() -> None:
    assert down(steady(2, 20)) == pytest.approx(2.05)


def test_messages_after_the_end_do_not_help() -> None:
    assert down(np.concatenate([steady(-3, 10), steady(20.1, 22)])) == pytest.approx(20 - 9.95)


def test_one_message_in_the_run_leaves_it_all_down() -> None:
    assert down([10.0]) == pytest.approx(20.0)


@given(st.lists(st.floats(-3, 22), max_size=40))
@settings(max_examples=100)
def test_is_within_the_run_and_more_messages_never_make_it_longer(times: list[float]) -> None:
    ordered = sorted(times)
    assert 0 <= down(ordered[1:]) <= 20
    if ordered[:1] and ordered[0] >= 0:
        assert down(ordered) <= down(ordered[1:]) + 1e-9
