"""The node that conducts one experiment: bring-up, warm-up, injection, end."""

from collections.abc import Callable
from enum import Enum
from typing import Final

from sunset.errors import ScenarioError
from sunset.experiments.spec import Timing
from sunset.interfaces.diagnostic_msgs.msg import DiagnosticArray
from sunset.interfaces.std_srvs.srv import Trigger
from sunset.interfaces.system_interfaces.msg import ExperimentLogging
from sunset.ros.context import Context
from sunset.ros.node import Node
from sunset.ros.task import Future
from sunset.system import current_system

__all__ = ["Phase", "Supervisor"]

_SILENT_NS: Final = 10**9
"""Since its last heartbeat: after so long a node may have ended."""


class Phase(Enum):
    """Where an experiment is."""

    BRING_UP = "bring-up"
    WARM_UP = "warm-up"
    MEASURED = "measured"
    OVER = "over"


class Supervisor(Node):
    """Waits until the managed system is up, starts the flight, injects the faults, and calls time.

    It logs `start` (the moment that all times are counted from) and `end` on `/experiment/log`.

    Args:
        scenario: the scenario's name.
        timing: the clockwork of the experiment.
        ready: whether all else is there that the flight should wait for.
        context: the context of the process; the default one if None.
    """

    def __init__(
        self,
        scenario: str,
        timing: Timing,
        *,
        ready: Callable[[], bool] = lambda: True,
        context: Context | None = None,
    ) -> None:
        super().__init__("experiment", context=context)
        self.phase = Phase.BRING_UP
        self.start_ns: int | None = None
        """The time of the injection, nanoseconds of the node's clock; None before it."""
        self.injection_problem = ""
        """Why the faults were not injected as written; empty where they were."""
        self._scenario = scenario
        self.timing = timing
        """The clockwork of the experiment."""
        self._ready = ready
        self._initial_states = current_system().initial_states
        self._heard: dict[str, tuple[str, int]] = {}
        self._log = self.create_publisher(ExperimentLogging, "/experiment/log", 10)
        self._player = self.create_client(Trigger, "/bag_player/start")
        self._injector = self.create_client(Trigger, "/scenario_executor/inject")
        self._diagnostics = self.create_subscription(
            DiagnosticArray, "/diagnostics", self._on_diagnostics, 50
        )

    @property
    def missing(self) -> dict[str, str]:
        """The managed nodes that are not in their initial state yet, and the state they are in."""
        states = {node: (self._state_of(node), initial) for node, initial in self._initial_states.items()}
        return {node: state for node, (state, initial) in states.items() if state != initial}

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
            self._player.call_async(Trigger.Request()).add_done_callback(self._on_flying)

    def _on_flying(self, future: Future[Trigger.Response]) -> None:
        response = future.result()
        if response is None or not response.success:
            raise ScenarioError(
                f"The bag player did not start: {response.message if response else 'no reply'}."
            )
        self._after(self.timing.warm_up_s, self._inject)

    def _inject(self) -> None:
        self.phase = Phase.MEASURED
        self.start_ns = self.get_clock().now().nanoseconds
        self._publish("start")
        self._injector.call_async(Trigger.Request()).add_done_callback(self._on_injected)
        self._after(self.timing.duration_s, self._end)

    def _on_injected(self, future: Future[Trigger.Response]) -> None:
        response = future.result()
        if response is None or not response.success:
            reason = (response.message if response else "no reply").rstrip(".")
            self.injection_problem = (
                f"the scenario {self._scenario} could not be injected as written: {reason}"
            )

    def _end(self) -> None:
        self.phase = Phase.OVER
        self._publish("end")

    def _publish(self, name: str) -> None:
        now = self.get_clock().now().nanoseconds
        self._log.publish(
            ExperimentLogging(timestamp=now, scenario=self._scenario, source="experiment", rule_name=name)
        )

    def _after(self, seconds: float, action: Callable[[], None]) -> None:
        def once() -> None:
            timer.cancel()
            self.destroy_timer(timer)
            action()

        timer = self.create_timer(seconds, once)
