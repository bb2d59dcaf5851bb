"""The node that starts the flight of a live system, and watches its nodes."""

from collections import deque
from dataclasses import dataclass
from typing import cast

from sunset.harness.node_process import NodeProcesses
from sunset.harness.supervisor import Conductor
from sunset.managing.symptoms import read_parameters
from sunset.nodes.base import call_later
from sunset.system import (
    BAG_PLAYER,
    BLACKBOARD_TOPIC,
    RESULT_TOPIC,
    SENSOR_TOPICS,
    current_system,
    frequency_entry,
    state_entry,
)
from sunset.system_interfaces.msg import SetBlackboardGroup
from sunset_ros.context import Context
from sunset_ros.interfaces.std_srvs.srv import Trigger


@dataclass(frozen=True)
class NodeStatus:
    """The state of a node."""

    name: str
    state: str
    """Its lifecycle state; `running` for nodes without a lifecycle; without a process, how it ended."""
    pid: int | None
    hertz: float | None
    """Messages in the last second that it published; None where they are not counted."""


class Operator(Conductor):
    """Starts the flight when the managed system is up, and if `inject`, injects a scenario's faults after the warm-up.

    If it `invites`, `news` says when to start a managing system.
    """

    def __init__(
        self, *, inject: bool, warm_up_s: float, invites: bool = False, context: Context | None = None
    ) -> None:
        super().__init__("operator", context=context)
        self.up = False
        """Whether all managed nodes were in their initial states once."""
        self.news: deque[str] = deque()
        """Sentences for the user, until the caller takes them out."""
        self._invites = invites
        system = current_system()
        self._initial_states = system.initial_states
        self._outputs = {
            node.name: frequency_entry(node.outputs[0]) for node in system.nodes.values() if node.outputs
        }
        self._outputs[BAG_PLAYER] = frequency_entry(SENSOR_TOPICS[0])
        self._injects = inject
        self._warm_up_s = warm_up_s
        self._blackboard: dict[str, object] = {}
        self.create_subscription(SetBlackboardGroup, BLACKBOARD_TOPIC, self._on_blackboard, 10)

    def status(self, processes: NodeProcesses) -> list[NodeStatus]:
        """Return the states of all nodes."""
        return [self._status_of(node, processes) for node in processes.nodes]

    def _status_of(self, node: str, processes: NodeProcesses) -> NodeStatus:
        pid, state = processes.pid(node), "running"
        if node in self._initial_states:
            state = str(self._blackboard.get(state_entry(node), "starting"))
        if pid is None and state in {"running", "starting", "unknown"}:  # else another program has started it
            state = processes.end_of(node)
        hertz = self._blackboard.get(self._outputs.get(node, ""))
        return NodeStatus(node, state, pid, cast("float | None", hertz))

    def _on_blackboard(self, message: SetBlackboardGroup) -> None:
        self._blackboard |= read_parameters(message.bb_params)
        states = {node: self._blackboard.get(state_entry(node)) for node in self._initial_states}
        # a lifecycle manager may activate all
        is_up = all(states[node] in {initial, "active"} for node, initial in self._initial_states.items())
        if is_up and not self.up:
            self.up = True
            self.news.append("All nodes are up.")
            self.start_flight(self._on_flying)
        if self._invites and self._blackboard.get(frequency_entry(RESULT_TOPIC)):
            self._invites = False
            self.news.append("The system is up; start your managing system now.")

    def _on_flying(self, response: Trigger.Response) -> None:
        done = "The flight has begun" if response.success else "Starting the flight failed"
        self.news.append(f"{done}: {response.message}")
        if self._injects:
            call_later(self, self._warm_up_s, lambda: self.inject(self._on_injected))

    def _on_injected(self, response: Trigger.Response) -> None:
        done = "The faults are injected" if response.success else "Injecting the faults failed"
        self.news.append(f"{done}: {response.message}")
