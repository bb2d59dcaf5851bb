"""Lifecycle nodes, as their own code sees them; what others see is tested by conformance."""

from typing import TYPE_CHECKING, Any

import pytest

from sunset_ros import CallbackError
from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition, TransitionEvent
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.lifecycle import (
    LifecycleNode,
    LifecycleState,
    ManagedEntity,
    Node,
    Publisher,
    State,
    TransitionCallbackReturn,
)
from sunset_ros.rmw.sim import Tap

if TYPE_CHECKING:
    from .conftest import World

SUCCESS = TransitionCallbackReturn.SUCCESS


class Managed(LifecycleNode):
    """Notes its transitions; raises where it is told to."""

    def __init__(self, fail: tuple[str, ...] = (), **options: Any) -> None:
        super().__init__("managed", **options)
        self.fail = fail
        self.seen: list[tuple[str, str]] = []

    @property
    def label(self) -> str:
        return self._state_machine.current_state[1]

    def note(self, name: str, state: LifecycleState) -> None:
        self.seen.append((name, state.label))
        if name in self.fail:
            raise ValueError(f"{name} failed")

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.note("configure", state)
        return super().on_configure(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.note("cleanup", state)
        return super().on_cleanup(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.note("activate", state)
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.note("deactivate", state)
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.note("shutdown", state)
        return super().on_shutdown(state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.note("error", state)
        return super().on_error(state)


class Forgetful(LifecycleNode):
    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        return None  # type: ignore[return-value]


def test_callbacks_are_told_the_state_before(world: "World") -> None:
    node = world.make(Managed)
    outcomes = [
        node.trigger_configure(),
        node.trigger_activate(),
        node.trigger_deactivate(),
        node.trigger_cleanup(),
        node.trigger_shutdown(),
    ]
    assert outcomes == [SUCCESS] * 5
    assert node.seen == [
        ("configure", "unconfigured"),
        ("activate", "inactive"),
        ("deactivate", "active"),
        ("cleanup", "inactive"),
        ("shutdown", "unconfigured"),
    ]
    assert node.label == "finalized"


def test_a_callback_that_raises_is_processed_as_an_error_and_comes_out(world: "World") -> None:
    node = world.make(Managed, fail=("activate",))
    node.trigger_configure()
    with pytest.raises(
        CallbackError, match=r"Callback Managed.on_activate of node /managed raised ValueError"
    ) as caught:
        node.trigger_activate()
    assert isinstance(caught.value.__cause__, ValueError)
    assert node.seen[-1] == ("error", "inactive")
    assert node.label == "unconfigured"


def test_when_error_processing_raises_too_the_node_is_finalized_and_both_come_out(world: "World") -> None:
    node = world.make(Managed, fail=("activate", "error"))
    node.trigger_configure()
    with pytest.raises(CallbackError, match="on_activate") as caught:
        node.trigger_activate()
    assert "Managed.on_error of node /managed raised ValueError: error failed" in caught.value.__notes__[0]
    assert node.label == "finalized"


def test_a_request_whose_callback_raises_is_answered_before_that_comes_out(world: "World") -> None:
    node = world.make(Managed, fail=("configure",))
    events: list[tuple[int, int]] = []

    class Listener(Tap):
        def on_message(self, time_ns: int, topic: str, name: str, message: Message) -> None:
            if isinstance(message, TransitionEvent):
                events.append((message.start_state.id, message.goal_state.id))

    world.simulation.add_tap(Listener())
    client = world.node("asker").create_client(ChangeState, "/managed/change_state")
    future = client.call_async(ChangeState.Request(transition=Transition(label="configure")))
    with pytest.raises(
        CallbackError, match=r"Callback Managed.on_configure of node /managed raised ValueError"
    ):
        world.pass_time(0.1)
    assert node.label == "unconfigured"
    world.pass_time(0.1)
    assert future.result() == ChangeState.Response(success=False)
    assert events == [(1, 10), (10, 15), (15, 1)]


def test_a_callback_must_return_how_it_went(world: "World") -> None:
    node = Forgetful("forgetful", context=world.context())
    with pytest.raises(
        CallbackError, match=r"on_configure .* must return a TransitionCallbackReturn, got None"
    ):
        node.trigger_configure()


def test_a_transition_that_does_not_leave_the_state_cannot_be_triggered(world: "World") -> None:
    node = world.make(Managed)
    with pytest.raises(
        MiddlewareError, match=r"Node /managed is unconfigured and has no transition 'activate'"
    ):
        node.trigger_activate()
    assert node.seen == []


def test_managed_entities_follow_and_may_refuse(world: "World") -> None:
    seen: list[str] = []

    class Entity(ManagedEntity):
        def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
            seen.append(state.label)
            return super().on_configure(state)

        def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
            return TransitionCallbackReturn.FAILURE

    node = world.make(Managed)
    node.add_managed_entity(Entity())
    assert node.trigger_configure() is SUCCESS
    assert node.trigger_activate() is TransitionCallbackReturn.FAILURE
    assert (seen, node.label) == (["unconfigured"], "inactive")


def test_a_lifecycle_publisher_drops_what_is_sent_while_inactive(world: "World") -> None:
    node = world.make(Managed)
    heard: list[Message] = []
    world.node("listener").create_subscription(String, "/work", heard.append, 10)
    publisher = node.create_lifecycle_publisher(String, "work", 10)
    states = []
    for trigger in (node.trigger_configure, node.trigger_activate, node.trigger_deactivate):
        trigger()
        states.append(publisher.is_activated)
        publisher.publish(String(data=node.label))
    world.pass_time(0.1)
    assert states == [False, True, False]
    assert heard == [String(data="active")]
    assert node.destroy_lifecycle_publisher(publisher)
    node.trigger_activate()
    assert node.count_publishers("/work") == 0


def test_the_communication_interface_can_be_left_out(world: "World") -> None:
    node = world.make(Managed, enable_communication_interface=False)
    names = [name for name, _ in node.get_service_names_and_types()]
    assert "/managed/change_state" not in names
    assert node.trigger_configure() is SUCCESS


def test_rclpys_short_names_are_there() -> None:
    assert (Node, State) == (LifecycleNode, LifecycleState)
    assert Publisher.__name__ == "LifecyclePublisher"
