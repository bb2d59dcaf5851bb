import threading
from typing import TYPE_CHECKING

import pytest

import sunset_ros as ros
from conformance.processes import join_domain
from sunset_ros import CallbackError, Context, Future, Node, SingleThreadedExecutor
from sunset_ros.clock import Clock
from sunset_ros.errors import MiddlewareError
from sunset_ros.exceptions import NotInitializedException
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.rmw.dds.domains import free_domain_id
from sunset_ros.time import ClockType

if TYPE_CHECKING:
    from .conftest import World


def counter(world: "World", name: str = "counter") -> tuple[Node, list[int]]:
    node = Node(name, context=world.context(name))
    calls: list[int] = []
    node.create_timer(0.1, lambda: calls.append(world.simulation.now))
    return node, calls


def test_spin_once_runs_one_callback(world: "World") -> None:
    node, calls = counter(world)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    executor.spin_once()
    assert calls == [100_000_000]
    executor.spin_once(timeout_sec=0.05)
    assert calls == [100_000_000]
    executor.spin_once(timeout_sec=-1.0)
    assert calls == [100_000_000, 200_000_000]


def test_spin_ends_when_the_context_is_shut_down(world: "World") -> None:
    node, calls = counter(world)
    publisher = node.create_publisher(String, "/last_words", 10)
    heard: list[String] = []
    world.node("listener").create_subscription(String, "/last_words", heard.append, 10)

    def leave() -> None:
        node.context.shutdown()
        publisher.publish(String(data="bye"))

    node.create_timer(0.35, leave)
    ros.spin(node)
    assert len(calls) == 3
    assert not ros.ok(context=node.context)
    world.pass_time(0.1)
    assert heard == [String(data="bye")]
    with pytest.raises(NotInitializedException, match="cannot spin"):
        ros.spin_once(node)


def test_spinning_until_a_future_is_done(world: "World") -> None:
    server = world.node("server")
    server.create_service(Trigger, "~/go", lambda _, response: response)
    node, calls = counter(world)
    client = node.create_client(Trigger, "/server/go")
    future = client.call_async(Trigger.Request())
    ros.spin_until_future_complete(node, future)
    assert future.result() == Trigger.Response()
    never: Future[int] = Future()
    ros.spin_until_future_complete(node, never, timeout_sec=0.25)
    assert not never.done()
    assert len(calls) == 2
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    executor.spin_until_future_complete(never, timeout_sec=0.0)
    assert not never.done()


def test_what_a_callback_raises_comes_out_of_spin(world: "World") -> None:
    node, _ = counter(world)

    def fail() -> None:
        raise ValueError("bad luck")

    node.create_timer(0.15, fail)
    with pytest.raises(CallbackError, match="bad luck"):
        ros.spin(node)


def test_a_removed_node_is_held_back(world: "World") -> None:
    node, calls = counter(world)
    with SingleThreadedExecutor(context=node.context) as executor:
        assert executor.add_node(node)
        assert not executor.add_node(node)
        assert executor.get_nodes() == [node]
        executor.spin_once()
    assert executor.get_nodes() == []
    other = SingleThreadedExecutor(context=node.context)
    other.spin_once(timeout_sec=1.0)
    assert len(calls) == 1


def test_its_shutdown_in_a_callback_ends_spin(world: "World") -> None:
    node, calls = counter(world)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    node.create_timer(0.25, executor.shutdown)
    executor.spin()
    assert len(calls) == 2
    assert node.context.ok()


def test_its_shutdown_in_another_thread_ends_spin_live() -> None:
    with free_domain_id() as domain_id:
        context = join_domain(domain_id)
        executor = SingleThreadedExecutor(context=context)
        node = Node("node", context=context)
        executor.add_node(node)
        spinning = threading.Event()
        executor.create_task(spinning.set)
        thread = threading.Thread(target=executor.spin, daemon=True)
        thread.start()
        assert spinning.wait(10.0)
        executor.shutdown()
        thread.join(10.0)
        ended = not thread.is_alive()
        assert context.ok()
        context.shutdown()
        executor.shutdown()
    assert ended


def test_an_executor_runs_nodes_of_its_context_only(world: "World") -> None:
    node, _ = counter(world)
    executor = SingleThreadedExecutor(context=world.context("other"))
    assert executor.context is not node.context
    with pytest.raises(MiddlewareError, match="Node /counter belongs to another context"):
        executor.add_node(node)


def test_a_task_is_called_as_a_callback(world: "World") -> None:
    node, _ = counter(world)
    executor = SingleThreadedExecutor(context=node.context)
    with pytest.raises(MiddlewareError, match="add a node first"):
        executor.create_task(print)
    executor.add_node(node)
    future = executor.create_task(lambda first, second: first + second, 1, second=2)
    assert not future.done()
    executor.wake()
    executor.spin_until_future_complete(future)
    assert future.result() == 3


def test_a_task_may_be_a_coroutine(world: "World") -> None:
    node, _ = counter(world)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    awaited: Future[int] = Future()

    async def add(first: int) -> int:
        return first + await awaited

    tasks = [executor.create_task(add, 1), executor.create_task(add(2))]
    executor.spin_once(timeout_sec=0.01)
    executor.spin_once(timeout_sec=0.01)
    assert not any(task.done() for task in tasks)
    awaited.set_result(10)
    assert [task.result() for task in tasks] == [11, 12]


def test_the_functions_of_the_package_use_the_default_context(world: "World") -> None:
    with pytest.raises(MiddlewareError, match="A domain id was given beside a middleware"):
        ros.init(args=[], domain_id=1, middleware=world.simulation.create_process("main"))
    assert not ros.ok()
    ros.init(args=[], middleware=world.simulation.create_process("main"))
    try:
        with pytest.raises(MiddlewareError, match="initialised already"):
            ros.init(args=[], middleware=world.simulation.create_process("main"))
        node = ros.create_node("main", namespace="/uav")
        assert node.get_fully_qualified_name() == "/uav/main"
        assert ros.ok()
        assert Clock().now().nanoseconds == 0
    finally:
        ros.shutdown()
    assert not ros.ok()
    with pytest.raises(NotInitializedException, match="shut down already"):
        ros.shutdown()
    ros.try_shutdown()


def test_a_context_tells_those_who_ask_that_it_is_shut_down(world: "World") -> None:
    context = world.context()
    calls: list[str] = []
    context.on_shutdown(lambda: calls.append("down"))
    context.shutdown()
    context.try_shutdown()
    assert calls == ["down"]


def test_a_context_that_was_shut_down_can_be_used_again(world: "World") -> None:
    context = world.context("first")
    context.shutdown()
    context.init([], middleware=world.simulation.create_process("second"))
    assert context.ok()


def test_clocks_tell_virtual_time(world: "World") -> None:
    node = world.node()
    world.pass_time(1.5)
    assert node.get_clock().clock_type is ClockType.ROS_TIME
    assert node.get_clock().now().nanoseconds == 1_500_000_000
    for kind in (ClockType.STEADY_TIME, ClockType.SYSTEM_TIME):
        assert Clock(clock_type=kind, context=node.context).now().seconds_nanoseconds() == (1, 500_000_000)
    with pytest.raises(NotInitializedException):
        Clock(context=Context()).now()
