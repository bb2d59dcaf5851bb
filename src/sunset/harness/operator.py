"""The node that starts the flight of a live system, and watches its nodes."""

from collections import deque
from dataclasses import dataclass
from functools import partial
from typing import Final, cast

from sunset.harness.node_process import NodeProcesses
from sunset.harness.supervisor import Conductor
from sunset.managing.symptoms import read_parameters
from sunset.nodes.base import call_later
from sunset.system import (
    BAG_PLAYER,
    BLACKBOARD_TOPIC,
    EVALUATION_TOPIC,
    RESULT_TOPIC,
    SENSOR_TOPICS,
    Rate,
    current_system,
    frequency_entry,
    state_entry,
)
from sunset.system_interfaces.msg import FrameEvaluation, SetBlackboardGroup
from sunset_ros.clock import Clock
from sunset_ros.context import Context
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.time import ClockType

_LONGEST: Final = 20


@dataclass(frozen=True)
class NodeStatus:
    """The state of a node.

    Attributes:
        name: its short name.
        state: its lifecycle state; `running` for nodes without a lifecycle; without a process, how it ended.
        pid: its process; None without a process.
        hertz: messages in the last second that it published; None where they are not counted.
    """

    name: str
    state: str
    pid: int | None
    hertz: float | None


class Operator(Conductor):
    """Starts the flight when the managed system is up, and after the warm-up injects a scenario's faults.

    Args:
        inject: whether there is a scenario.
        warm_up_s: time from the start of the flight to the injection.
        invites: whether `news` says when to start a managing system.
        context: the context of the process; the default one if None.
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
        self._states = {*map(state_entry, system.nodes)}
        self._injects = inject
        self._warm_up_s = warm_up_s
        self._blackboard: dict[str, object] = {}
        self._wall = Clock(clock_type=ClockType.STEADY_TIME, context=self.context)
        self._rates = {"monitor": Rate(), "evaluator": Rate()}
        self.create_subscription(SetBlackboardGroup, BLACKBOARD_TOPIC, self._on_blackboard, 10)
        self.create_subscription(FrameEvaluation, EVALUATION_TOPIC, partial(self._note, "evaluator"), 10)

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
        if node in self._rates:
            hertz = self._rates[node].frequency(self._wall.now_ns())
        return NodeStatus(node, state, pid, cast("float | None", hertz))

    def _note(self, node: str, message: Message) -> None:
        del message
        self._rates[node].note(self._wall.now_ns())

    def _on_blackboard(self, message: SetBlackboardGroup) -> None:
        self._note("monitor", message)
        for name, value in read_parameters(message.bb_params).items():
            # states are printed on a terminal, and anything may publish on this topic
            is_word = isinstance(value, str) and value.isalpha() and len(value) < _LONGEST
            is_frequency = name in self._outputs.values() and isinstance(value, float)
            if is_frequency or (name in self._states and is_word):
                self._blackboard[name] = value
        is_up = all(
            self._blackboard.get(state_entry(node))
            in {initial, "active"}  # a lifecycle manager may activate all
            for node, initial in self._initial_states.items()
        )
        if not self.up and is_up:
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
