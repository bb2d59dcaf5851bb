"""The outside observer: records every message, and every command that reached the managed system.

It listens at the middleware, not at any node, so that it does not depend on claims of the managing system.
"""

from collections.abc import Collection
from typing import Final, Protocol

from sunset.managing import ORACLE, Oracle
from sunset.metrics import Evidence
from sunset.recording.timelines import ROSOUT
from sunset.system import (
    COMMANDS_TOPIC,
    DIAGNOSE,
    DIAGNOSTICS_TOPIC,
    FAULT_ENDS_TOPIC,
    HARNESS,
    INFRASTRUCTURE,
    INJECTIONS_TOPIC,
    MANAGER_PROCESS,
    NAMESPACE,
    OFF_LIMITS_TOPICS,
    PARAMETER_EVENTS_TOPIC,
    PARAMETER_TOPICS,
    REPAIR,
    current_system,
    full_name,
    short_name,
)
from sunset.system_interfaces.msg import Command
from sunset.system_interfaces.srv import Redeploy
from sunset.texts.names import base_name, ros_text
from sunset_ros.exceptions import InvalidParameterTypeException
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray
from sunset_ros.interfaces.lifecycle_msgs.msg import TransitionEvent
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterEvent, ParameterValue
from sunset_ros.interfaces.rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    SetParameters,
    SetParametersAtomically,
)
from sunset_ros.interfaces.stamps import stamp_of
from sunset_ros.lifecycle import TRANSITIONS, TransitionCallbackReturn
from sunset_ros.parameter import parameter_value_to_python
from sunset_ros.rmw.core.port import EndpointKind, RequestId
from sunset_ros.rmw.core.tap import Tap
from sunset_ros.texts import shorten

_MOST_VIOLATIONS: Final = 20
_OWN_PREFIXES: Final = (f"{NAMESPACE}/", "/experiment/")
_TOPICS_OF_ALL: Final = frozenset({DIAGNOSTICS_TOPIC, *PARAMETER_TOPICS, ROSOUT})
"""Topics that every node may publish on."""
_OFF_LIMITS_SERVERS: Final = frozenset(f"/{node.name}" for node in HARNESS.values() if node.off_limits)
"""Nodes that a managing system must not call."""

_OUTCOMES: Final = {outcome.to_label() for outcome in TransitionCallbackReturn}
_REQUESTS: Final = [step for step in TRANSITIONS if step.label not in _OUTCOMES]
_LABELS: Final = {step.id: step.label for step in _REQUESTS}
_DURING: Final = {step.goal: step.label for step in _REQUESTS}
"""Id of the state that a node is in during a transition → the transition's label."""
_AFTER: Final = {
    step.start: step.goal for step in TRANSITIONS if step.label == TransitionCallbackReturn.SUCCESS.to_label()
}
"""Id of the state that a node is in during a transition → that of the state after it, if it succeeds."""


def shown_topics(manager: str) -> frozenset[str]:
    """Return the topics with the truth that a managing system may read: none, unless it is the oracle."""
    return frozenset({INJECTIONS_TOPIC, FAULT_ENDS_TOPIC}) if manager == ORACLE else frozenset()


class Sink(Protocol):
    """The target of the observer."""

    def write(self, topic: str, time_ns: int, message: Message) -> None:
        """Keep a message."""


class Observer(Tap):
    """Writes all messages to a sink as they leave their publishers, and turns requests to managed nodes into commands.

    The managing system's node may read the topics with the truth that are `shown`; others must not. `viewers` are full
    names of nodes that may subscribe to everything, but not publish or call. Adaptations break a rule if the task is to
    diagnose.
    """

    def __init__(
        self, sink: Sink, *, shown: Collection[str] = (), viewers: Collection[str] = (), task: str = REPAIR
    ) -> None:
        self._task = task
        self._sink = sink
        self._shown = shown
        self.viewers = viewers
        self._system = current_system()
        self._outputs = {
            full_name(node.name): {*map(full_name, node.outputs)} for node in self._system.nodes.values()
        }
        self._own_services = tuple(f"{node}/" for node in sorted(self._system.all_nodes))
        self._pending: dict[tuple[str, RequestId], Command] = {}
        """Requests that are not answered yet, including those of the experiment's own clients."""
        self.evidence: Evidence = "symptoms"
        """The evidence of the managing system: images, if one of its nodes subscribed to them."""
        self.commands = 0
        """How many requests of the managing system reached the managed system."""
        self._violations: dict[str, None] = {}

    @property
    def violations(self) -> list[str]:
        """The rules that the managing system broke, in words: the first 20 in order, and how many more."""
        first, further = [*self._violations][:_MOST_VIOLATIONS], len(self._violations) - _MOST_VIOLATIONS
        return first if further <= 0 else [*first, f"and {further} more violations"]

    def note(self, violation: str) -> None:
        """Note a violation."""
        self._violations[shorten(violation)] = None

    def on_node(self, process: str, node: str) -> None:
        """Note nodes of the managing system with the name of a system's node, and restarted nodes."""
        for command in self._pending.values():
            if command.node == node and command.kind != "redeploy":  # which the launcher answers
                command.reason = command.reason or "the node ended"  # transitions of the new node are not its
        if node not in self._system.all_nodes:
            return
        if process == MANAGER_PROCESS or (process in self._system.nodes and node != full_name(process)):
            who = "the managing system" if process == MANAGER_PROCESS else f"the process of {process}"
            self.note(f"{who} has a node {node}, which is a name of the system's")

    def on_endpoint(self, node: str, kind: EndpointKind, name: str) -> None:
        """Note endpoints that break a rule.

        Only a sensor's own readers may subscribe to its topic. Managed nodes may subscribe only to topics of the
        managed system. Other nodes must not subscribe to a topic with the truth, or offer a service of the system.
        """
        subscribes = kind is EndpointKind.SUBSCRIPTION
        if subscribes and node in self.viewers:
            return
        readers = self._system.sensors.get(name, {node})
        if subscribes and node not in {*readers, "/monitor"}:
            self.note(f"{node} subscribes to {name}, which only {' and '.join(sorted(readers))} may")
        elif subscribes and node in self._system.managed_nodes and not self._may_feed(name):
            self.note(f"{node} subscribes to {name}, on which the managed system does not publish")
        if node in self._system.all_nodes:
            return
        if subscribes and name in {*self._system.publishers, *HARNESS["image_views"].outputs}:
            self.evidence = "images"
        is_shown = node == f"/{Oracle.node_name}" and name in self._shown
        if subscribes and name in OFF_LIMITS_TOPICS and not is_shown:
            self.note(f"{node} subscribes to {name}, which carries the truth")
        if kind is EndpointKind.SERVICE and name.startswith(self._own_services):
            self.note(f"{node} offers {name}, which belongs to the system")

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        """Record a message that leaves its publisher, unless it is forged.

        A managed node publishes only on the topics of its description, and other nodes not on the system's topics.
        """
        is_shared = topic == DIAGNOSTICS_TOPIC and isinstance(message, DiagnosticArray)
        is_own = not is_shared and (topic in self._system.own_topics or topic.startswith(_OWN_PREFIXES))
        if self._is_forged(topic, node, message):
            self.note(f"{node} publishes on {topic} in the name of another node")
        elif node in self.viewers and topic not in _TOPICS_OF_ALL:
            self.note(f"{node} publishes on {topic}, and was said to be a viewer")
        elif is_own and node not in self._system.all_nodes:
            self.note(f"{node} publishes on {topic}, which belongs to the experiment")
        elif not self._may_publish(node, topic):
            self.note(f"{node} publishes on {topic}, which is not among the outputs of its description")
        else:
            self._sink.write(topic, time_ns, message)
            if isinstance(message, TransitionEvent) and topic == f"{node}/transition_event":
                self._note_transition(node, message)

    def _is_forged(self, topic: str, node: str, message: Message) -> bool:
        """Return whether a message on a topic that all nodes share names another node as its sender."""
        if topic == PARAMETER_EVENTS_TOPIC and isinstance(message, ParameterEvent):
            return message.node != node
        if topic == DIAGNOSTICS_TOPIC and isinstance(message, DiagnosticArray):
            pairs = ((status.hardware_id, status.name.split(":")[0]) for status in message.status)
            names = {base_name(name) for pair in pairs for name in pair} - {short_name(node)}
            return bool(names & {*self._system.nodes})
        return False

    def on_request(  # noqa: PLR0917  as of Tap
        self, time_ns: int, service: str, client: str, server: str, request: Message, request_id: RequestId
    ) -> None:
        """Note a request that reached its server."""
        if client in INFRASTRUCTURE and not isinstance(request, ChangeState.Request):
            return
        if server in _OFF_LIMITS_SERVERS and client not in self._system.all_nodes:
            self.note(f"{client} calls {service}, which belongs to the experiment")
        if server in self._system.all_nodes and client in self.viewers:
            self.note(f"{client} calls {service}, and was said to be a viewer")
        if server not in self._system.managed_nodes and server != "/launcher":
            return
        command = _command_of(server, request)
        self._note_violations(client, server, request)
        if command is None:
            return
        if self._task == DIAGNOSE and client not in INFRASTRUCTURE:
            self.note(f"{client} calls {service}, and the task is to diagnose, without adaptations")
        command.stamp, command.client, command.service = stamp_of(time_ns), client, service
        self.commands += client not in INFRASTRUCTURE
        self._pending[service, request_id] = command

    def on_response(
        self, time_ns: int, service: str, server: str, response: Message, request_id: RequestId
    ) -> None:
        """Complete the command of this response, and record it."""
        del server
        command = self._pending.pop((service, request_id), None)
        if command is not None:
            command.successful, command.reason = _outcome(response)
            if isinstance(response, SetParameters.Response) and command.successful:  # each is set separately
                _keep_accepted(command, response)
            self._write(time_ns, command)

    def finish(self, time_ns: int) -> None:
        """Record the commands that were never answered, as unsuccessful unless their transition was observed."""
        for command in self._pending.values():
            command.reason = "not answered, but done" if command.successful else "never answered"
            self._write(time_ns, command)
        self._pending.clear()

    def _write(self, time_ns: int, command: Command) -> None:
        if command.client not in INFRASTRUCTURE:
            self._sink.write(COMMANDS_TOPIC, time_ns, command)

    def _note_transition(self, node: str, event: TransitionEvent) -> None:
        """Assign a transition's outcome to the oldest open command for it.

        If the experiment itself has requested the transition too, the outcome belongs to the experiment.
        """
        during = event.start_state.id
        asked = [
            command
            for command in self._pending.values()
            if (command.node, command.kind, command.reason) == (node, _DURING.get(during), "")
        ]
        if asked:
            command = min(asked, key=lambda command: command.client not in INFRASTRUCTURE)
            command.successful = event.goal_state.id == _AFTER[during]
            command.reason = "not answered"

    def _may_publish(self, node: str, topic: str) -> bool:
        """Return whether a node may publish on a topic: a managed node only on its description's outputs."""
        if topic in _TOPICS_OF_ALL or topic == f"{node}/transition_event":
            return True
        return topic in self._outputs.get(node, {topic})

    def _may_feed(self, topic: str) -> bool:
        """Return whether a managed node may subscribe to a topic: not of the managing system, and not the truth."""
        is_own = topic in {*self._system.own_topics, PARAMETER_EVENTS_TOPIC}
        return topic not in OFF_LIMITS_TOPICS and (is_own or topic.startswith(f"{NAMESPACE}/"))

    def _note_violations(self, client: str, server: str, request: Message) -> None:
        if isinstance(request, SetParameters.Request | SetParametersAtomically.Request):
            verb, names = "sets", [parameter.name for parameter in request.parameters]
        elif isinstance(request, GetParameters.Request | DescribeParameters.Request):
            verb, names = "reads", list(request.names)
        else:
            return
        for name in names:
            if (server, name) in self._system.fault_parameters:
                self.note(f"{client} {verb} the fault parameter {name} of {server}")
            elif name == "use_sim_time" and verb == "sets":
                # if its clock jumps, a redeployed node need not boot
                self.note(f"{client} sets {name} of {server}, which belongs to the experiment")
            elif name == "seed" and server.startswith(_OWN_PREFIXES):  # the run's might be derived from it
                self.note(f"{client} {verb} the {name} of {server}, which belongs to the experiment")


def _command_of(server: str, request: Message) -> Command | None:
    if isinstance(request, SetParameters.Request | SetParametersAtomically.Request):
        return Command(
            node=server,
            kind="set_parameters",
            parameters=[parameter.name for parameter in request.parameters],
            values=[_text(parameter.value) for parameter in request.parameters],
        )
    if isinstance(request, ChangeState.Request):
        label = request.transition.label or _LABELS.get(request.transition.id, "unknown")
        return Command(node=server, kind=label)
    if isinstance(request, Redeploy.Request):
        return Command(node=full_name(base_name(request.node)), kind="redeploy")
    return None


def _outcome(response: Message) -> tuple[bool, str]:
    if isinstance(response, SetParameters.Response):
        refusals = [result.reason for result in response.results if not result.successful]
        return len(refusals) < len(response.results), "; ".join(refusals)
    if isinstance(response, SetParametersAtomically.Response):
        return response.result.successful, response.result.reason
    if isinstance(response, ChangeState.Response):
        return response.success, "" if response.success else "transition refused"
    if isinstance(response, Redeploy.Response):
        return response.success, response.message
    raise TypeError(f"A command was answered with {type(response).__name__}.")


def _keep_accepted(command: Command, response: SetParameters.Response) -> None:
    """Keep only those parameters in a command that the node has accepted."""
    # a foreign node may answer less
    triples = zip(command.parameters, command.values, response.results, strict=False)
    kept = [(name, value) for name, value, result in triples if result.successful]
    command.parameters, command.values = [name for name, _ in kept], [value for _, value in kept]


def _text(message: ParameterValue) -> str:
    """Return a parameter's value as text, as in YAML; `unset` for a type that ROS does not know."""
    try:
        value = parameter_value_to_python(message)
    except InvalidParameterTypeException:  # the node refuses it too; here it is only described
        value = None
    return "unset" if value is None else shorten(ros_text(value))
