"""The node that injects a scenario's faults, and keeps the world as the scenario says."""

from functools import partial
from types import MappingProxyType
from typing import Any, Final, cast

from sunset.harness._world import World
from sunset.interfaces import Service
from sunset.interfaces.builtin_interfaces.msg import Time
from sunset.interfaces.lifecycle_msgs.msg import Transition, TransitionEvent
from sunset.interfaces.lifecycle_msgs.srv import ChangeState, GetState
from sunset.interfaces.rcl_interfaces.msg import ParameterDescriptor, ParameterEvent
from sunset.interfaces.rcl_interfaces.srv import SetParameters
from sunset.interfaces.std_srvs.srv import Trigger
from sunset.interfaces.system_interfaces.msg import FaultInjection
from sunset.names import ros_text
from sunset.ros.client import AnyClient
from sunset.ros.node import Node
from sunset.ros.parameter import Parameter
from sunset.ros.task import Future
from sunset.scenarios.loading import load_scenario
from sunset.scenarios.schema import Scenario, ScenarioFault
from sunset.system import (
    INJECTIONS_TOPIC,
    NAMESPACE,
    PARAMETER_EVENTS_TOPIC,
    Adaptation,
    AdaptationKind,
    FaultKind,
    Value,
    current_system,
    full_name,
    short_name,
)
from sunset.texts import counted

_SERVICES: Final = MappingProxyType(
    {SetParameters: "set_parameters", ChangeState: "change_state", GetState: "get_state"}
)
_CONFIRMATION_S: Final = 2.0
"""How long a node may take to confirm an injection."""


class ScenarioExecutor(Node):
    """Injects all faults of a scenario at once when `~/inject` (std_srvs/srv/Trigger) is called.

    The answer comes when every injection is confirmed by its node, or refused, or not answered; it is
    successful only if all are confirmed. Every injection is published on `/experiment/injections`, with
    the time at which it was ordered.

    From then on it plays the world. A fault that lives outside of the nodes outlasts their processes: it
    is put back when its node starts anew. An external one is put back also when somebody sets its
    parameter, since the weather does not change by that; a configuration that somebody else changed is
    theirs from then on.

    Its endpoints are the same in every scenario, so that the graph does not tell what is about to be injected.

    Args:
        scenario: what to inject; None to load what the parameter `scenario` names.
        options: as of `Node`.

    Raises:
        ScenarioError: the scenario is not usable.
    """

    def __init__(self, scenario: Scenario | None = None, **options: Any) -> None:
        super().__init__("scenario_executor", **options)
        described = ParameterDescriptor(description="name or file of the scenario", read_only=True)
        name = self.declare_parameter("scenario", scenario.name if scenario else "", described).value
        self.scenario = scenario or load_scenario(cast("str", name))
        """What is injected."""
        self._world = World()
        self._callers: dict[str, AnyClient] = {}
        self._injections = self.create_publisher(FaultInjection, INJECTIONS_TOPIC, 100)
        self._prepare()
        self.create_service(Trigger, "~/inject", self._inject)

    def _prepare(self) -> None:
        """Create what any scenario needs before it is needed, so that it is matched by then."""
        for node in dict.fromkeys(
            step.node for fault in current_system().faults.values() for step in fault.injection
        ):
            for service in (SetParameters, ChangeState, GetState):
                self._caller(service, node)
            self.create_subscription(
                TransitionEvent,
                f"{NAMESPACE}/{node}/transition_event",
                partial(self._on_transition, node),
                10,
            )
        self.create_subscription(ParameterEvent, PARAMETER_EVENTS_TOPIC, self._on_parameter_event, 1000)

    async def _inject(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        del request
        ordered = self.get_clock().now().to_msg()
        answers = [(fault, [self._apply(step) for step in fault.injection]) for fault in self.scenario.faults]
        problems = []
        for fault, futures in answers:
            refusals = [reason for reason in [await future for future in futures] if reason]
            problems += [f"{fault.name}: {reason}" for reason in refusals]
            self._publish(fault, ordered, confirmed=not refusals)
            self._world.begin(fault)
        response.success = not problems
        response.message = "; ".join(problems) or f"Injected {counted(len(answers), 'fault')}."
        return response

    def _publish(self, one: ScenarioFault, ordered: Time, *, confirmed: bool) -> None:
        fault = one.fault
        self._injections.publish(
            FaultInjection(
                stamp=ordered,
                fault=fault.name,
                failure=fault.failure,
                node=full_name(fault.node),
                parameter=fault.parameter,
                value=ros_text(one.value),
                internal=fault.kind is FaultKind.INTERNAL,
                redeploy_only=fault.redeploy_only,
                confirmed=confirmed,
            )
        )

    def _on_transition(self, node: str, event: TransitionEvent) -> None:
        for step in self._world.after_transition(node, event.start_state.label, event.goal_state.label):
            self._restore(step)

    def _on_parameter_event(self, event: ParameterEvent) -> None:
        node = short_name(event.node)
        for message in event.changed_parameters:
            value = cast("Value", Parameter.from_parameter_msg(message).value)
            for step in self._world.after_change_to(node, message.name, value):
                self._restore(step)

    def _restore(self, step: Adaptation) -> None:
        """Do a step of an injection again."""

        def log(future: Future[str]) -> None:
            if future.result():
                reason = f"Could not {step} again: {future.result()}"
                self.get_logger().warning(reason, throttle_duration_sec=1.0)

        self._apply(step).add_done_callback(log)

    def _apply(self, step: Adaptation) -> Future[str]:
        """Do a step of an injection; the future has why it was not confirmed, or an empty text."""
        outcome: Future[str] = Future()

        def finish(reason: str) -> None:
            if not outcome.done():
                self.destroy_timer(timer)
                outcome.set_result(reason)

        def set_up(future: Future[SetParameters.Response]) -> None:
            response = future.result()
            assert response is not None  # noqa: S101  the future is done
            finish("; ".join(result.reason for result in response.results if not result.successful))

        def activated(future: Future[ChangeState.Response]) -> None:
            response = future.result()
            if response is not None and response.success:
                finish("")
            else:  # it may be active already
                self._caller(GetState, step.node).call_async(GetState.Request()).add_done_callback(looked_at)

        def looked_at(future: Future[GetState.Response]) -> None:
            response = future.result()
            active = response is not None and response.current_state.label == "active"
            finish("" if active else f"{step.node} refused to be activated")

        late = f"{step.node} did not answer within {_CONFIRMATION_S:g} s"
        timer = self.create_timer(_CONFIRMATION_S, lambda: finish(late))
        if step.kind is AdaptationKind.ACTIVATE:
            transition = Transition(id=Transition.TRANSITION_ACTIVATE, label="activate")
            activation = ChangeState.Request(transition=transition)
            self._caller(ChangeState, step.node).call_async(activation).add_done_callback(activated)
        else:
            parameter = Parameter(step.parameter, value=step.value)
            setting = SetParameters.Request(parameters=[parameter.to_parameter_msg()])
            self._caller(SetParameters, step.node).call_async(setting).add_done_callback(set_up)
        return outcome

    def _caller(self, service: type[Service], node: str) -> AnyClient:
        name = f"{NAMESPACE}/{node}/{_SERVICES[service]}"
        if name not in self._callers:
            self._callers[name] = self.create_client(service, name)
        return self._callers[name]
