"""Processes, time and failures of the simulated world, through the port alone."""

import pickle
from collections.abc import Callable

import pytest

from sunset_ros.errors import InvalidInputError, MiddlewareError
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.rmw.core.node import NodeHandle, PublisherHandle
from sunset_ros.rmw.core.port import CallbackError
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.sim import SimProcess, Simulation, Tap

MS = 1_000_000
QOS = QoSProfile(depth=10)
Handler = Callable[[Message], None]


def start(
    sim: Simulation, name: str, *, around: Callable[[Callable[[], None]], None] | None = None
) -> tuple[SimProcess, NodeHandle]:
    process = sim.create_process(name, around=around)
    node = process.create_node(name, "/")
    node.attach()
    process.run()
    return process, node


def listen(node: NodeHandle, handler: Handler, topic: str = "/chat", depth: int = 10) -> None:
    node.create_subscription(String, topic, QoSProfile(depth=depth), handler, label="listener")


def talk(node: NodeHandle, topic: str = "/chat") -> PublisherHandle:
    return node.create_publisher(String, topic, QOS)


class Departures(Tap):
    def __init__(self) -> None:
        self.seen: list[tuple[float, str, str]] = []

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        assert isinstance(message, String)
        self.seen.append((time_ns / MS, topic, message.data))


def test_a_message_arrives_after_the_latency() -> None:
    sim = Simulation(latency_s=0.003)
    arrivals: list[int] = []
    _, listener = start(sim, "listener")
    _, talker = start(sim, "talker")
    listen(listener, lambda _: arrivals.append(sim.now))
    publisher = talk(talker)
    sim.call_at(10 * MS, lambda: publisher.publish(String(data="hello")))
    sim.run_until(20 * MS)
    assert arrivals == [13 * MS]


def test_what_a_callback_sends_leaves_when_its_modelled_time_is_over() -> None:
    sim = Simulation(compute={"/relay": 0.040}, jitter=0.0, latency_s=0.0005)
    departures = Departures()
    sim.add_tap(departures)
    _, relay = start(sim, "relay")
    _, talker = start(sim, "talker")
    answer = talk(relay, "/answer")
    started: list[float] = []

    def on_message(message: Message) -> None:
        started.append(sim.now / MS)
        answer.publish(message)

    listen(relay, on_message)
    publisher = talk(talker)
    for time in (0, 10):
        sim.call_at(time * MS, lambda: publisher.publish(String(data="image")))
    sim.run_until(1000 * MS)
    assert started == [0.5, 40.5]
    assert [time for time, topic, _ in departures.seen if topic == "/answer"] == [40.5, 80.5]


def test_the_clock_is_not_charged_as_the_nodes_own_work() -> None:
    sim = Simulation(compute={"/busy": 0.5}, jitter=0.0, latency_s=0.0)
    _, busy = start(sim, "busy")
    _, talker = start(sim, "talker")
    heard: list[float] = []
    listen(busy, lambda _: heard.append(sim.now / MS), "/clock")
    clock = talk(talker, "/clock")
    for time in (0, 10):
        sim.call_at(time * MS, lambda: clock.publish(String()))
    sim.run_until(1000 * MS)
    assert heard == [0, 10]


def test_timers_take_a_fifth_of_a_millisecond_whatever_the_node() -> None:
    sim = Simulation(compute={"/slow": 0.040}, jitter=0.0)
    departures = Departures()
    sim.add_tap(departures)
    _, node = start(sim, "slow")
    publisher = talk(node)
    node.create_timer(100 * MS, lambda: publisher.publish(String()), label="tick")
    sim.run_until(250 * MS)
    assert [time for time, _, _ in departures.seen] == [100.2, 200.2]


def test_a_subscription_keeps_the_latest_samples_while_its_process_is_busy() -> None:
    sim = Simulation(compute={"/slow": 0.040}, jitter=0.0)
    seen: list[str] = []
    _, slow = start(sim, "slow")
    _, talker = start(sim, "talker")
    listen(slow, lambda message: seen.append(message.data), depth=2)  # type: ignore[attr-defined]
    publisher = talk(talker)
    for number in range(6):
        sim.call_at(number * MS, lambda number=number: publisher.publish(String(data=str(number))))  # type: ignore[misc]
    sim.run_until(1000 * MS)
    assert seen == ["0", "4", "5"]


def test_callbacks_of_a_process_run_in_the_order_in_which_they_became_ready() -> None:
    sim = Simulation(compute={"/node": 0.010}, jitter=0.0)
    seen: list[str] = []
    _, node = start(sim, "node")
    _, talker = start(sim, "talker")
    for topic in ("/first", "/second"):
        listen(node, lambda _, topic=topic: seen.append(topic), topic)  # type: ignore[misc]
    first, second = talk(talker, "/first"), talk(talker, "/second")
    sim.call_at(0, lambda: first.publish(String()))
    sim.call_at(1 * MS, lambda: second.publish(String()))
    sim.call_at(2 * MS, lambda: first.publish(String()))
    sim.run_until(1000 * MS)
    assert seen == ["/first", "/second", "/first"]


def test_callbacks_wait_until_the_node_is_attached_and_the_process_runs() -> None:
    sim = Simulation()
    seen: list[str] = []
    process = sim.create_process("listener")
    node = process.create_node("listener", "/")
    listen(node, lambda message: seen.append(message.data))  # type: ignore[attr-defined]
    _, talker = start(sim, "talker")
    talk(talker).publish(String(data="early"))
    sim.run_until(10 * MS)
    process.run()
    sim.run_until(20 * MS)
    assert seen == []
    node.attach()
    sim.run_until(30 * MS)
    assert seen == ["early"]
    node.detach()
    talk(talker).publish(String(data="late"))
    sim.run_until(40 * MS)
    assert seen == ["early"]


def test_killing_a_process_drops_what_it_was_about_to_send_and_what_was_on_its_way_to_it() -> None:
    sim = Simulation(compute={"/relay": 0.040}, jitter=0.0)
    departures = Departures()
    sim.add_tap(departures)
    calls: list[int] = []
    process, relay = start(sim, "relay")
    _, talker = start(sim, "talker")
    answer = talk(relay, "/answer")

    def on_message(message: Message) -> None:
        calls.append(sim.now)
        answer.publish(message)

    listen(relay, on_message)
    publisher = talk(talker)
    for time in (0, 9.8):
        sim.call_at(round(time * MS), lambda: publisher.publish(String(data="x")))
    sim.call_at(10 * MS, lambda: sim.kill(process))
    sim.run_until(1000 * MS)
    assert len(calls) == 1
    assert [topic for _, topic, _ in departures.seen] == ["/chat", "/chat"]
    assert sim.node_names() == ["/talker"]
    assert not process.alive


def test_shutdown_in_a_callback_ends_the_process_when_what_it_sent_has_left() -> None:
    sim = Simulation(compute={"/node": 0.010}, jitter=0.0)
    departures = Departures()
    sim.add_tap(departures)
    exits: list[tuple[str, float]] = []
    process, node = start(sim, "node")
    _, talker = start(sim, "talker")
    publisher = talk(node, "/last_words")

    def on_message(message: Message) -> None:
        publisher.publish(message)
        process.shutdown()
        assert not process.alive
        publisher.publish(message)

    listen(node, on_message)
    sim.on_exit(process, lambda ended: exits.append((ended.name, sim.now / MS)))
    talk(talker).publish(String(data="x"))
    sim.run_until(1000 * MS)
    assert exits == [("node", 10.5)]
    assert [topic for _, topic, _ in departures.seen] == ["/chat", "/last_words", "/last_words"]
    assert sim.node_names() == ["/talker"]


def test_exit_handlers_may_start_a_new_process_of_the_same_name() -> None:
    sim = Simulation()
    seen: list[str] = []

    def launch() -> None:
        process, node = start(sim, "node")
        listen(node, lambda message: seen.append(message.data))  # type: ignore[attr-defined]
        sim.on_exit(process, lambda _: launch())
        processes.append(process)

    processes: list[SimProcess] = []
    launch()
    _, talker = start(sim, "talker")
    publisher = talk(talker)
    sim.call_at(10 * MS, lambda: sim.kill(processes[0]))
    sim.call_at(20 * MS, lambda: publisher.publish(String(data="again")))
    sim.run_until(30 * MS)
    assert len(processes) == 2
    assert seen == ["again"]


def test_killing_twice_calls_exit_handlers_once() -> None:
    sim = Simulation()
    process, _ = start(sim, "node")
    exits: list[SimProcess] = []
    sim.on_exit(process, exits.append)
    sim.kill(process)
    sim.kill(process)
    assert exits == [process]


def test_an_exception_in_a_callback_comes_out_and_names_node_and_callback() -> None:
    sim = Simulation()
    _, node = start(sim, "node")

    def tick() -> None:
        raise ValueError("bad luck")

    node.create_timer(10 * MS, tick, label="Node.tick (timer)")
    with pytest.raises(
        CallbackError, match=r"Callback Node.tick \(timer\) of node /node raised ValueError: bad luck"
    ) as caught:
        sim.run_until(100 * MS)
    assert isinstance(caught.value.__cause__, ValueError)
    assert (caught.value.node, caught.value.callback) == ("/node", "Node.tick (timer)")
    copied = pickle.loads(pickle.dumps(caught.value))  # noqa: S301  workers send it to who waits for them
    assert (type(copied), str(copied), copied.node) == (CallbackError, str(caught.value), "/node")
    assert sim.now == 10 * MS


def test_the_world_goes_on_after_an_exception_and_nothing_is_lost() -> None:
    sim = Simulation()
    departures = Departures()
    sim.add_tap(departures)
    _, node = start(sim, "node")
    _, other = start(sim, "other")
    _, talker = start(sim, "talker")
    answer = talk(node, "/answer")
    seen: list[str] = []

    def fail(message: Message) -> None:
        answer.publish(message)
        raise ValueError

    listen(node, fail)
    listen(other, lambda message: seen.append(message.data))  # type: ignore[attr-defined]
    talk(talker).publish(String(data="x"))
    with pytest.raises(CallbackError):
        sim.run_until(100 * MS)
    sim.run_until(100 * MS)
    assert seen == ["x"]
    assert [topic for _, topic, _ in departures.seen] == ["/chat", "/answer"]


def test_callbacks_of_a_process_can_be_called_by_somebody_else() -> None:
    sim = Simulation()
    around: list[str] = []

    def call(callback: Callable[[], None]) -> None:
        around.append("before")
        callback()
        around.append("after")

    _, node = start(sim, "manager", around=call)
    node.create_timer(10 * MS, lambda: around.append("callback"), label="tick")
    sim.run_until(15 * MS)
    assert around == ["before", "callback", "after"]


def test_a_callback_cannot_run_the_world_that_it_is_part_of() -> None:
    sim = Simulation()
    process, node = start(sim, "node")
    errors: list[MiddlewareError] = []

    def tick() -> None:
        for forbidden in (
            lambda: sim.run_until(10**9),
            lambda: sim.run_while(lambda: True, 10**9),
            lambda: process.spin_once(None),
        ):
            with pytest.raises(MiddlewareError, match="callback") as caught:
                forbidden()
            errors.append(caught.value)
        assert not process.wait_for(lambda: False, None)
        assert process.wait_for(lambda: True, None)

    timer = node.create_timer(10 * MS, tick, label="tick")
    sim.run_until(15 * MS)
    timer.cancel()
    assert len(errors) == 3


def test_spin_once_runs_one_callback_of_its_process_and_moves_the_whole_world() -> None:
    sim = Simulation()
    process = sim.create_process("listener")
    node = process.create_node("listener", "/")
    node.attach()
    seen: list[str] = []
    listen(node, lambda message: seen.append(message.data))  # type: ignore[attr-defined]
    _, talker = start(sim, "talker")
    publisher = talk(talker)
    talker.create_timer(10 * MS, lambda: publisher.publish(String(data=str(sim.now // MS))), label="tick")
    assert process.spin_once(None)
    assert process.spin_once(1000 * MS)
    assert seen == ["10", "20"]
    assert not process.spin_once(1 * MS)
    sim.run_until(100 * MS)
    assert seen == ["10", "20"]  # between spins nothing runs, as in rclpy


def test_spinning_for_ever_in_a_world_where_nothing_happens_is_an_error() -> None:
    process = Simulation().create_process("lonely")
    with pytest.raises(MiddlewareError, match="Nothing is left to happen"):
        process.spin_once(None)
    with pytest.raises(MiddlewareError, match="Nothing is left to happen"):
        process.wait_for(lambda: False, None)


def test_a_timeout_passes_in_a_world_where_nothing_happens() -> None:
    sim = Simulation()
    process = sim.create_process("lonely")
    assert not process.spin_once(5 * MS)
    assert not process.wait_for(lambda: False, 5 * MS)
    assert sim.now == 10 * MS


def test_a_process_that_has_ended_can_do_nothing() -> None:
    sim = Simulation()
    process, node = start(sim, "node")
    publisher = talk(node)
    timer = node.create_timer(MS, lambda: None, label="tick")
    sim.kill(process)
    for forbidden in (
        lambda: process.create_node("node", "/"),
        lambda: talk(node),
        lambda: publisher.publish(String()),
        process.run,
        timer.reset,
        lambda: process.spin_once(0),
    ):
        with pytest.raises(MiddlewareError, match="ended"):
            forbidden()


def test_a_destroyed_node_can_have_no_new_endpoints() -> None:
    sim = Simulation()
    _, node = start(sim, "node")
    node.destroy()
    with pytest.raises(MiddlewareError, match="Node /node is destroyed"):
        talk(node)


def test_nothing_can_be_called_in_the_past() -> None:
    sim = Simulation()
    sim.run_until(10)
    with pytest.raises(MiddlewareError, match="Nothing can be called at 9 ns: it is 10 ns already"):
        sim.call_at(9, lambda: None)


@pytest.mark.parametrize("latency", [-0.1, float("nan"), float("inf")])
def test_the_latency_must_be_possible(latency: float) -> None:
    with pytest.raises(MiddlewareError, match="latency must be at least 0 s"):
        Simulation(latency_s=latency)


def test_a_seed_must_be_valid() -> None:
    with pytest.raises(InvalidInputError, match="seed"):
        Simulation(seed=-1)
