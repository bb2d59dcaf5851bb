"""A process behind a pipe is one of the simulation, and whatever it says, the simulation goes on."""

import socket
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import msgspec
import pytest

from conformance.nodes import NODES
from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.errors import InterfaceError, MiddlewareError
from sunset_ros.interfaces import Message, serialize
from sunset_ros.interfaces.std_msgs.msg import Int32, String
from sunset_ros.interfaces.std_srvs.srv import SetBool, Trigger
from sunset_ros.rmw.core.port import EndpointKind, RequestId
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.remote import Gateway, Pipe, RemoteProcess
from sunset_ros.rmw.sim import Simulation, Tap

Main = Callable[[Context], object]
_S = 10**9


class Listener(Tap):
    """Keeps all that happens, in order."""

    def __init__(self) -> None:
        self.events: list[object] = []

    def on_node(self, process: str, node: str) -> None:
        self.events.append((process, node))

    def on_endpoint(self, node: str, kind: EndpointKind, name: str) -> None:
        self.events.append((node, kind, name))

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        self.events.append((time_ns, topic, node, serialize(message)))

    def on_request(  # noqa: PLR0917  as of Tap
        self, time_ns: int, service: str, client: str, server: str, request: Message, request_id: RequestId
    ) -> None:
        self.events.append((time_ns, service, client, server, serialize(request), request_id))

    def on_response(
        self, time_ns: int, service: str, server: str, response: Message, request_id: RequestId
    ) -> None:
        self.events.append((time_ns, service, server, serialize(response), request_id))


class World:
    """A simulation with the nodes Talker and Server, and one process more."""

    def __init__(self) -> None:
        self.simulation = Simulation(seed=1)
        self.listener = Listener()
        self.simulation.add_tap(self.listener)
        for name in ("Talker", "Server"):
            self.bring_up(name, NODES[name])

    def bring_up(self, name: str, main: Main) -> None:
        """Run nodes in this Python process."""
        process = self.simulation.create_process(name)
        context = Context()
        context.init([], middleware=process)
        set_up(context, main)
        if process.alive:
            process.run()

    def connect(self, limit_s: float = 10.0) -> tuple[Gateway, socket.socket]:
        """Return what stands for a process, and where that process is expected."""
        ours, theirs = socket.socketpair()
        self.remote = self.simulation.create_process("remote")
        self.pipe = Pipe(ours)
        return Gateway(self.remote, self.pipe, limit_s=limit_s, end=self.remote.end), theirs

    def fly(self, main: Main, *, remote: bool, seconds: float = 2.0) -> Gateway | None:
        """Run the process `remote` for some time, here or behind a pipe, and return what stands for it."""
        gateway = None
        if remote:
            gateway, theirs = self.connect()
            thread = threading.Thread(target=serve, args=(theirs, main))
            thread.start()
            gateway.start()
            if self.remote.alive:
                self.remote.run()
        else:
            self.bring_up("remote", main)
        self.simulation.run_until(self.simulation.now + round(seconds * _S))
        if gateway is not None:
            self.pipe.close()
            thread.join()
        return gateway


def serve(door: socket.socket, main: Main) -> None:
    """Be the process behind a pipe."""

    def make(process: RemoteProcess) -> None:
        context = Context()
        context.init([], middleware=process)
        set_up(context, main)

    with door:
        RemoteProcess(Pipe(door), make).serve()


def set_up(context: Context, main: Main) -> None:
    node = main(context)
    if isinstance(node, Node):
        SingleThreadedExecutor(context=context).add_node(node)


class Busy(Node):
    """Does all that a node can do, and says what it sees."""

    def __init__(self, context: Context) -> None:
        super().__init__("busy", context=context)
        self.out = self.create_publisher(String, "seen", 10)
        self.ask = self.create_client(SetBool, "/server/set")
        self.declare_parameter("rate", 0.1)
        self.create_service(Trigger, "~/trigger", self.trigger)
        self.heard = 0
        self.subscription = self.create_subscription(String, "/chatter", self.hear, 1)
        self.timer = self.create_timer(0.15, self.tick)
        self.once = self.create_timer(0.07, self.stop)

    def say(self, text: object) -> None:
        now = self.get_clock().now().nanoseconds
        self.out.publish(String(data=f"{now} {text}"))
        self.get_logger().info(str(text))

    def hear(self, message: String) -> None:
        self.heard += 1
        self.say(f"heard {message.data}, {self.subscription.get_publisher_count()}")
        if self.heard == 5:
            self.destroy_subscription(self.subscription)
            self.timer.timer_period_ns = 50_000_000

    def stop(self) -> None:
        self.once.cancel()
        self.say((self.once.is_canceled(), self.timer.time_until_next_call()))

    async def tick(self) -> None:
        self.say((self.ask.service_is_ready(), self.out.get_subscription_count()))
        self.say(self.get_node_names_and_namespaces())
        self.say([info.endpoint_gid for info in self.get_publishers_info_by_topic("/chatter")])
        answer = await self.ask.call_async(SetBool.Request(data=True))
        self.say(answer.message)
        with pytest.raises(MiddlewareError) as caught:
            self.spin()
        self.say(caught.value)
        if self.heard == 5:
            self.context.on_shutdown(lambda: self.say("the end"))
            self.context.shutdown()

    def spin(self) -> None:
        SingleThreadedExecutor(context=self.context).spin_once()

    def trigger(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.message = "triggered"
        return response


def waiting(context: Context) -> Node:
    """Let the world go on before the node is made, and wait for it."""
    node = Node("waiting", context=context)
    out = node.create_publisher(String, "seen", 10)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    heard: list[str] = []
    node.create_subscription(String, "/chatter", lambda message: heard.append(message.data), 10)
    client = node.create_client(Trigger, "/server/ask")
    out.publish(String(data=str((client.wait_for_service(1.0), node.get_clock().now().nanoseconds))))
    for _ in range(3):
        executor.spin_once(0.5)
    out.publish(String(data=str(heard)))
    future = client.call_async(Trigger.Request())
    executor.spin_until_future_complete(future, 1.0)
    out.publish(String(data=str((future.result(), node.get_clock().now().nanoseconds))))
    absent = node.create_client(Trigger, "/nobody")
    out.publish(String(data=str((absent.wait_for_service(0.2), node.get_clock().now().nanoseconds))))
    executor.remove_node(node)
    return node


def talkative(context: Context) -> Node:
    """Say much at once."""
    node = Node("talkative", context=context)
    out = node.create_publisher(String, "seen", 10)
    for number in range(10):
        out.publish(String(data=str(number) * (4 << 20)))
    return node


def leaving(context: Context) -> None:
    """Leave the network before any callback."""
    node = Node("leaving", context=context)
    node.create_publisher(String, "seen", 10).publish(String(data="gone"))
    other = Node("other", context=context)
    other.destroy_node()
    context.shutdown()
    with pytest.raises(MiddlewareError):
        node.create_publisher(String, "more", 10)


@pytest.mark.parametrize("main", [Busy, waiting, leaving, talkative, *NODES.values()])
def test_everything_happens_as_in_one_process(main: Main) -> None:
    here, there = World(), World()
    here.fly(main, remote=False)
    gateway = there.fly(main, remote=True)

    assert gateway is not None
    assert gateway.failure is None
    assert there.listener.events == here.listener.events
    assert there.simulation.endpoints() == here.simulation.endpoints()
    assert len(here.listener.events) > 50


class Noting(Node):
    """Takes notes of what it hears, and tells them every now and then, also while it waits."""

    def __init__(self, context: Context) -> None:
        super().__init__("noting", context=context)
        self.notes: list[tuple[int, str]] = []
        self.out = self.create_publisher(String, "seen", 10)
        self.subscription = self.create_subscription(String, "/chatter", self.note, 10)
        self.asking = self.create_client(Trigger, "/server/ask")
        self.create_timer(0.35, self.tell)

    def note(self, message: String) -> None:
        self.notes.append((self.get_clock().now().nanoseconds, message.data))

    def tell(self) -> None:
        self.out.publish(String(data=str(self.notes)))
        if len(self.notes) > 12:
            self.destroy_subscription(self.subscription)


def noting(context: Context) -> Node:
    """Wait for messages, and for what else there is, before it is spun."""
    node = Noting(context)
    if isinstance(context.middleware, RemoteProcess):
        context.middleware.defer(node.subscription.handle)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    for _ in range(4):
        executor.spin_once(1.0)
        node.out.publish(String(data=str((node.notes, node.get_clock().now().nanoseconds))))
    executor.spin_until_future_complete(node.asking.call_async(Trigger.Request()), 1.0)
    executor.remove_node(node)
    return node


def test_what_may_wait_comes_before_the_next_and_saves_turns(monkeypatch: pytest.MonkeyPatch) -> None:
    turns = {True: 0, False: 0}
    send = Pipe.send

    def count(pipe: Pipe, body: bytes, end_s: float | None = None) -> None:
        turns[deferring] += 1
        send(pipe, body, end_s)

    monkeypatch.setattr(Pipe, "send", count)
    here, there, undeferred = World(), World(), World()
    deferring = True
    here.fly(noting, remote=False, seconds=3.0)
    gateway = there.fly(noting, remote=True, seconds=3.0)
    monkeypatch.setattr(RemoteProcess, "defer", lambda *_: None)
    deferring = False
    undeferred.fly(noting, remote=True, seconds=3.0)

    assert gateway is not None
    assert gateway.failure is None
    assert there.listener.events == here.listener.events == undeferred.listener.events
    assert turns[True] < turns[False] - 10


def test_what_a_waiting_handler_raises_is_told() -> None:
    heard: list[int] = []

    def angry(context: Context) -> Node:
        node = Node("angry", context=context)
        subscription = node.create_subscription(String, "/chatter", lambda _: 1 // 0, 10)
        assert isinstance(context.middleware, RemoteProcess)
        context.middleware.defer(subscription.handle)
        node.create_timer(0.5, lambda: heard.append(2))
        return node

    gateway = World().fly(angry, remote=True)
    assert gateway is not None
    assert "raised ZeroDivisionError" in str(gateway.failure)
    assert heard == []


def test_what_does_not_fit_is_told_where_it_is_sent() -> None:
    told: list[str] = []

    def main(context: Context) -> None:
        node = Node("wrong", context=context)
        for wrong in (
            lambda: node.create_publisher(Int32, "n", 1).publish(Int32(data="a")),  # type: ignore[arg-type]
            lambda: node.create_client(SetBool, "s").call_async(SetBool.Request(data="a")),  # type: ignore[arg-type]
        ):
            with pytest.raises(InterfaceError) as caught:
                wrong()
            told.append(str(caught.value))

    gateway = World().fly(main, remote=True)

    assert gateway is not None
    assert gateway.failure is None
    assert len(told) == 2


def test_a_callback_that_raises_while_the_process_waits_is_its_failure() -> None:
    def main(context: Context) -> None:
        node = Node("waiting", context=context)
        node.create_subscription(String, "/chatter", lambda _: 1 // 0, 10)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        executor.spin()

    gateway = World().fly(main, remote=True)
    assert gateway is not None
    assert "raised ZeroDivisionError" in str(gateway.failure)


class Failing(Node):
    """Raises after a second, having said so."""

    def __init__(self, context: Context) -> None:
        super().__init__("failing", context=context)
        self.out = self.create_publisher(String, "seen", 10)
        self.create_timer(1.0, self.fail)

    def fail(self) -> None:
        self.out.publish(String(data="which never leaves"))
        raise LookupError("nothing")


def test_a_process_that_raises_ends_at_that_moment_and_nothing_else_does() -> None:
    world = World()
    gateway = world.fly(Failing, remote=True, seconds=0.9)
    assert gateway is not None
    assert gateway.failure is None

    worlds = [World(), World()]
    for each in worlds:
        gateway = each.fly(Failing, remote=True, seconds=2.0)
        assert gateway is not None
        assert str(gateway.failure) == "raised LookupError: nothing"
        assert each.simulation.node_names() == ["/server", "/talker"]
        said = [event for event in each.listener.events if isinstance(event, tuple) and "/seen" in event]
        assert said == []
        assert each.simulation.now == 2 * _S
    assert worlds[0].listener.events == worlds[1].listener.events


def frame(*statements: Any) -> bytes:
    body = msgspec.msgpack.encode(list(statements))
    return len(body).to_bytes(4, "little") + body


NODE = ("MakeNode", 1, "n", "/")
DONE = ("Done", False)
QOS = msgspec.to_builtins(QoSProfile())
STRING = "std_msgs/msg/String"


def endpoint(kind: str, type_name: str = STRING, name: str = "/x", qos: Any = QOS, node: int = 1) -> Any:
    return ("MakeEndpoint", 2, node, kind, type_name, name, qos, "label")


HOSTILE = {
    "nothing and the end": (b"", "is gone"),
    "half a header": (b"\x01\x00", "is gone"),
    "half a frame": (frame(DONE)[:-1], "is gone"),
    "a frame of four gigabytes": (b"\xff\xff\xff\xff", "sent 4294967295 bytes at once"),
    "noise": (bytes(range(1, 255)) * 40, "sent"),
    "an empty frame": (b"\x00\x00\x00\x00", "not of the protocol"),
    "no list": (frame()[:4] + b"\xc0", "not of the protocol"),
    "an empty list": (frame(), "says nothing"),
    "an unknown statement": (frame((99,)), "not of the protocol"),
    "a statement of an order": (frame({"handler": 0}), "not of the protocol"),
    "a text for a number": (frame(("Act", "1", "destroy"), DONE), "not of the protocol"),
    "nested deeply": ((100_000).to_bytes(4, "little") + b"\x91" * 100_000, "not of the protocol"),
    "an unknown verb": (frame(("Act", 0, "end"), DONE), "not of the protocol"),
    "done and on": (frame(DONE, NODE, DONE), "goes on when it is not its turn"),
    "no end": (frame(NODE), "sent no final statement"),
    "an unknown number": (frame(("Act", 7, "destroy"), DONE), "speaks of 7"),
    "a node where an endpoint belongs": (frame(NODE, ("Act", 1, "publish", None, b""), DONE), "speaks of 1"),
    "an endpoint of no node": (frame(endpoint("publisher"), DONE), "speaks of 1"),
    "a question to a node": (frame(NODE, ("Ask", 1, "matched")), "speaks of 1"),
    "a message from a subscription": (
        frame(NODE, endpoint("subscription"), ("Act", 2, "destroy", None, b"\0\1\0\0"), DONE),
        "asked for what cannot be",
    ),
    "a number for a message": (
        frame(NODE, endpoint("publisher"), ("Act", 2, "publish", 5), DONE),
        "asked for what cannot be",
    ),
    "an argument too few": (frame(NODE, endpoint("publisher"), ("Act", 2, "publish"), DONE), "cannot be"),
    "an unknown type": (frame(NODE, endpoint("publisher", "os/msg/System"), DONE), "There is no message"),
    "a path for a type": (frame(NODE, endpoint("service", "../x/srv/Y"), DONE), "There is no service"),
    "an unknown kind": (frame(NODE, endpoint("spy"), DONE), "not of the protocol"),
    "a depth of nothing": (frame(NODE, endpoint("publisher", qos={**QOS, "depth": 0}), DONE), "depth"),
    "an endless depth": (
        frame(NODE, endpoint("publisher", qos={**QOS, "depth": 2**64 - 1, "durability": 1}), DONE),
        "asked for what cannot be",
    ),
    "a message that is none": (
        frame(NODE, endpoint("publisher"), ("Act", 2, "publish", None, b"x"), DONE),
        "little-endian CDR",
    ),
    "a request that is none": (
        frame(
            NODE,
            endpoint("client", "std_srvs/srv/SetBool"),
            ("Act", 2, "send_request", None, b"\0\1\0\0"),
            DONE,
        ),
        "is not a",
    ),
    "an answer to nobody": (
        frame(
            NODE,
            endpoint("service", "std_srvs/srv/Trigger"),
            ("Act", 2, "send_response", (1, 1), serialize(Trigger.Response())),
            DONE,
        ),
        "has no request (1, 1) to answer",
    ),
    "a timer that goes back": (frame(NODE, ("MakeTimer", 2, 1, -1, "label"), DONE), "at least 0 ns"),
    "a reset of what is gone": (
        frame(NODE, ("MakeTimer", 2, 1, 10, "label"), ("Act", 2, "destroy"), ("Act", 2, "reset"), DONE),
        "speaks of 2",
    ),
    "a predicate that nobody waits for": (frame(("Wait", 5, 10)), "is gone"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_whatever_a_process_says_the_simulation_goes_on(case: str) -> None:
    said, expected = HOSTILE[case]
    world, quiet = World(), World()
    gateway, theirs = world.connect()
    with theirs:
        theirs.sendall(said)
        theirs.shutdown(socket.SHUT_WR)
        gateway.start()
        world.simulation.run_until(_S)
    world.pipe.close()
    quiet.simulation.run_until(_S)

    assert gateway.failure is not None
    assert expected in str(gateway.failure)
    assert world.simulation.node_names() == ["/server", "/talker"]
    assert len([event for event in world.listener.events if "/chatter" in str(event)]) == len(
        [event for event in quiet.listener.events if "/chatter" in str(event)]
    )


def test_a_process_that_says_nothing_has_failed_when_its_time_is_over() -> None:
    world = World()
    gateway, theirs = world.connect(limit_s=0.1)
    with theirs:
        gateway.start()
    world.pipe.close()
    assert str(gateway.failure) == "did not answer"


def test_a_process_that_never_stops_asking_has_failed_when_its_time_is_over() -> None:
    world = World()
    gateway, theirs = world.connect(limit_s=0.2)

    def ask() -> None:
        pipe = Pipe(theirs)
        with suppress(MiddlewareError):  # the simulation is gone
            while True:
                pipe.receive()
                pipe.send(msgspec.msgpack.encode([("Ask", 0, "nodes")]))

    thread = threading.Thread(target=ask)
    thread.start()
    gateway.start()
    world.pipe.close()
    thread.join()
    theirs.close()
    assert str(gateway.failure) in {"did not answer", "does not read"}
