"""Nodes with a lifecycle, as in `rclpy.lifecycle.node`."""

from collections.abc import Awaitable, Iterable
from typing import Final, TypeVar, Unpack

from sunset_ros.errors import MiddlewareError
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.lifecycle_msgs.msg import TransitionEvent
from sunset_ros.interfaces.lifecycle_msgs.srv import (
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from sunset_ros.lifecycle._state_machine import (
    STATES,
    TRANSITIONS,
    LifecycleState,
    StateMachine,
    Transition,
    TransitionCallbackReturn,
    state_message,
)
from sunset_ros.lifecycle.managed_entity import LifecyclePublisher, ManagedEntity
from sunset_ros.node import Node, NodeOptions
from sunset_ros.rmw.core.port import CallbackError, RequestId
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.service import Service
from sunset_ros.task import callback_name

MessageT = TypeVar("MessageT", bound=Message)

_CALLBACKS: Final = {
    "configuring": "on_configure",
    "cleaningup": "on_cleanup",
    "shuttingdown": "on_shutdown",
    "activating": "on_activate",
    "deactivating": "on_deactivate",
    "errorprocessing": "on_error",
}
"""Label of an intermediate state → name of the method that decides how it ends."""


class LifecycleNode(Node):
    """A node that others configure, activate, deactivate, clean up and shut down.

    Override `on_configure` and its like, and call the method of the base class, which calls the managed
    entities. A callback that raises counts as ERROR: `on_error` decides on the final state, and the exception then
    surfaces as a `CallbackError`.

    Unless `enable_communication_interface` is false, it offers the lifecycle services and `~/transition_event`.
    """

    def __init__(
        self, node_name: str, *, enable_communication_interface: bool = True, **options: Unpack[NodeOptions]
    ) -> None:
        super().__init__(node_name, **options)
        self._state_machine = StateMachine()
        self._managed_entities: dict[ManagedEntity, None] = {}
        self._transition_events = None
        if enable_communication_interface:
            self._transition_events = self.create_publisher(TransitionEvent, "~/transition_event", 10)
            self.create_service(
                ChangeState, "~/change_state", self._change_state, service_class=_ChangeStateService
            )
            self._create_queries()

    # Callbacks of transitions, which take the state before

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Configure the managed entities."""
        return self._call_entities("on_configure", state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Clean the managed entities up."""
        return self._call_entities("on_cleanup", state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Shut the managed entities down."""
        return self._call_entities("on_shutdown", state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Activate the managed entities."""
        return self._call_entities("on_activate", state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Deactivate the managed entities."""
        return self._call_entities("on_deactivate", state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Let the managed entities recover; SUCCESS leads to unconfigured, all else to finalized."""
        return self._call_entities("on_error", state)

    # Transitions that the node itself asks for

    def trigger_configure(self) -> TransitionCallbackReturn:
        """Go from unconfigured to inactive."""
        return self._trigger("configure")

    def trigger_cleanup(self) -> TransitionCallbackReturn:
        """Go from inactive to unconfigured."""
        return self._trigger("cleanup")

    def trigger_shutdown(self) -> TransitionCallbackReturn:
        """Go to finalized."""
        return self._trigger("shutdown")

    def trigger_activate(self) -> TransitionCallbackReturn:
        """Go from inactive to active."""
        return self._trigger("activate")

    def trigger_deactivate(self) -> TransitionCallbackReturn:
        """Go from active to inactive."""
        return self._trigger("deactivate")

    # Managed entities

    def add_managed_entity(self, entity: ManagedEntity) -> None:
        """Call an entity in the transitions of this node."""
        self._managed_entities[entity] = None

    def create_lifecycle_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: QoSProfile | int
    ) -> LifecyclePublisher[MessageT]:
        """Make a publisher that sends only while this node is active."""
        publisher = self.create_publisher(msg_type, topic, qos_profile, publisher_class=LifecyclePublisher)
        assert isinstance(publisher, LifecyclePublisher)  # noqa: S101  as asked
        self.add_managed_entity(publisher)
        return publisher

    def destroy_lifecycle_publisher(self, publisher: LifecyclePublisher[MessageT]) -> bool:
        """Take a publisher off the graph; return whether it was this node's."""
        self._managed_entities.pop(publisher, None)
        return self.destroy_publisher(publisher)

    # The machinery

    def _call_entities(self, name: str, state: LifecycleState) -> TransitionCallbackReturn:
        success = TransitionCallbackReturn.SUCCESS
        outcomes = (_checked(getattr(entity, name)(state)) for entity in list(self._managed_entities))
        return next((outcome for outcome in outcomes if outcome is not success), success)

    def _trigger(self, label: str) -> TransitionCallbackReturn:
        transition = self._state_machine.find(label)
        if transition is None:
            state = self._state_machine.state.label
            raise MiddlewareError(
                f"Node {self.get_fully_qualified_name()} is {state} and has no transition {label!r} from there."
            )
        return self._go_through(transition)

    def _go_through(self, transition: Transition) -> TransitionCallbackReturn:
        before = self._state_machine.state
        self._take(transition)
        errors: list[CallbackError] = []
        outcome = self._end_transition(before, errors)
        if outcome is TransitionCallbackReturn.ERROR:
            self._end_transition(before, errors)
        if errors:
            for second_error in errors[1:]:
                errors[0].add_note(f"Then: {second_error}")
            raise errors[0]
        return outcome

    def _end_transition(
        self, before: LifecycleState, errors: list[CallbackError]
    ) -> TransitionCallbackReturn:
        """Call the callback of an intermediate state, and leave the state as its outcome says."""
        callback = getattr(self, _CALLBACKS[self._state_machine.state.label])
        try:
            outcome = _checked(callback(before))
        except Exception as error:  # noqa: BLE001  whatever it is, `_go_through` raises it
            outcome = TransitionCallbackReturn.ERROR
            errors.append(CallbackError.of(self.get_fully_qualified_name(), callback_name(callback), error))
            errors[-1].__cause__ = error
        transition = self._state_machine.find(outcome.to_label())
        assert transition is not None  # noqa: S101  every intermediate state has all three
        self._take(transition)
        return outcome

    def _take(self, transition: Transition) -> None:
        self._state_machine.take(transition)
        if self._transition_events is not None and self._transition_events.handle.wanted:
            start, goal = state_message(transition.start), state_message(transition.goal)
            self._transition_events.publish(  # as rclpy's nodes do, it names only the states
                TransitionEvent(start_state=start, goal_state=goal)
            )

    # The services

    def _change_state(
        self, request: ChangeState.Request, response: ChangeState.Response
    ) -> ChangeState.Response | Awaitable[ChangeState.Response]:
        transition = self._state_machine.find(request.transition.label, request.transition.id)
        if transition is not None:
            response.success = self._go_through(transition) is TransitionCallbackReturn.SUCCESS
        return response

    def _create_queries(self) -> None:
        def get_state(*_: Message) -> Message:
            return GetState.Response(current_state=state_message(self._state_machine.state.state_id))

        def get_available_states(*_: Message) -> Message:
            return GetAvailableStates.Response(available_states=[state_message(number) for number in STATES])

        def get_available_transitions(*_: Message) -> Message:
            return _transitions_response(self._state_machine.available_transitions)

        def get_transition_graph(*_: Message) -> Message:
            return _transitions_response(TRANSITIONS)

        self.create_service(GetState, "~/get_state", get_state)
        self.create_service(GetAvailableStates, "~/get_available_states", get_available_states)
        for callback in (get_available_transitions, get_transition_graph):
            self.create_service(GetAvailableTransitions, f"~/{callback.__name__}", callback)


class _ChangeStateService(Service):
    """Answers also after an exception of a transition's callback, before the exception surfaces."""

    def _on_request(self, request_id: RequestId, request: Message) -> None:
        try:
            super()._on_request(request_id, request)
        except CallbackError:
            self.send_response(ChangeState.Response(success=False), request_id)
            raise


def _transitions_response(transitions: Iterable[Transition]) -> Message:
    return GetAvailableTransitions.Response(available_transitions=[each.to_msg() for each in transitions])


def _checked(outcome: object) -> TransitionCallbackReturn:
    if not isinstance(outcome, TransitionCallbackReturn):
        raise TypeError(f"a lifecycle callback must return a TransitionCallbackReturn, got {outcome!r}.")
    return outcome
