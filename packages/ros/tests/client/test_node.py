from functools import partial
from typing import TYPE_CHECKING

import pytest

from sunset_ros import CallbackError, Context, Future, Node, Parameter
from sunset_ros.callback_groups import ReentrantCallbackGroup
from sunset_ros.errors import MiddlewareError
from sunset_ros.exceptions import (
    InvalidNodeNameException,
    InvalidServiceNameException,
    InvalidTopicNameException,
    NotInitializedException,
)
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.rcl_interfaces.msg import Log, ParameterEvent
from sunset_ros.interfaces.std_msgs.msg import Header, String
from sunset_ros.interfaces.std_srvs.srv import SetBool, Trigger
from sunset_ros.qos import qos_profile_sensor_data
from sunset_ros.rmw.sim import Tap

if TYPE_CHECKING:
    from .conftest import World


class Failing(Node):
    def __init__(self, context: Context) -> None:
        super().__init__("failing", context=context, namespace="/uav")
        self.create_subscription(String, "chat", self.on_chat, 10)
        self.create_service(Trigger, "~/trigger", self.on_trigger)
        self.client = self.create_client(SetBool, "/server/set")

    def on_chat(self, message: String) -> None:
        raise ValueError(message.data)

    def on_trigger(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return None  # type: ignore[return-value]

    def on_answer(self, _: Future[SetBool.Response]) -> None:
        raise LookupError("answer")

    async def on_chat_later(self, _: String) -> None:
        await self.client.call_async(SetBool.Request())
        raise LookupError("later")

    async def on_chat_wrongly(self, _: String) -> None:
        await NotAFuture()


class NotAFuture:
    def __await__(self):  # type: ignore[no-untyped-def]  # noqa: ANN204  wrong on purpose
        yield 1


def serve(world: "World") -> None:
    server = world.node("server")
    server.create_service(SetBool, "~/set", lambda _, response: response)


def test_a_node_tells_who_it_is(world: "World") -> None:
    node = world.node("camera", namespace="uav/front")
    assert (node.get_name(), node.get_namespace()) == ("camera", "/uav/front")
    assert node.get_fully_qualified_name() == "/uav/front/camera"
    assert node.resolve_topic_name("~/image") == "/uav/front/camera/image"
    assert node.resolve_service_name("set") == "/uav/front/set"
    assert repr(node) == "<Node /uav/front/camera>"


def test_its_own_arguments_win_over_the_processs(world: "World") -> None:
    context = world.context(
        "process", ["--ros-args", "-r", "__ns:=/all", "-r", "a:=global", "-p", "x:=1", "-p", "y:=1"]
    )
    node = Node("camera", context=context, cli_args=["--ros-args", "-r", "a:=own", "-p", "y:=2"])
    other = Node("other", context=context, use_global_arguments=False)
    assert node.get_fully_qualified_name() == "/all/camera"
    assert node.resolve_topic_name("a") == "/all/own"
    assert node.resolve_topic_name("a", only_expand=True) == "/all/a"
    assert [node.declare_parameter(name, 0).value for name in ("x", "y", "z")] == [1, 2, 0]
    assert other.get_fully_qualified_name() == "/other"


@pytest.mark.parametrize(
    ("make", "error"),
    [
        (lambda node: node.create_publisher(String, "a b", 1), InvalidTopicNameException),
        (lambda node: node.create_subscription(String, "a//b", print, 1), InvalidTopicNameException),
        (lambda node: node.create_service(Trigger, "a/", print), InvalidServiceNameException),
        (lambda node: node.create_client(Trigger, "1"), InvalidServiceNameException),
        (lambda node: node.create_publisher(String, "a", 0), MiddlewareError),
        (lambda node: node.create_publisher(String, "a", "deep"), MiddlewareError),
        (lambda node: node.create_timer(-1.0, print), MiddlewareError),
    ],
)
def test_bad_endpoints_are_refused(world: "World", make: object, error: type[Exception]) -> None:
    node = world.node()
    with pytest.raises(error):
        make(node)  # type: ignore[operator]


def test_a_node_needs_a_name_and_a_process(world: "World") -> None:
    with pytest.raises(InvalidNodeNameException):
        Node("a/b", context=world.context())
    with pytest.raises(NotInitializedException, match="call init"):
        Node("camera", context=Context())


def test_wrong_types_are_refused_where_they_are_sent(world: "World") -> None:
    node = world.node()
    with pytest.raises(TypeError, match="Topic /a carries String, got Header"):
        node.create_publisher(String, "a", 1).publish(Header())  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"Service /b takes Trigger.Request, got Request"):
        node.create_client(Trigger, "b").call_async(SetBool.Request())


def test_what_a_subscription_raises_comes_out(world: "World") -> None:
    world.make(Failing)
    world.node("talker").create_publisher(String, "/uav/chat", 10).publish(String(data="bad luck"))
    message = r"Callback Failing.on_chat \(subscription of /uav/chat\) of node /uav/failing raised ValueError: bad luck"
    with pytest.raises(CallbackError, match=message) as caught:
        world.pass_time(1.0)
    assert isinstance(caught.value.__cause__, ValueError)


def test_a_service_must_return_its_response(world: "World") -> None:
    world.make(Failing)
    world.node("asker").create_client(Trigger, "/uav/failing/trigger").call_async(Trigger.Request())
    with pytest.raises(CallbackError, match=r"on_trigger .* must return a Trigger.Response, got None"):
        world.pass_time(1.0)


def test_what_a_done_callback_raises_comes_out(world: "World") -> None:
    serve(world)
    failing = world.make(Failing)
    failing.client.call_async(SetBool.Request()).add_done_callback(failing.on_answer)
    with pytest.raises(CallbackError, match=r"node /uav/failing raised LookupError: answer"):
        world.pass_time(1.0)


def test_what_a_coroutine_raises_comes_out(world: "World") -> None:
    serve(world)
    failing = world.make(Failing)
    failing.create_subscription(String, "/later", failing.on_chat_later, 10)
    world.node("talker").create_publisher(String, "/later", 10).publish(String())
    with pytest.raises(CallbackError, match=r"node /uav/failing raised LookupError: later"):
        world.pass_time(1.0)


def test_a_coroutine_can_wait_for_futures_only(world: "World") -> None:
    failing = world.make(Failing)
    failing.create_subscription(String, "/wrong", failing.on_chat_wrongly, 10)
    world.node("talker").create_publisher(String, "/wrong", 10).publish(String())
    with pytest.raises(CallbackError, match=r"may only wait for a sunset_ros.task.Future, got 1"):
        world.pass_time(1.0)


def test_timers_may_be_coroutines(world: "World") -> None:
    serve(world)
    node = world.node("asker")
    client = node.create_client(SetBool, "/server/set")
    answers: list[object] = []

    async def ask() -> None:
        answers.append(await client.call_async(SetBool.Request()))

    node.create_timer(0.1, ask)
    node.create_timer(0.1, lambda: ask())  # noqa: PLW0108  it makes a coroutine without being a coroutine function
    world.pass_time(0.25)
    assert answers == [SetBool.Response()] * 4


def test_callbacks_of_any_kind_are_named_in_errors(world: "World") -> None:
    def fail(reason: str) -> None:
        raise ValueError(reason)

    world.node().create_timer(0.1, partial(fail, "bad luck"))
    with pytest.raises(CallbackError, match=r"Callback \S*fail \(timer\) of node /node raised ValueError"):
        world.pass_time(1.0)


def test_destroyed_parts_do_nothing_more(world: "World") -> None:
    node, other = world.node("node"), world.node("other")
    calls: list[object] = []
    publisher = node.create_publisher(String, "/a", 10)
    subscription = node.create_subscription(String, "/b", calls.append, 10)
    client = node.create_client(Trigger, "/c")
    service = node.create_service(Trigger, "/d", lambda request, _: calls.append(request))
    timer = node.create_timer(0.1, lambda: calls.append("tick"))
    other.create_publisher(String, "/b", 10).publish(String())
    assert node.destroy_publisher(publisher)
    assert node.destroy_subscription(subscription)
    assert node.destroy_client(client)
    assert node.destroy_service(service)
    assert node.destroy_timer(timer)
    assert not node.destroy_timer(timer)
    assert not other.destroy_publisher(publisher)
    world.pass_time(1.0)
    assert calls == []
    names = [name for name, _ in other.get_topic_names_and_types()]
    assert names == ["/b", "/parameter_events", "/rosout"]
    assert timer not in list(node.timers)


def test_a_destroyed_node_leaves_the_graph(world: "World") -> None:
    node, other = world.node("node"), world.node("other")
    calls: list[object] = []
    node.create_timer(0.1, lambda: calls.append("tick"))
    node.destroy_node()
    world.pass_time(1.0)
    assert calls == []
    assert other.get_fully_qualified_node_names() == ["/other"]
    assert [name for name, _ in other.get_service_names_and_types() if name.startswith("/node")] == []
    assert [list(parts) for parts in (node.publishers, node.subscriptions, node.clients, node.services)] == [
        []
    ] * 4


def test_a_forgotten_request_is_not_answered(world: "World") -> None:
    serve(world)
    client = world.node("asker").create_client(SetBool, "/server/set")
    futures = [client.call_async(SetBool.Request()) for _ in range(2)]
    client.remove_pending_request(futures[0])
    world.pass_time(1.0)
    assert [future.done() for future in futures] == [False, True]


def test_inside_a_callback_waiting_for_a_service_only_looks(world: "World") -> None:
    node = world.node()
    client = node.create_client(SetBool, "/server/set")
    seen: list[tuple[bool, int]] = []
    node.create_timer(0.1, lambda: seen.append((client.wait_for_service(5.0), world.simulation.now)))
    world.pass_time(0.15)
    serve(world)
    world.pass_time(0.1)
    assert seen == [(False, 100_000_000), (True, 200_000_000)]


def test_outside_callbacks_waiting_for_a_service_lets_time_pass(world: "World") -> None:
    client = world.node().create_client(SetBool, "/server/set")
    world.simulation.call_at(300_000_000, lambda: serve(world))
    assert not client.wait_for_service(timeout_sec=0.1)
    assert client.wait_for_service(timeout_sec=1.0)
    assert world.simulation.now == 300_000_000


def test_endpoints_that_cannot_match_are_warned_of(world: "World") -> None:
    warnings: list[str] = []

    class Listener(Tap):
        def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
            if isinstance(message, Log):
                warnings.append(message.msg)

    world.simulation.add_tap(Listener())
    world.node("camera").create_publisher(String, "/image", qos_profile_sensor_data)
    world.node("viewer").create_subscription(String, "/image", print, 10)
    world.node("fine").create_subscription(String, "/image", print, qos_profile_sensor_data)
    assert warnings == [
        "On /image, the subscription of this node and the publisher of camera do not match: incompatible reliability."
    ]


def test_parameter_events_are_made_only_for_those_who_look(world: "World") -> None:
    node = world.node("quiet")
    publisher = next(each for each in node.publishers if each.topic == "/parameter_events")
    assert not publisher.handle.wanted
    seen: list[ParameterEvent] = []
    world.node("listener").create_subscription(ParameterEvent, "/parameter_events", seen.append, 100)
    node.declare_parameter("speed", 1.5)
    node.set_parameters([Parameter("speed", value=2.5)])
    node.undeclare_parameter("speed")
    world.pass_time(0.1)
    kinds = [
        (len(event.new_parameters), len(event.changed_parameters)) for event in seen if event.node == "/quiet"
    ]
    assert kinds == [(1, 0), (0, 1)]


def test_callback_groups_are_accepted(world: "World") -> None:
    node = world.node()
    group = ReentrantCallbackGroup()
    calls: list[object] = []
    node.create_subscription(String, "/a", calls.append, 10, callback_group=group)
    node.create_publisher(String, "/a", 10, callback_group=group).publish(String())
    node.create_timer(0.1, lambda: calls.append("tick"), callback_group=group)
    node.create_service(SetBool, "/b", lambda _, response: response, callback_group=group)
    node.create_client(SetBool, "/b", callback_group=group).call_async(SetBool.Request())
    world.pass_time(0.15)
    assert calls == [String(), "tick"]


def test_a_timer_can_be_made_without_being_started(world: "World") -> None:
    calls: list[str] = []
    timer = world.node().create_timer(0.1, lambda: calls.append("tick"), autostart=False)
    world.pass_time(0.5)
    assert calls == []
    assert timer.time_until_next_call() is None
    timer.reset()
    assert timer.time_until_next_call() == 100_000_000
    world.pass_time(0.15)
    assert calls == ["tick"]
    timer.timer_period_ns = 10_000_000
    world.pass_time(0.1)
    assert (timer.timer_period_ns, len(calls)) == (10_000_000, 7)
