import pytest

from sunset_ros import CallbackError, Node
from sunset_ros.context import get_default_context
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.testing import World


class Talker(Node):
    """A node as for rclpy: it takes no context."""

    def __init__(self, text: str) -> None:
        super().__init__("talker")
        self.publisher = self.create_publisher(String, "chatter", 10)
        self.create_timer(1.0, lambda: self.publisher.publish(String(data=text)))


def test_nodes_of_a_world_are_processes_of_their_own_and_their_messages_are_recorded() -> None:
    world = World(latency_s=0.25)
    first, second = (
        world.start(Talker, "a"),
        world.start(Talker, text="b", args=["--ros-args", "-r", "__ns:=/x"]),
    )
    received: list[tuple[float, str]] = []
    listener = world.start(Node, "listener")
    listener.create_subscription(String, "/chatter", lambda text: received.append((world.now, text.data)), 10)

    world.run(2.5)

    assert first.context is not second.context
    assert [text.data for text in world.messages("/chatter")] == ["a", "a"]
    assert [text.data for text in world.messages("/x/chatter")] == ["b", "b"]
    assert [text for _, text in received] == ["a", "a"]
    assert [time for time, _ in received] == pytest.approx([1.25, 2.25], abs=0.001)
    assert world.now == 2.5
    assert not get_default_context().ok()


def test_an_exception_of_a_callback_ends_the_test() -> None:
    world = World()
    node = world.start(Node, "broken")
    node.create_timer(1.0, lambda: int("x"))

    with pytest.raises(CallbackError, match=r"node /broken raised ValueError: invalid literal"):
        world.run(2.0)
