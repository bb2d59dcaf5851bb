"""The node that plays a scenario: it injects and ends faults, and keeps the world as the scenario says."""

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import Unpack, cast

from sunset.harness._injector import Answer, Injector
from sunset.harness._world import Occurrence, World, course
from sunset.nodes.base import call_later
from sunset.scenarios import ScenarioFault
from sunset.scenarios.loading import load_scenario
from sunset.scenarios.schema import Scenario
from sunset.system import (
    FAULT_ENDS_TOPIC,
    INJECTIONS_TOPIC,
    NAMESPACE,
    PARAMETER_TOPICS,
    SCENARIO_EXECUTOR,
    Adaptation,
    AdaptationKind,
    FaultKind,
    Value,
    current_system,
    full_name,
    short_name,
)
from sunset.system_interfaces.msg import FaultEnd, FaultInjection
from sunset.texts.names import ros_text
from sunset.texts.sentences import counted
from sunset_ros.interfaces.lifecycle_msgs.msg import TransitionEvent
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterDescriptor, ParameterEvent
from sunset_ros.interfaces.stamps import NS_PER_S, stamp_of
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.node import Node, NodeOptions
from sunset_ros.parameter import Parameter
from sunset_ros.task import Future


def is_at_once(fault: ScenarioFault) -> bool:
    """Return whether a fault comes when the measured time begins, at full strength."""
    return fault.at == 0 and fault.after is None and fault.profile.rise is None


class ScenarioExecutor(Node):
    """Plays a scenario when `~/inject` (std_srvs/srv/Trigger) is called.

    The service responds when each injection that is due at once is confirmed by its node, refused, or late; its success
    means that all are confirmed. Injections are published on `/experiment/injections` with the time of their order, and
    ends of faults on `/experiment/fault_ends` with their cause. Nothing is logged, since a managing system may read the
    log.

    A fault heals where the scenario says so. A fault that follows another comes only if the other is still there: an
    internal fault that was not cured, or an external fault that no cure works around. An internal fault whose node is
    starting comes when the node is up.

    A fault outside of the nodes outlasts their processes: it is restored when its node starts again. An external fault
    is also restored when its parameter is set, since that does not change the weather. If the managing system changes a
    faulty configuration, it owns this configuration from then on.

    The endpoints are the same in every scenario, so that the graph does not reveal the faults.

    Args:
        scenario: the scenario; None to load the one that the parameter `scenario` names.
        options: as in `Node`.

    Raises:
        ScenarioError: the scenario is not usable.
    """

    def __init__(self, scenario: Scenario | None = None, **options: Unpack[NodeOptions]) -> None:
        super().__init__(SCENARIO_EXECUTOR, **options)
        described = ParameterDescriptor(description="name or file of the scenario", read_only=True)
        name = self.declare_parameter("scenario", scenario.name if scenario else "", described).value
        self.scenario = scenario or load_scenario(cast("str", name))
        self._world = World()
        self._played: list[Occurrence] = []
        self._start_ns = 0
        self._injections = self.create_publisher(FaultInjection, INJECTIONS_TOPIC, 100)
        self._ends = self.create_publisher(FaultEnd, FAULT_ENDS_TOPIC, 100)
        steps = (step for fault in current_system().faults.values() for step in fault.injection)
        self._injector = Injector(self, dict.fromkeys(step.node for step in steps))
        for node in current_system().nodes:
            topic = f"{NAMESPACE}/{node}/transition_event"
            self.create_subscription(TransitionEvent, topic, partial(self._on_transition, node), 10)
        for topic in PARAMETER_TOPICS:
            self.create_subscription(ParameterEvent, topic, self._on_parameter_event, 1000)
        self.create_service(Trigger, "~/inject", self._inject)

    async def _inject(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        del request
        self._start_ns = self.get_clock().now().nanoseconds
        self._world.settle()
        self._played = list(map(Occurrence, self.scenario.faults))
        due = [each for each in self._played if is_at_once(each.plan) and not self._must_wait(each)]
        for occurrence in self._played:
            if occurrence.plan.after is None and occurrence not in due:
                self._at(occurrence.plan.at, partial(self._come, occurrence))
        answers = [(occurrence, self._is_up(occurrence), self._begin(occurrence)) for occurrence in due]
        problems = []
        for occurrence, is_up, future in answers:
            refusal = (await future).refusal if is_up else ""
            problems += [f"{occurrence.plan.name}: {refusal}"] * bool(refusal)
            self._arrive(occurrence, self._start_ns, refusal)
        response.success = not problems
        later = len(self._played) - len(answers)
        more = f"; {later} more may follow" if later else ""
        response.message = "; ".join(problems) or f"Injected {counted(len(answers), 'fault')}{more}."
        return response

    def _at(self, time_s: float, function: Callable[[], None]) -> None:
        """Call a function at a time, in seconds of the measured time; at once if the time is over."""
        delay_ns = self._start_ns + round(time_s * NS_PER_S) - self.get_clock().now().nanoseconds
        if delay_ns <= 0:
            function()
        else:
            call_later(self, delay_ns / NS_PER_S, function)

    def _come(self, occurrence: Occurrence) -> None:
        """Let a fault come; an internal fault waits until its node is up."""
        _, strength = next(course(occurrence.plan, self._seconds()))
        if occurrence.over or strength is None:  # it has healed before it would be there
            occurrence.over, occurrence.waiting = True, False
            return
        occurrence.waiting = self._must_wait(occurrence)
        if not occurrence.waiting:
            self._order(occurrence, self._begin)

    def _must_wait(self, occurrence: Occurrence) -> bool:
        """Return whether a fault lives in a node that is starting."""
        return occurrence.is_internal and not self._world.is_settled(occurrence.fault.node)

    def _is_up(self, occurrence: Occurrence) -> bool:
        """Return whether the nodes of a fault's injection are up; otherwise it comes when they are."""
        return all(self._world.is_settled(step.node) for step in occurrence.plan.injection)

    def _order(self, occurrence: Occurrence, inject: Callable[[Occurrence], Future[Answer]]) -> None:
        """Inject a fault after the measured time began, and publish that."""
        ordered_ns = self.get_clock().now().nanoseconds
        is_up = self._is_up(occurrence)

        def answered(future: Future[Answer]) -> None:
            answer = future.result() or Answer()
            if occurrence.is_internal and answer.late:
                occurrence.coming = False  # its process has ended, and the next may not have started
                self._come(occurrence)
            else:
                self._arrive(occurrence, ordered_ns, answer.refusal if is_up else "")

        inject(occurrence).add_done_callback(answered)

    def _begin(self, occurrence: Occurrence) -> Future[Answer]:
        """Begin the course of a fault; the future has the node's answer to its first step."""
        outcome: Future[Answer] = Future()
        occurrence.changes = course(occurrence.plan, self._seconds())
        time_s, value = next(occurrence.changes)

        def answered(future: Future[Answer]) -> None:
            outcome.set_result(future.result() or Answer())

        self._at(time_s, lambda: self._set(occurrence, value).add_done_callback(answered))
        return outcome

    def _set(self, occurrence: Occurrence, value: Value | None) -> Future[Answer]:
        occurrence.coming = not occurrence.there
        steps = occurrence.plan.injection if value is None else occurrence.injection(value)
        self._world.hold(steps, occurrence.fault)
        return self._apply(occurrence, steps, access=occurrence.is_internal and occurrence.there)

    def _apply(self, occurrence: Occurrence, steps: Iterable[Adaptation], *, access: bool) -> Future[Answer]:
        """Do steps at the same time; the future has all their refusals."""
        outcome: Future[Answer] = Future()
        steps = list(steps)
        answers: dict[int, Answer] = {}

        def answered(place: int, future: Future[Answer]) -> None:
            answers[place] = future.result() or Answer()
            if answers[place].changed and steps[place].kind is AdaptationKind.ACTIVATE:
                occurrence.activated.add(steps[place].node)
            if len(answers) == len(steps):
                refused = [answers[number] for number in sorted(answers) if answers[number].refusal]
                reason = f"; {occurrence.plan.name}: ".join(answer.refusal for answer in refused)
                outcome.set_result(Answer(reason, late=any(answer.late for answer in refused)))

        for place, step in enumerate(steps):
            self._injector.apply(step, access=access).add_done_callback(partial(answered, place))
        return outcome

    def _arrive(self, occurrence: Occurrence, ordered_ns: int, refusal: str) -> None:
        """Publish that a fault came, or was refused, and continue its course."""
        self._publish(occurrence, ordered_ns, confirmed=not refusal)
        occurrence.coming, occurrence.over, occurrence.there = False, bool(refusal), not refusal
        if refusal:
            return
        if not occurrence.begun:
            occurrence.begun = True
            for other in self._played:
                if other.plan.after is not None and other.plan.after.fault == occurrence.plan.name:
                    onset_s = (ordered_ns - self._start_ns) / NS_PER_S
                    self._at(onset_s + other.plan.after.delay, partial(self._follow, other, occurrence))
        self._go_on(occurrence)

    def _follow(self, occurrence: Occurrence, cause: Occurrence) -> None:
        """Let a fault come if its cause is still there."""
        if cause.over or self._world.is_worked_around(cause.fault):
            occurrence.over = True
        else:
            self._come(occurrence)

    def _go_on(self, occurrence: Occurrence) -> None:
        """Schedule the next change of a fault's strength; without one, a fault that is away is over."""
        time_s, value = next(occurrence.changes, (math.inf, None))
        if value is None and not occurrence.there:
            occurrence.over = True
        if time_s == math.inf or occurrence.over:
            return

        def turn() -> None:
            if occurrence.over:
                return
            if value is None:
                self._heal(occurrence)
                self._go_on(occurrence)
            elif occurrence.there:
                occurrence.grown = value
                self._set(occurrence, value).add_done_callback(partial(self._check, occurrence))
                self._go_on(occurrence)
            else:
                self._order(occurrence, lambda again: self._set(again, value))

        self._at(time_s, turn)

    def _heal(self, occurrence: Occurrence) -> None:
        """Remove a fault, unless it is away already."""
        if not occurrence.there:
            return
        occurrence.there = False
        self._world.release(occurrence.fault)
        self._publish_end(occurrence, "")
        removed = self._apply(occurrence, occurrence.removal(), access=occurrence.is_internal)
        removed.add_done_callback(partial(self._check, occurrence))

    def _check(self, occurrence: Occurrence, future: Future[Answer]) -> None:
        """Publish a change that a node refused although it is up; such a run does not count."""
        answer = future.result() or Answer()
        if answer.refusal and self._is_up(occurrence):
            self._publish(occurrence, self.get_clock().now().nanoseconds, confirmed=False)

    def _end(self, occurrence: Occurrence, cause: str) -> None:
        """End a fault that was cured, even if it was away."""
        if occurrence.there or occurrence.is_away:
            self._publish_end(occurrence, cause)
        occurrence.there, occurrence.over = False, True

    def _on_transition(self, node: str, event: TransitionEvent) -> None:
        start, goal = event.start_state.label, event.goal_state.label
        if self._world.see_transition(node, start, goal):
            self._on_process_end(node)
        self._restore(self._world.after_transition(node, start, goal))
        for occurrence in self._of(node):
            is_restart = (start, goal) == ("activating", "active")
            if is_restart and occurrence.is_away and occurrence.is_cured_by_restart:
                self._end(occurrence, f"restart {node}")
            elif occurrence.waiting and self._world.is_settled(node):
                self._come(occurrence)

    def _on_parameter_event(self, event: ParameterEvent) -> None:
        node = short_name(event.node)
        if node not in current_system().nodes:
            return
        for messages, declared in ((event.new_parameters, True), (event.changed_parameters, False)):
            for message in messages:
                value = cast("Value", Parameter.from_parameter_msg(message).value)
                if self._world.see_value(node, message.name, value, declared=declared):
                    self._on_process_end(node)
                if not declared:
                    self._on_change(node, message.name, value)

    def _on_change(self, node: str, parameter: str, value: Value) -> None:
        """Restore steps, and end or remove faults, after a parameter got a new value."""
        done = f"set {node}.{parameter} to {ros_text(value)}"
        self._restore(self._world.after_change_to(node, parameter, value))
        for occurrence in self._of(node):
            fault = occurrence.fault
            if occurrence.there and (parameter, value) == (fault.parameter, fault.healthy):
                self._end(occurrence, self._world.cause_of(fault, done))
            elif occurrence.is_away and occurrence.is_cured_by(parameter, value):
                self._end(occurrence, done)
        its_own = [each for each in self._of(node) if parameter == each.fault.parameter]
        if not any(each.coming or each.there for each in its_own):
            # an order from before the cure was seen may take effect after it
            for late in [each for each in its_own if each.grown == value][:1]:
                self._apply(late, late.removal(), access=True)
        for occurrence in self._played:
            is_configuration = occurrence.fault.kind is FaultKind.CONFIGURATION
            if is_configuration and occurrence.there and not self._world.holds(occurrence.fault):
                self._end(occurrence, done)

    def _on_process_end(self, node: str) -> None:
        for occurrence in self._of(node):
            if occurrence.begun and not occurrence.waiting:
                self._end(occurrence, f"redeploy {node}")

    def _of(self, node: str) -> list[Occurrence]:
        """Return the faults in a node."""
        return [each for each in self._played if each.is_internal and each.fault.node == node]

    def _restore(self, steps: Iterable[Adaptation]) -> None:
        """Repeat steps of injections; if one fails, the node's next transition repeats it."""
        for step in steps:
            self._injector.apply(step)

    def _seconds(self) -> float:
        """Return the measured time."""
        return (self.get_clock().now().nanoseconds - self._start_ns) / NS_PER_S

    def _publish(self, occurrence: Occurrence, ordered_ns: int, *, confirmed: bool) -> None:
        fault = occurrence.fault
        self._injections.publish(
            FaultInjection(
                stamp=stamp_of(ordered_ns),
                fault=fault.name,
                failure=fault.failure,
                node=full_name(fault.node),
                parameter=fault.parameter,
                value=ros_text(occurrence.plan.value),
                internal=occurrence.is_internal,
                redeploy_only=fault.redeploy_only,
                confirmed=confirmed,
            )
        )

    def _publish_end(self, occurrence: Occurrence, cause: str) -> None:
        """Publish that a fault has ended; the cause is empty if it healed."""
        now, fault = self.get_clock().now().to_msg(), occurrence.fault
        node = full_name(fault.node)
        self._ends.publish(FaultEnd(stamp=now, fault=fault.name, node=node, healed=not cause, cause=cause))
