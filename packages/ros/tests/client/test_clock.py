from typing import TYPE_CHECKING

import pytest

from sunset_ros import Node, Parameter
from sunset_ros.clock import Clock, ROSClock
from sunset_ros.interfaces.builtin_interfaces.msg import Time as TimeMessage
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock as ClockMessage
from sunset_ros.publisher import Publisher
from sunset_ros.time import ClockType, Time

if TYPE_CHECKING:
    from .conftest import World


def follower(world: "World") -> tuple[Node, Publisher[ClockMessage], list[float]]:
    publisher = world.node("player").create_publisher(ClockMessage, "/clock", 10)
    node = world.node("follower", ["--ros-args", "-p", "use_sim_time:=true"])
    calls: list[float] = []
    node.create_timer(1.0, lambda: calls.append(node.get_clock().now().nanoseconds / 1e9))
    return node, publisher, calls


def set_time(world: "World", publisher: Publisher[ClockMessage], *seconds: float) -> None:
    for each in seconds:
        publisher.publish(ClockMessage(clock=Time(seconds=each).to_msg()))
        world.pass_time(0.01)


def test_time_starts_at_zero_and_goes_where_the_topic_says(world: "World") -> None:
    node, publisher, calls = follower(world)
    world.pass_time(5.0)
    assert node.get_clock().now().nanoseconds == 0
    set_time(world, publisher, 0.5, 1.0, 1.5, 2.75, 3.5)
    assert node.get_clock().now() == Time(seconds=3.5, clock_type=ClockType.ROS_TIME)
    assert calls == [1.5, 2.75, 3.5]


@pytest.mark.parametrize("first", [0.3, 100.0])
def test_timers_begin_to_count_when_the_time_is_known(world: "World", first: float) -> None:
    _, publisher, calls = follower(world)
    set_time(world, publisher, 0.0, first, first + 0.9, first + 1.0, first + 2.0)
    assert calls == [first + 1.0, first + 2.0]


def test_a_timer_that_is_reset_before_the_time_is_known_counts_from_then(world: "World") -> None:
    node, publisher, calls = follower(world)
    (timer,) = node.timers
    timer.reset()
    assert (timer.is_ready(), timer.time_until_next_call()) == (False, 1_000_000_000)
    set_time(world, publisher, 100.0, 100.9, 101.0)
    assert calls == [101.0]


def test_after_a_jump_forward_a_timer_calls_once_and_keeps_its_times(world: "World") -> None:
    _, publisher, calls = follower(world)
    set_time(world, publisher, 10.0, 17.25, 17.75, 18.0)
    assert calls == [17.25, 18.0]


def test_a_timer_of_no_period_needs_no_time(world: "World") -> None:
    node, _, _ = follower(world)
    called: list[int] = []

    def call() -> None:
        called.append(1)
        timer.cancel()

    timer = node.create_timer(0.0, call)
    world.pass_time(0.1)
    assert called == [1]


def test_a_timer_that_is_reset_just_before_its_call_waits_anew(world: "World") -> None:
    publisher = world.node("player").create_publisher(ClockMessage, "/clock", 10)
    node = world.node("follower", ["--ros-args", "-p", "use_sim_time:=true"])
    calls: list[float] = []

    def call() -> None:
        second.reset()

    first = node.create_timer(1.0, call)
    second = node.create_timer(1.0, lambda: calls.append(node.get_clock().now().nanoseconds / 1e9))
    set_time(world, publisher, 0.5, 1.5)
    first.cancel()
    set_time(world, publisher, 2.0, 2.5)
    assert calls == [2.5]


def test_a_timer_may_use_another_clock_than_its_nodes(world: "World") -> None:
    node, _, _ = follower(world)
    calls: list[int] = []
    steady = Clock(clock_type=ClockType.STEADY_TIME, context=node.context)
    node.create_timer(0.1, lambda: calls.append(world.simulation.now), clock=steady)
    world.pass_time(0.25)
    assert len(calls) == 2


def test_when_time_goes_back_timers_start_again(world: "World") -> None:
    _, publisher, calls = follower(world)
    set_time(world, publisher, 10.0, 11.0, 2.0, 2.5, 3.0)
    assert calls == [11.0, 3.0]


def test_timers_can_be_canceled_and_reset_in_ros_time(world: "World") -> None:
    node, publisher, calls = follower(world)
    (timer,) = node.timers
    timer.cancel()
    set_time(world, publisher, 1.0, 2.0)
    assert (calls, timer.is_ready(), timer.is_canceled()) == ([], False, True)
    timer.reset()
    assert timer.time_until_next_call() == 1_000_000_000
    set_time(world, publisher, 2.9, 3.0)
    assert calls == [3.0]
    node.destroy_timer(timer)
    set_time(world, publisher, 4.0, 5.0)
    assert calls == [3.0]


def test_when_time_goes_back_within_its_period_a_timer_keeps_its_time(world: "World") -> None:
    _, publisher, calls = follower(world)
    set_time(world, publisher, 10.0, 10.8, 10.2, 11.0)
    assert calls == [11.0]


def test_when_time_goes_back_to_nothing_timers_wait_until_it_is_known_again(world: "World") -> None:
    _, publisher, calls = follower(world)
    set_time(world, publisher, 10.0, 10.5, 0.0, 50.0, 50.5, 51.0)
    assert calls == [51.0]


def test_a_shorter_period_holds_from_the_next_call_on(world: "World") -> None:
    node, publisher, calls = follower(world)
    set_time(world, publisher, 10.0)
    (timer,) = node.timers
    timer.timer_period_ns = 100_000_000
    set_time(world, publisher, 10.05, 10.2, 11.0, 11.1)
    assert calls == [11.0, 11.1]


def test_the_parameter_switches_between_clocks(world: "World") -> None:
    node, publisher, calls = follower(world)
    clock = node.get_clock()
    assert isinstance(clock, ROSClock)
    set_time(world, publisher, 100.0)
    node.set_parameters([Parameter("use_sim_time", value=False)])
    assert not clock.ros_time_is_active
    assert publisher.get_subscription_count() == 0
    calls.clear()
    world.pass_time(1.005)
    assert len(calls) == 1
    node.set_parameters([Parameter("use_sim_time", value=True)])
    assert clock.now().nanoseconds == 0
    world.pass_time(5.0)
    assert len(calls) == 1


def test_only_a_boolean_switches(world: "World") -> None:
    node, _, _ = follower(world)
    (result,) = node.set_parameters([Parameter("use_sim_time", value="yes")])
    assert not result.successful


def test_clocks_show_what_they_are(world: "World") -> None:
    assert repr(world.node().get_clock()) == "Clock(clock_type=ROS_TIME)"


@pytest.mark.parametrize("time", [TimeMessage(sec=-1), TimeMessage(sec=2**31 - 1, nanosec=2**32 - 1)])
def test_what_is_no_time_is_not_followed(world: "World", time: TimeMessage) -> None:
    node = world.node("follower", ["--ros-args", "-p", "use_sim_time:=true"])
    publisher = world.node("player").create_publisher(ClockMessage, "/clock", 10)
    for each in (TimeMessage(sec=2**31 - 1, nanosec=999_999_999), TimeMessage(sec=5), time):
        publisher.publish(ClockMessage(clock=each))
        world.pass_time(0.1)
        node.get_logger().info("still there")  # with the time in it
    assert node.get_clock().now().to_msg() == TimeMessage(sec=5)
