"""The process: its line of callbacks, its timers, its end."""

import os
import signal
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pytest

from sunset_ros import Context, Node
from sunset_ros.errors import InterfaceError, MiddlewareError
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Int32, String
from sunset_ros.rmw.core.node import NodeHandle
from sunset_ros.rmw.core.port import CallbackError
from sunset_ros.rmw.core.qos import QoSProfile, ReliabilityPolicy
from sunset_ros.rmw.dds import CycloneDDS

if TYPE_CHECKING:
    from .conftest import Live

MS = 1_000_000
QOS = QoSProfile()


def run_for(process: CycloneDDS, duration_ns: int) -> int:
    """Run callbacks for some time; return how many ran."""
    end_ns = process.steady_ns() + duration_ns
    calls = 0
    while (left_ns := end_ns - process.steady_ns()) > 0:
        calls += process.spin_once(left_ns)
    return calls


def run_until(process: CycloneDDS, predicate: Callable[[], bool]) -> bool:
    """Run callbacks until a predicate holds, however busy the computer is; return whether it does."""
    end_ns = process.steady_ns() + 10_000 * MS
    while not predicate() and (left_ns := end_ns - process.steady_ns()) > 0:
        process.spin_once(left_ns)
    return predicate()


def node_of(process: CycloneDDS, name: str = "node") -> NodeHandle:
    node = process.create_node(name, "/")
    node.attach()
    return node


def test_the_oldest_samples_beyond_the_depth_are_dropped(live: "Live") -> None:
    process = live.process()
    node = node_of(process)
    seen: list[Message] = []
    qos = QoSProfile(depth=5)
    subscription = node.create_subscription(Int32, "/numbers", qos, seen.append, label="seen")
    publisher = node.create_publisher(Int32, "/numbers", qos)
    assert (publisher.matched, subscription.matched) == (1, 1)
    for number in range(20):
        publisher.publish(Int32(data=number))
    assert run_until(process, lambda: len(seen) == 5)
    assert run_for(process, 20 * MS) == 0
    assert seen == [Int32(data=number) for number in range(15, 20)]


def test_samples_that_nobody_takes_cost_no_memory(live: "Live") -> None:
    process = live.process()
    node = node_of(process)
    node.create_subscription(Image, "/images", QoSProfile(depth=2), print, label="print")
    publisher = node.create_publisher(Image, "/images", QOS)
    image = Image(data=np.zeros(1_000_000, np.uint8))
    for _ in range(20):
        publisher.publish(image)
    before = resident_bytes()
    for _ in range(200):
        publisher.publish(image)
    assert resident_bytes() - before < 50_000_000


def resident_bytes() -> int:
    with open("/proc/self/statm") as file:  # noqa: PTH123  no file, but a question to the kernel
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def listen(node: NodeHandle, topic: str, order: list[str]) -> None:
    node.create_subscription(String, topic, QOS, lambda _: order.append(topic), label=topic)


def test_callbacks_take_turns(live: "Live") -> None:
    process = live.process()
    node = node_of(process)
    order: list[str] = []
    for lined_up, topic in enumerate(("/a", "/b"), 1):
        listen(node, topic, order)
        publisher = node.create_publisher(String, topic, QOS)
        for _ in range(3):
            publisher.publish(String())
        assert process.wait_for(lambda: len(process.queue._items) == lined_up, 10_000 * MS)  # noqa: B023
    assert run_until(process, lambda: len(order) == 6)
    assert run_for(process, 20 * MS) == 0
    assert order == ["/a", "/b"] * 3


def test_what_is_posted_comes_after_what_is_ready(live: "Live") -> None:
    process = live.process()
    node = node_of(process)
    order: list[str] = []
    for name in ("first", "second"):
        node.post(lambda name=name: order.append(name), name)  # type: ignore[misc]
    assert order == []
    assert process.spin_once(0)
    assert process.spin_once(0)
    assert not process.spin_once(0)
    assert order == ["first", "second"]


def test_callbacks_of_a_node_that_is_not_attached_are_held_back(live: "Live") -> None:
    process = live.process()
    node = process.create_node("node", "/")
    calls: list[str] = []
    node.create_subscription(String, "/chat", QOS, lambda _: calls.append("message"), label="message")
    node.create_publisher(String, "/chat", QOS).publish(String())
    node.create_timer(0, lambda: calls.append("timer"), "timer").cancel()
    node.post(lambda: calls.append("posted"), "posted")
    assert run_for(process, 50 * MS) == 0
    node.attach()
    assert run_until(process, lambda: len(calls) == 2)
    assert run_for(process, 20 * MS) == 0
    node.detach()
    node.post(lambda: calls.append("posted"), "posted")
    assert run_for(process, 20 * MS) == 0
    assert sorted(calls) == ["message", "posted"]


def test_a_callback_that_raises_ends_the_spin_and_not_the_process(live: "Live") -> None:
    process = live.process()
    node = node_of(process)

    def fail() -> None:
        raise ValueError("bad luck")

    node.post(fail, "fail")
    node.post(lambda: None, "go on")
    with pytest.raises(CallbackError, match="Callback fail of node /node raised ValueError: bad luck"):
        process.spin_once(None)
    assert process.spin_once(None)


def test_spinning_inside_a_callback_is_refused(live: "Live") -> None:
    process = live.process()

    def again() -> None:
        process.spin_once(0)

    node_of(process).post(again, "again")
    with pytest.raises(CallbackError, match="Spinning inside a callback would wait for itself"):
        process.spin_once(None)


def test_another_thread_may_wake_it_and_post_to_it(live: "Live") -> None:
    process = live.process()
    node = node_of(process)
    threading.Timer(0.02, process.wake).start()
    assert not process.spin_once(None)
    calls: list[int] = []
    threading.Timer(0.02, lambda: node.post(lambda: calls.append(1), "posted")).start()
    assert process.spin_once(None)
    assert calls == [1]


def test_waiting_ends_when_the_predicate_holds_or_time_is_over(live: "Live") -> None:
    process = live.process()
    late = threading.Event()
    threading.Timer(0.03, late.set).start()
    assert process.wait_for(late.is_set, None)
    assert not process.wait_for(lambda: False, 20 * MS)
    assert not process.wait_for(lambda: False, 0)
    looked: list[bool] = []
    node_of(process).post(lambda: looked.append(process.wait_for(lambda: False, None)), "look")
    assert process.spin_once(None)
    assert looked == [False]


def test_a_timer_calls_once_a_period_until_it_is_canceled(live: "Live") -> None:
    process = live.process()
    times: list[int] = []
    node = node_of(process)
    start, earliest_ns = process.steady_ns(), process.now_ns() + 19 * MS
    timer = node.create_timer(20 * MS, lambda: times.append(process.steady_ns()), "tick")
    assert earliest_ns < timer.due_ns < process.now_ns() + 21 * MS
    while len(times) < 3:
        assert process.spin_once(None)
    assert all(time >= start + (index + 1) * 19 * MS for index, time in enumerate(times))
    timer.cancel()
    canceled = [timer.canceled]
    assert run_for(process, 50 * MS) == 0
    timer.set_period_ns(10 * MS)
    timer.reset()
    canceled.append(timer.canceled)
    assert process.spin_once(None)
    assert canceled == [True, False]
    with pytest.raises(MiddlewareError, match="at least 0 ns, got -1"):
        timer.set_period_ns(-1)


def test_calls_missed_while_the_process_was_busy_are_not_made_up_for(live: "Live") -> None:
    process = live.process()
    node = node_of(process)
    calls: list[int] = []
    node.create_timer(10 * MS, lambda: calls.append(1), "tick")

    over_ns: list[int] = []

    def busy() -> None:
        threading.Event().wait(0.1)
        calls.clear()
        over_ns.append(process.steady_ns())

    node.post(busy, "busy")
    assert run_until(process, lambda: bool(over_ns and calls))
    assert len(calls) <= 1 + (process.steady_ns() - over_ns[0]) // (10 * MS)


def test_a_timer_without_a_period_starves_nobody(live: "Live") -> None:
    process = live.process()
    node = node_of(process)
    seen: list[Message] = []
    node.create_timer(0, lambda: None, "always")
    node.create_subscription(String, "/chat", QOS, seen.append, label="seen")
    node.create_publisher(String, "/chat", QOS).publish(String())
    assert run_until(process, lambda: bool(seen))
    assert seen == [String()]


def test_a_message_that_does_not_fit_is_not_sent(live: "Live") -> None:
    publisher = node_of(live.process()).create_publisher(Int32, "/numbers", QOS)
    with pytest.raises(InterfaceError, match="must be a whole number"):
        publisher.publish(Int32(data=2**31))


def test_a_sender_keeps_what_it_sent(live: "Live") -> None:
    process = live.process()
    node = node_of(process)
    seen: list[Message] = []
    node.create_subscription(String, "/chat", QOS, seen.append, label="seen")
    message = String(data="before")
    node.create_publisher(String, "/chat", QOS).publish(message)
    message.data = "after"
    assert process.spin_once(10_000 * MS)
    assert seen == [String(data="before")]


def test_a_publisher_is_wanted_while_somebody_listens(live: "Live") -> None:
    node = node_of(live.process())
    publisher = node.create_publisher(String, "/chat", QOS)
    wanted = [publisher.wanted]
    best_effort = QoSProfile(reliability=ReliabilityPolicy.BEST_EFFORT)
    subscription = node.create_subscription(String, "/chat", best_effort, print, label="print")
    wanted.append(publisher.wanted)
    subscription.destroy()
    subscription.destroy()
    wanted.append(publisher.wanted)
    assert wanted == [False, True, False]
    assert (publisher.matched, subscription.matched) == (0, 0)
    publisher.destroy()
    with pytest.raises(MiddlewareError, match="Node /node cannot publish on /chat: it was destroyed"):
        publisher.publish(String())


def test_a_destroyed_node_is_gone_with_all_it_had(live: "Live") -> None:
    process = live.process()
    node = node_of(process)
    calls: list[int] = []
    node.create_timer(0, lambda: calls.append(1), "tick")
    node.create_subscription(String, "/chat", QOS, lambda _: calls.append(2), label="chat")
    node.create_publisher(String, "/chat", QOS).publish(String())
    node.post(lambda: calls.append(3), "posted")
    node.destroy()
    assert run_for(process, 30 * MS) == 0
    assert process.nodes() == []
    assert process.wait_for(lambda: process.endpoints() == [], 10_000 * MS)
    with pytest.raises(MiddlewareError, match="Node /node is destroyed and can have no new endpoints"):
        node.create_publisher(String, "/chat", QOS)


def test_a_callback_that_shuts_down_still_sends(live: "Live") -> None:
    process, other = live.process(), live.process()
    seen: list[Message] = []
    subscription = node_of(other, "other").create_subscription(
        String, "/last", QOS, seen.append, label="seen"
    )
    node = node_of(process)
    publisher = node.create_publisher(String, "/last", QOS)

    def leave() -> None:
        process.shutdown()
        assert not process.alive
        publisher.publish(String(data="bye"))

    assert other.wait_for(lambda: subscription.matched == publisher.matched == 1, 10_000 * MS)
    node.post(leave, "leave")
    assert process.spin_once(None)
    assert other.spin_once(10_000 * MS)
    assert seen == [String(data="bye")]
    assert other.nodes() == [("other", "/")]
    assert other.wait_for(lambda: len(other.endpoints()) == 1, 10_000 * MS)


def test_a_process_that_has_ended_can_do_nothing(live: "Live") -> None:
    with live.process() as process:
        node = node_of(process)
        publisher = node.create_publisher(String, "/chat", QOS)
        timer = node.create_timer(0, print, "tick")
        assert "alive" in repr(process)
    assert not process.alive
    assert "ended" in repr(process)
    process.shutdown()
    for action in (
        lambda: process.create_node("new", "/"),
        process.nodes,
        process.endpoints,
        lambda: publisher.publish(String()),
        lambda: node.create_publisher(String, "/chat", QOS),
        timer.reset,
    ):
        with pytest.raises(MiddlewareError):
            action()
    assert not process.wait_for(lambda: False, None)
    assert not process.spin_once(None)
    node.destroy()


@pytest.mark.parametrize("where", ["spin", "wait"])
def test_a_signal_handler_may_shut_it_down(live: "Live", where: str) -> None:
    process = live.process()
    node_of(process).create_publisher(String, "/chat", QOS)
    previous = signal.signal(signal.SIGUSR1, lambda *_: process.shutdown())
    try:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGUSR1)).start()
        if where == "spin":
            assert not process.spin_once(None)
        else:
            assert not process.wait_for(lambda: False, None)
    finally:
        signal.signal(signal.SIGUSR1, previous)
    assert not process.alive


def make_nodes(context: Context) -> None:
    """Make nodes until it fails."""
    for number in range(100_000):
        Node(f"node{number}", context=context)


@pytest.mark.parametrize("delay_ms", range(1, 25, 3))
def test_a_signal_handler_may_shut_it_down_while_a_node_is_made(live: "Live", delay_ms: int) -> None:
    context = Context()
    context.init([], middleware=live.process())
    previous = signal.signal(signal.SIGALRM, lambda *_: context.try_shutdown())
    try:
        signal.setitimer(signal.ITIMER_REAL, delay_ms / 1000)
        with pytest.raises(MiddlewareError):
            make_nodes(context)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
    assert not context.ok()


def test_processes_of_one_program_share_a_domain_and_leave_it_one_by_one(live: "Live") -> None:
    first, second = live.process(), live.process()
    first.shutdown()
    node_of(second, "second")
    assert second.nodes() == [("second", "/")]
    second.shutdown()
    node_of(live.process(), "third")
