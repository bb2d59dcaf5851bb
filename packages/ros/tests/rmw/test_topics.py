import numpy as np
import pytest

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header, String
from sunset_ros.rmw.core.node import NodeHandle
from sunset_ros.rmw.core.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from sunset_ros.rmw.sim import Simulation, Tap

MS = 1_000_000
BEST_EFFORT = QoSProfile(reliability=ReliabilityPolicy.BEST_EFFORT)
RELIABLE = QoSProfile()
LATCHED = QoSProfile(depth=2, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def node_of(sim: Simulation, name: str) -> NodeHandle:
    process = sim.create_process(name)
    node = process.create_node(name, "/")
    node.attach()
    process.run()
    return node


def listen(node: NodeHandle, seen: list[Message], qos: QoSProfile, kind: type[Message] = String) -> None:
    node.create_subscription(kind, "/chat", qos, seen.append, label="listener")


@pytest.mark.parametrize(
    ("offered", "requested", "arrives"),
    [
        (RELIABLE, RELIABLE, True),
        (RELIABLE, BEST_EFFORT, True),
        (BEST_EFFORT, BEST_EFFORT, True),
        (BEST_EFFORT, RELIABLE, False),
        (LATCHED, RELIABLE, True),
        (RELIABLE, LATCHED, False),
    ],
)
@pytest.mark.parametrize("publisher_first", [True, False])
def test_messages_arrive_where_qos_matches(
    offered: QoSProfile, requested: QoSProfile, arrives: bool, publisher_first: bool
) -> None:
    sim = Simulation()
    talker, listener = node_of(sim, "talker"), node_of(sim, "listener")
    seen: list[Message] = []
    if not publisher_first:
        listen(listener, seen, requested)
    publisher = talker.create_publisher(String, "/chat", offered)
    if publisher_first:
        listen(listener, seen, requested)
    publisher.publish(String(data="x"))
    sim.run_until(10 * MS)
    assert len(seen) == publisher.matched == int(arrives)


def test_types_must_be_equal() -> None:
    sim = Simulation()
    seen: list[Message] = []
    listen(node_of(sim, "listener"), seen, RELIABLE, Header)
    publisher = node_of(sim, "talker").create_publisher(String, "/chat", RELIABLE)
    publisher.publish(String())
    sim.run_until(10 * MS)
    assert (seen, publisher.matched) == ([], 0)


def test_a_late_reader_gets_what_a_transient_local_writer_keeps() -> None:
    sim = Simulation()
    publisher = node_of(sim, "talker").create_publisher(String, "/chat", LATCHED)
    for number in range(4):
        publisher.publish(String(data=str(number)))
    sim.run_until(10 * MS)
    latched: list[Message] = []
    volatile: list[Message] = []
    listen(node_of(sim, "latched"), latched, LATCHED)
    listen(node_of(sim, "volatile"), volatile, RELIABLE)
    publisher.publish(String(data="new"))
    sim.run_until(20 * MS)
    assert latched == [String(data="2"), String(data="3"), String(data="new")]
    assert volatile == [String(data="new")]


def test_what_was_kept_for_a_late_reader_takes_the_latency_too() -> None:
    sim = Simulation(latency_s=0.005)
    node_of(sim, "talker").create_publisher(String, "/chat", LATCHED).publish(String(data="kept"))
    sim.run_until(10 * MS)
    seen: list[Message] = []
    listen(node_of(sim, "late"), seen, LATCHED)
    sim.run_until(15 * MS - 1)
    assert seen == []
    sim.run_until(15 * MS)
    assert seen == [String(data="kept")]


def test_a_late_reader_does_not_get_what_is_older_than_the_lifespan() -> None:
    sim = Simulation()
    qos = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL, lifespan_ns=100 * MS)
    publisher = node_of(sim, "talker").create_publisher(String, "/chat", qos)
    for time in (0, 50, 100):
        sim.call_at(time * MS, lambda: publisher.publish(String(data=str(sim.now // MS))))
    sim.run_until(150 * MS)
    seen: list[Message] = []
    listen(node_of(sim, "listener"), seen, qos)
    sim.run_until(200 * MS)
    assert seen == [String(data="50"), String(data="100")]


def test_keep_all_drops_nothing() -> None:
    sim = Simulation(compute={"/listener": 0.1})
    seen: list[Message] = []
    listen(node_of(sim, "listener"), seen, QoSProfile(history=HistoryPolicy.KEEP_ALL))
    publisher = node_of(sim, "talker").create_publisher(String, "/chat", RELIABLE)
    for number in range(50):
        publisher.publish(String(data=str(number)))
    sim.run_until(10_000 * MS)
    assert seen == [String(data=str(number)) for number in range(50)]


def test_writer_and_readers_do_not_see_each_others_changes() -> None:
    sim = Simulation()
    kept: list[Message] = []

    class Keeper(Tap):
        def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
            kept.append(message)

    sim.add_tap(Keeper())
    seen: list[str] = []

    def spoil(message: Message) -> None:
        assert isinstance(message, Image)
        seen.append(message.header.frame_id)
        message.header.frame_id = "spoilt"

    for name in ("first", "second"):
        node_of(sim, name).create_subscription(Image, "/image", RELIABLE, spoil, label="spoil")
    image = Image(header=Header(frame_id="camera"))
    node_of(sim, "talker").create_publisher(Image, "/image", RELIABLE).publish(image)
    image.header.frame_id = "changed"
    sim.run_until(10 * MS)
    assert seen == ["camera", "camera"]
    assert isinstance(kept[0], Image)
    assert kept[0].header.frame_id == "camera"


def test_arrays_are_shared_and_read_only() -> None:
    sim = Simulation()
    seen: list[Message] = []
    node_of(sim, "listener").create_subscription(Image, "/image", RELIABLE, seen.append, label="listener")
    pixels = np.arange(10, dtype=np.uint8)
    node_of(sim, "talker").create_publisher(Image, "/image", RELIABLE).publish(Image(data=pixels))
    sim.run_until(10 * MS)
    (image,) = seen
    assert isinstance(image, Image)
    assert np.shares_memory(image.data, pixels)
    with pytest.raises(ValueError, match="read-only"):
        image.data[0] = 1


def test_a_publisher_is_wanted_while_somebody_would_get_its_messages() -> None:
    sim = Simulation()
    talker, listener = node_of(sim, "talker"), node_of(sim, "listener")
    publisher = talker.create_publisher(String, "/chat", RELIABLE)
    wanted = [publisher.wanted]
    subscription = listener.create_subscription(String, "/chat", RELIABLE, print, label="print")
    wanted.append(publisher.wanted)
    assert subscription.matched == 1
    subscription.destroy()
    wanted.append(publisher.wanted)
    sim.add_tap(Tap())
    wanted.append(publisher.wanted)
    assert wanted == [False, True, False, True]


def test_a_transient_local_publisher_is_wanted_by_those_who_may_come() -> None:
    publisher = node_of(Simulation(), "talker").create_publisher(String, "/latched", LATCHED)
    assert publisher.wanted


def test_a_destroyed_publisher_sends_nothing_more_but_what_it_sent_arrives() -> None:
    sim = Simulation()
    talker, listener = node_of(sim, "talker"), node_of(sim, "listener")
    seen: list[Message] = []
    listen(listener, seen, RELIABLE)
    publisher = talker.create_publisher(String, "/chat", RELIABLE)
    publisher.publish(String(data="x"))
    publisher.destroy()
    publisher.destroy()
    with pytest.raises(MiddlewareError, match=r"Node /talker cannot publish on /chat: it was destroyed"):
        publisher.publish(String())
    sim.run_until(10 * MS)
    assert seen == [String(data="x")]


def test_what_a_callback_publishes_leaves_even_if_it_destroys_the_publisher() -> None:
    sim = Simulation()
    talker, listener = node_of(sim, "talker"), node_of(sim, "listener")
    seen: list[Message] = []
    listen(listener, seen, RELIABLE)
    publisher = talker.create_publisher(String, "/chat", RELIABLE)

    def say_and_leave() -> None:
        publisher.publish(String(data="x"))
        publisher.destroy()

    talker.post(say_and_leave, label="say_and_leave")
    sim.run_until(10 * MS)
    assert seen == [String(data="x")]
    assert publisher.matched == 0


def test_a_destroyed_subscription_gets_nothing_more() -> None:
    sim = Simulation()
    talker, listener = node_of(sim, "talker"), node_of(sim, "listener")
    seen: list[Message] = []
    subscription = listener.create_subscription(String, "/chat", RELIABLE, seen.append, label="listener")
    publisher = talker.create_publisher(String, "/chat", RELIABLE)
    publisher.publish(String(data="on its way"))
    subscription.destroy()
    sim.run_until(10 * MS)
    assert seen == []
    assert publisher.matched == 0
