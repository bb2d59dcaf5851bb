import pytest
from hypothesis import given
from hypothesis import strategies as st

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.node import NodeHandle, Timer
from sunset_ros.rmw.core.port import next_due_ns
from sunset_ros.rmw.sim import Simulation

MS = 1_000_000


def node_of(sim: Simulation, name: str = "node") -> NodeHandle:
    process = sim.create_process(name)
    node = process.create_node(name, "/")
    node.attach()
    process.run()
    return node


@given(st.integers(0, 10**6), st.integers(1, 10**4), st.integers(0, 10**6))
def test_the_next_call_is_on_the_grid_not_past_and_the_first_such(due: int, period: int, late: int) -> None:
    now = due + late
    following = next_due_ns(due, period, now)
    assert (following - due) % period == 0
    assert following > due
    assert following >= now
    assert following - period == due or following - period < now


def test_a_timer_calls_every_period() -> None:
    sim = Simulation()
    calls: list[int] = []
    node_of(sim).create_timer(10 * MS, lambda: calls.append(sim.now), label="tick")
    sim.run_until(35 * MS)
    assert calls == [10 * MS, 20 * MS, 30 * MS]


def test_a_busy_process_makes_calls_late_and_skips_what_it_missed() -> None:
    sim = Simulation()
    calls: list[float] = []
    node = node_of(sim)
    node.create_timer(10 * MS, lambda: calls.append(sim.now / MS), label="tick")
    # Posted work takes 0.2 ms a piece: 126 pieces keep the process busy for 25.2 ms.
    for _ in range(126):
        sim.call_at(5 * MS, lambda: node.post(lambda: None, label="work"))
    sim.run_until(45 * MS)
    assert calls == pytest.approx([30.2, 40.0])


def test_a_canceled_timer_does_not_call_until_it_is_reset() -> None:
    sim = Simulation()
    calls: list[int] = []
    timer = node_of(sim).create_timer(10 * MS, lambda: calls.append(sim.now), label="tick")
    sim.call_at(15 * MS, timer.cancel)
    sim.call_at(33 * MS, timer.reset)
    sim.run_until(30 * MS)
    stopped = timer.canceled
    sim.run_until(50 * MS)
    assert (stopped, timer.canceled) == (True, False)
    assert calls == [10 * MS, 43 * MS]
    assert timer.due_ns == 53 * MS


def test_a_timer_canceled_while_its_call_waits_does_not_call() -> None:
    sim = Simulation()
    calls: list[str] = []
    node = node_of(sim)
    timers: list[Timer] = []
    timers.append(node.create_timer(10 * MS, lambda: timers[1].cancel(), label="first"))  # noqa: PLW0108  it does not exist yet
    timers.append(node.create_timer(10 * MS, lambda: calls.append("second"), label="second"))
    sim.run_until(50 * MS)
    assert calls == []


def test_a_timer_may_destroy_itself() -> None:
    sim = Simulation()
    calls: list[int] = []
    node = node_of(sim)

    def once() -> None:
        calls.append(sim.now)
        timer.destroy()

    timer = node.create_timer(0, once, label="once")
    sim.run_until(50 * MS)
    assert calls == [0]


def test_a_timer_of_period_zero_calls_as_often_as_the_process_can() -> None:
    sim = Simulation()
    calls: list[int] = []
    node_of(sim).create_timer(0, lambda: calls.append(sim.now), label="tick")
    sim.run_until(1 * MS)
    assert calls == [0, 200_000, 400_000, 600_000, 800_000, 1_000_000]


def test_a_new_period_holds_from_the_next_call_on() -> None:
    sim = Simulation()
    calls: list[int] = []
    timer = node_of(sim).create_timer(10 * MS, lambda: calls.append(sim.now // MS), label="tick")
    sim.call_at(15 * MS, lambda: timer.set_period_ns(3 * MS))
    sim.run_until(27 * MS)
    assert calls == [10, 20, 23, 26]


def test_a_period_cannot_be_negative_and_a_timer_that_is_refused_leaves_nothing_behind() -> None:
    node = node_of(Simulation())
    with pytest.raises(MiddlewareError, match=r"period must be at least 0 ns, got -1\.$"):
        node.create_timer(-1, lambda: None, label="tick")
    node.destroy()


def test_posted_work_is_done_once_and_after_what_was_ready() -> None:
    sim = Simulation()
    calls: list[str] = []
    node = node_of(sim)
    for name in ("first", "second"):
        node.post(lambda name=name: calls.append(name), label=name)  # type: ignore[misc]
    assert calls == []
    sim.run_until(50 * MS)
    assert calls == ["first", "second"]
