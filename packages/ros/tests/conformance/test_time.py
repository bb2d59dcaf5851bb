from functools import partial
from itertools import pairwise
from statistics import median

from conformance.harness import Harness
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock
from sunset_ros.interfaces.std_msgs.msg import Header, String
from sunset_ros.time import Time as RosTime


def test_timers_follow_the_clock_topic(harness: Harness) -> None:
    publisher = harness.node.create_publisher(Clock, "/clock", 10)
    harness.start("Clocked", "-p", "use_sim_time:=true")
    times = harness.collect(Header, "/clocked/times")
    assert harness.spin(lambda: publisher.get_subscription_count() == 1)
    assert harness.spin(lambda: harness.node.count_publishers("/clocked/times") == 1)
    harness.pause(1.5)  # which counts for nothing: the time is not known yet
    calls = {101.0: 1, 104.5: 2, 105.0: 3, 51.0: 4}
    for seconds in (100.0, 100.5, 101.0, 101.2, 104.5, 104.9, 105.0, 50.0, 50.9, 51.0):
        publisher.publish(Clock(clock=RosTime(seconds=seconds).to_msg()))
        harness.pause(0.2)
        assert harness.spin(partial(lambda called: len(times) >= called, calls.get(seconds, 0)))
    assert [time.stamp for time in times] == [
        Time(sec=101),
        Time(sec=104, nanosec=500_000_000),  # forward: one call, however many periods were passed over
        Time(sec=105),
        Time(sec=51),  # back: a new period
    ]


def test_without_it_timers_follow_the_system_clock(harness: Harness) -> None:
    harness.start("Clocked")
    times = harness.collect(Header, "/clocked/times")
    assert harness.spin(lambda: len(times) == 4)
    stamps = [RosTime.from_msg(time.stamp) for time in times]
    # the middle one of three, since a busy computer makes one call late and the time to the next one short
    period = median((later - stamp).nanoseconds for stamp, later in pairwise(stamps))
    assert 0.9e9 < period < 1.5e9


def test_the_time_of_a_node_goes_on(harness: Harness) -> None:
    clock = harness.node.get_clock()
    before = clock.now()
    harness.pause(0.2)
    assert 0.15e9 < (clock.now() - before).nanoseconds < 2e9


def test_a_timer_of_the_tester_calls_until_it_is_canceled(harness: Harness) -> None:
    heard: list[String] = []
    timer = harness.node.create_timer(0.05, lambda: heard.append(String()))
    assert harness.spin(lambda: len(heard) == 3)
    timer.cancel()
    harness.pause(0.3)
    assert len(heard) == 3
    assert timer.is_canceled()
    timer.reset()
    assert harness.spin(lambda: len(heard) == 4)
