import pytest
from hypothesis import given
from hypothesis import strategies as st

from sunset_ros.duration import Duration
from sunset_ros.interfaces.builtin_interfaces.msg import Duration as DurationMessage
from sunset_ros.interfaces.builtin_interfaces.msg import Time as TimeMessage
from sunset_ros.time import ClockType, Time

nanoseconds = st.integers(0, 2**62)


@given(nanoseconds)
def test_a_time_survives_its_message(value: int) -> None:
    time = Time(nanoseconds=value, clock_type=ClockType.ROS_TIME)
    assert Time.from_msg(time.to_msg()) == time
    seconds, rest = time.seconds_nanoseconds()
    assert seconds * 10**9 + rest == value


@given(st.integers(-(2**61), 2**61))
def test_a_duration_survives_its_message(value: int) -> None:
    duration = Duration(nanoseconds=value)
    assert Duration.from_msg(duration.to_msg()) == duration


@given(nanoseconds, nanoseconds)
def test_times_and_durations_add_up(first: int, second: int) -> None:
    start, end = Time(nanoseconds=first), Time(nanoseconds=first + second)
    assert end - start == Duration(nanoseconds=second)
    assert start + Duration(nanoseconds=second) == end
    assert end - Duration(nanoseconds=second) == start
    assert (start < end) is (second > 0)
    assert (Duration(nanoseconds=first) < Duration(nanoseconds=second)) is (first < second)


def test_messages_are_as_ros_writes_them() -> None:
    assert Time(seconds=1.5).to_msg() == TimeMessage(sec=1, nanosec=500_000_000)
    assert Duration(seconds=-0.5).to_msg() == DurationMessage(sec=-1, nanosec=500_000_000)


def test_times_of_different_clocks_do_not_mix() -> None:
    ros, system = Time(clock_type=ClockType.ROS_TIME), Time(clock_type=ClockType.SYSTEM_TIME)
    for mix in (lambda: ros == system, lambda: ros < system, lambda: ros - system):
        with pytest.raises(
            TypeError, match="Times of different clocks cannot be compared: ROS_TIME, SYSTEM_TIME"
        ):
            mix()


def test_a_time_is_not_negative() -> None:
    with pytest.raises(ValueError, match="at least 0 ns, got -1"):
        Time(nanoseconds=-1)
    with pytest.raises(ValueError, match="at least 0 ns"):
        _ = Time(seconds=1) - Duration(seconds=2)


def test_other_things_are_neither_times_nor_durations() -> None:
    assert Time() != 0
    assert Duration() != 0  # type: ignore[comparison-overlap]
    with pytest.raises(TypeError):
        _ = Time() + 1  # type: ignore[operator]
    with pytest.raises(TypeError):
        _ = Time() - 1  # type: ignore[operator]


def test_equal_times_have_equal_hashes() -> None:
    assert len({Time(seconds=1), Time(nanoseconds=10**9)}) == 1
    assert len({Duration(seconds=1), Duration(nanoseconds=10**9)}) == 1


def test_they_show_what_they_are() -> None:
    assert repr(Time(seconds=1)) == "Time(nanoseconds=1000000000, clock_type=SYSTEM_TIME)"
    assert repr(Duration(seconds=1)) == "Duration(nanoseconds=1000000000)"
