"""The node that conducts one experiment: bring-up, warm-up, injection, end; and the base of nodes that conduct."""

from collections.abc import Callable
from enum import Enum
from typing import Final

from sunset.errors import ScenarioError
from sunset.nodes.base import call_later
from sunset.system import (
    DIAGNOSTICS_TOPIC,
    EXPERIMENT,
    LOG_TOPIC,
    NAMESPACE,
    SENSOR_TOPICS,
    SILENCE_S,
    current_system,
    full_name,
)
from sunset.system_interfaces.msg import ExperimentLogging
from sunset_ros.client import Client
from sunset_ros.context import Context
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.node import Node

_SILENT_NS: Final = round(SILENCE_S * 10**9)
"""Time since its last heartbeat after which a node may have ended."""


Answered = Callable[[Trigger.Response], None]


class Conductor(Node):
    """Asks the bag player to start and the scenario executor to inject, when a subclass says so."""

    def __init__(self, name: str, *, context: Context | None = None) -> None:
        super().__init__(name, context=context)
        self._player = self.create_client(Trigger, "/bag_player/start")
        self._injector = self.create_client(Trigger, "/scenario_executor/inject")

    def start_flight(self, done: Answered) -> None:
        """Start the flight; `done` gets the bag player's response."""
        self._ask(self._player, done)

    def inject(self, done: Answered) -> None:
        """Inject the faults; `done` gets the scenario executor's response."""
        self._ask(self._injector, done)

    @staticmethod
    def _ask(client: Client[Trigger.Request, Trigger.Response], done: Answered) -> None:
        future = client.call_async(Trigger.Request())
        future.add_done_callback(lambda future: done(future.result() or Trigger.Response(message="no reply")))


class Phase(Enum):
    """The phase of an experiment."""

    BRING_UP = "bring-up"
    WARM_UP = "warm-up"
    MEASURED = "measured"
    OVER = "over"


class Supervisor(Conductor):
    """Waits until the managed system is up, starts the flight, injects the faults, and ends the experiment.

    It logs `start` (time 0 of the measured time) and `end` on `/experiment/log`. The flight waits until `ready` says
    that it need not.
    """

    def __init__(
        self,
        scenario: str,
        *,
        warm_up_s: float,
        duration_s: float,
        ready: Callable[[], bool] = lambda: True,
        context: Context | None = None,
    ) -> None:
        super().__init__(EXPERIMENT, context=context)
        self.phase = Phase.BRING_UP
        self.start_ns: int | None = None
        """The time of the injection, nanoseconds of the node's clock; None before it."""
        self.injection_problem = ""
        """Why the faults were not injected as written; empty where they were."""
        self._scenario = scenario
        self._warm_up_s = warm_up_s
        self._duration_s = duration_s
        self._ready = ready
        self._initial_states = current_system().initial_states
        self._heard: dict[str, tuple[str, int]] = {}
        self.log = self.create_publisher(ExperimentLogging, LOG_TOPIC, 10)
        """The publisher of `start` and `end`."""
        self._diagnostics = self.create_subscription(
            DiagnosticArray, DIAGNOSTICS_TOPIC, self._on_diagnostics, 50
        )

    @property
    def missing(self) -> dict[str, str]:
        """The managed nodes that differ from their description, and their states."""
        states = {node: (self._state_of(node), initial) for node, initial in self._initial_states.items()}
        missing = {node: state for node, (state, initial) in states.items() if state != initial}
        if missing:
            return missing
        active = [node for node, state in self._initial_states.items() if state == "active"]
        differences = {node: self._difference(node) for node in active}
        return {node: f"active, but {difference}" for node, difference in differences.items() if difference}

    def _difference(self, node: str) -> str:
        system = current_system()
        described = system.nodes[node]
        watched = {full_name(topic.name): topic for topic in system.topics.values()}
        published = dict(self.get_publisher_names_and_types_by_node(node, NAMESPACE))
        for topic in map(full_name, described.outputs):
            if topic not in published:
                return f"does not publish on {topic}"
            if topic in watched and watched[topic].message_type not in published[topic]:
                return (
                    f"publishes {published[topic][0]} on {topic}, described as {watched[topic].message_type}"
                )
        heard = {topic for topic, _ in self.get_subscriber_names_and_types_by_node(node, NAMESPACE)}
        others = heard.intersection({*system.publishers, *SENSOR_TOPICS}) - system.inputs[node]
        if others:
            return f"subscribes to {min(others)}, which is not among its inputs"
        lacking = set(map(full_name, described.inputs)) - heard
        if lacking and node not in {other for other, _ in system.topic_parameters}:
            return f"does not subscribe to {min(lacking)}, which is among its inputs"
        return ""

    def _state_of(self, node: str) -> str:
        state, heard_ns = self._heard.get(node, ("unseen", 0))
        is_silent = heard_ns and self.get_clock().now().nanoseconds - heard_ns > _SILENT_NS
        return "silent" if is_silent else state

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        now_ns = self.get_clock().now().nanoseconds
        for status in message.status:
            self._heard[status.hardware_id] = status.message, now_ns
        if self.phase is Phase.BRING_UP and not self.missing and self._ready():
            self.phase = Phase.WARM_UP
            self.destroy_subscription(self._diagnostics)
            self.start_flight(self._on_flying)

    def _on_flying(self, response: Trigger.Response) -> None:
        if not response.success:
            raise ScenarioError(f"The bag player did not start: {response.message}.")
        call_later(self, self._warm_up_s, self._inject)

    def _inject(self) -> None:
        self.phase = Phase.MEASURED
        self.start_ns = self.get_clock().now().nanoseconds
        self._note("start")
        self.inject(self._on_injected)
        call_later(self, self._duration_s, self._end)

    def _on_injected(self, response: Trigger.Response) -> None:
        if not response.success:
            reason = response.message.rstrip(".")
            self.injection_problem = (
                f"the scenario {self._scenario} could not be injected as written: {reason}"
            )

    def _end(self) -> None:
        self.phase = Phase.OVER
        self._note("end")

    def _note(self, name: str) -> None:
        now = self.get_clock().now().nanoseconds
        self.log.publish(
            ExperimentLogging(timestamp=now, scenario=self._scenario, source=EXPERIMENT, rule_name=name)
        )
