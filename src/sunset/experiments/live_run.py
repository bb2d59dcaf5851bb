"""A live experiment: every node is a process, and an observer listens from outside."""

import math
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack, nullcontext
from itertools import pairwise

from sunset.errors import SunsetError
from sunset.experiments.live import LiveClock, LiveSystem
from sunset.experiments.manager import bring_up_timeout_error, check_injection
from sunset.experiments.observer import Observer, Sink, shown_topics
from sunset.experiments.resources import Resources
from sunset.experiments.settings import RunTiming
from sunset.experiments.spec import RunSpec
from sunset.harness.supervisor import Phase, Supervisor
from sunset.managing import EXTERNAL
from sunset.metrics import Timeline
from sunset.system import (
    CLOCK_TOPIC,
    DIAGNOSTICS_TOPIC,
    EXPERIMENT,
    MANAGER_PROCESS,
    RESULT_TOPIC,
    TRUTH_TOPIC,
    current_system,
)
from sunset.texts.names import base_name
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.rosgraph_msgs.msg import Clock
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.interruption import held_signals
from sunset_ros.rmw.backends import live_middleware
from sunset_ros.rmw.core.live import LiveObserver
from sunset_ros.rmw.core.port import EndpointKind, RequestId, qualified_name

_S = 10**9
_NAMELESS = "a nameless node"
_ON_ITS_WAY_S = 0.5
"""A frame that was taken this long before a fault may be lost to it."""
_LATE = 2.5
"""Periods between two frames of the bag after which the second was too late."""
_TOLERANCE = 0.02
"""Share of frames that a computer may lose; a single frame is always tolerated."""
_PATIENCE_S = 10.0
"""How much longer than planned an experiment may last."""


class FrameCount:
    """The frames that left the bag, and those that were segmented; times in nanoseconds of `/clock`."""

    def __init__(self) -> None:
        self.taken: dict[tuple[int, int], int] = {}
        self.segmented: dict[tuple[int, int], int] = {}
        self.disturbed_ns: int | None = None
        """When the process of a managed node was first noticed to have ended, without a command."""
        self.clock: list[tuple[int, int]] = []
        """When a message on `/clock` was sent, and the time in it."""

    def note(self, time_ns: int, topic: str, message: Message) -> None:
        """Note a message."""
        if topic == CLOCK_TOPIC and isinstance(message, Clock):
            self.clock.append((time_ns, ns_of(message.clock)))
        frames = {TRUTH_TOPIC: self.taken, RESULT_TOPIC: self.segmented}.get(topic)
        if frames is not None and isinstance(message, Image):
            frames[message.header.stamp.sec, message.header.stamp.nanosec] = time_ns

    def note_disturbance(self, time_ns: int) -> None:
        """Note that a process of the managed system is not as it should be; only the first time counts."""
        if self.disturbed_ns is None:
            self.disturbed_ns = time_ns

    def shortfall(self, start_ns: int, timeline: Timeline, timing: RunTiming) -> str:
        """Return in words how the computer could not keep up, so that the run is invalid; empty if it could.

        At most a single frame, or 2 % of them, may be lost before the system is disturbed: by an outage, a command,
        or a node's process that ends from outside.
        """
        late_s = max((time - shown for time, shown in self.clock if shown >= start_ns), default=0) / _S
        if late_s > timing.period_s:
            return f"the computer was too slow to observe it: times are wrong by up to {late_s:.2f} s"
        times, planned = sorted(self.taken.values()), timing.least_frames
        if planned - len(times) > _tolerated(planned):
            return f"the computer was too slow for the flight: {len(times)} of {planned} frames were played"
        gap_s = max((after - before for before, after in pairwise(times)), default=0) / _S
        if gap_s > _LATE * timing.period_s:
            return (
                f"the computer was too slow for the flight: by /clock, {gap_s:.2f} s passed between two frames in "
                f"place of {timing.period_s:g} s"
            )
        due, lost = self.losses(start_ns, timeline, timing)
        if lost > _tolerated(due):
            return f"the computer was too slow: {lost} of {due} frames were lost before anything was wrong"
        return ""

    def losses(self, start_ns: int, timeline: Timeline, timing: RunTiming) -> tuple[int, int]:
        """Return how many frames were due before the system was disturbed, and how many of them were lost."""
        failures, outages = timeline.injections, current_system().outages
        disturbed = [command.time for command in timeline.commands]
        disturbed += [injection.time for injection in failures if injection.failure in outages]
        if self.disturbed_ns is not None:
            disturbed.append((self.disturbed_ns - start_ns) / _S)
        until_ns = start_ns + round((min(disturbed, default=timing.duration_s) - _ON_ITS_WAY_S) * _S)
        due = [stamp for stamp, time_ns in self.taken.items() if time_ns < until_ns]
        return len(due), sum(stamp not in self.segmented for stamp in due)


def _tolerated(frames: int) -> int:
    """Return how many frames of a number may be lost.

    >>> _tolerated(30), _tolerated(240)
    (1, 4)
    """
    return max(1, int(_TOLERANCE * frames))


class LiveWatch(Observer):
    """Observes a run in the time of `/clock`, and counts its frames."""

    def __init__(self, spec: RunSpec, sink: Sink) -> None:
        settings = spec.settings
        super().__init__(sink, shown=shown_topics(spec.manager), viewers=settings.viewers, task=settings.task)
        self.clock = LiveClock(time.time_ns(), float(settings.speed))
        self.frames = FrameCount()
        self.strangers: dict[str, None] = {}
        """Nodes that are not of the system, in order of their discovery."""
        self.is_ready = False
        """Whether it has discovered the subscription that is created last, and therefore all before."""

    def on_node(self, process: str, node: str) -> None:
        """Note strangers, besides."""
        # hidden nodes, and nodes of `ros2 launch` itself
        is_tool = base_name(node).startswith(("_", "launch_ros_")) or node in self.viewers
        if node not in current_system().all_nodes and not is_tool:
            self.strangers[node] = None
        super().on_node(process, node)

    def on_endpoint(self, node: str, kind: EndpointKind, name: str) -> None:
        """Note whether it is the last endpoint, besides."""
        self.is_ready |= (node, name) == (f"/{EXPERIMENT}", DIAGNOSTICS_TOPIC)
        super().on_endpoint(node, kind, name)

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        """Count frames, besides."""
        self.frames.note(self.clock.at(time_ns), topic, message)
        super().on_message(self.clock.at(time_ns), topic, node or _NAMELESS, message)

    def on_request(  # noqa: PLR0917  as of Tap
        self, time_ns: int, service: str, client: str, server: str, request: Message, request_id: RequestId
    ) -> None:
        """Take the time of `/clock`."""
        at_ns = self.clock.at(time_ns)
        super().on_request(at_ns, service, client or _NAMELESS, server, request, request_id)

    def on_response(
        self, time_ns: int, service: str, server: str, response: Message, request_id: RequestId
    ) -> None:
        """Take the time of `/clock`."""
        super().on_response(self.clock.at(time_ns), service, server, response, request_id)


def run_live(spec: RunSpec, resources: Resources, watch: LiveWatch, *, log: bool = False) -> tuple[int, str]:
    """Run an experiment with every node as a process of its own.

    If the managing system fails, the experiment goes on without it.

    Returns:
        The time of the injection, nanoseconds of `/clock`; and how the managing system has failed, in a sentence, empty
        if it has not.
    """
    with ExitStack() as stack:
        tap, system = _started(stack, spec, resources, watch, log=log)
        ready = _readiness(spec, watch, system)
        supervisor = Supervisor(
            spec.scenario.name,
            warm_up_s=spec.timing.warm_up_s,
            duration_s=spec.timing.duration_s,
            context=system.context,
            ready=lambda: ready() and supervisor.log.get_subscription_count() > 0,
        )
        system.executor.add_node(supervisor)

        def look() -> None:
            tap.check()
            if supervisor.phase is not Phase.BRING_UP and system.is_disturbed():
                watch.frames.note_disturbance(watch.clock.at(time.time_ns()))

        _conduct(system, supervisor, spec, watch, look)
        end_ns = watch.clock.at(time.time_ns())
        tap.finish()
    watch.finish(end_ns)
    return supervisor.start_ns or 0, system.manager_failure


def _started(
    stack: ExitStack, spec: RunSpec, resources: Resources, watch: LiveWatch, *, log: bool
) -> tuple[LiveObserver, LiveSystem]:
    """Enter a domain, observe it and start the system in it, until the stack is closed."""

    def show(node: str, line: str) -> None:
        if log and node == MANAGER_PROCESS:
            print(line, file=sys.stderr)  # noqa: T201  as in the simulation

    live = live_middleware(spec.settings.middleware)
    check_signals = stack.enter_context(held_signals())
    # an external managing system must know the domain beforehand, by ROS_DOMAIN_ID
    free = nullcontext() if spec.manager == EXTERNAL else live.free_domain_id()
    domain_id = stack.enter_context(free)
    # it comes before the nodes and leaves after them: each of its readers that comes or goes occupies all of them
    tap = stack.enter_context(live.observe(watch, domain_id=domain_id))
    check_signals()
    return tap, stack.enter_context(LiveSystem(spec, resources, domain_id, clock=watch.clock, on_line=show))


def _readiness(spec: RunSpec, watch: LiveWatch, system: LiveSystem) -> Callable[[], bool]:
    """Return a predicate: the observer and the managing system are ready."""
    if spec.manager != EXTERNAL:
        return lambda: watch.is_ready
    invitation = f"The system is up; start your managing system now: any node in domain {system.domain_id}."
    invitations = iter([invitation])

    def is_there() -> bool:
        nodes = system.context.middleware.nodes()
        if any(qualified_name(namespace, name) in watch.strangers for name, namespace in nodes):
            return True
        for text in invitations:
            print(text, file=sys.stderr)  # noqa: T201
        return False

    return lambda: watch.is_ready and is_there()


def _conduct(
    system: LiveSystem, supervisor: Supervisor, spec: RunSpec, observer: Observer, look: Callable[[], None]
) -> None:
    """Run the experiment, calling `look` in every step; an error that it raises ends the run."""
    timing = spec.timing

    def wait(predicate: Callable[[], bool], seconds: float) -> bool:
        def is_over() -> bool:
            system.check(managed=supervisor.phase is Phase.BRING_UP)
            look()
            return predicate()

        return system.spin_until(is_over, seconds)

    limit = timing.bring_up_limit_s / min(1.0, spec.settings.speed)
    if not wait(lambda: supervisor.phase is not Phase.BRING_UP or not supervisor.missing, limit):
        disturbed = system.is_disturbed()
        raise bring_up_timeout_error(spec, limit, supervisor.missing, observer.commands, disturbed=disturbed)
    patience = math.inf if spec.manager == EXTERNAL else limit  # another process may be started late
    if not wait(lambda: supervisor.phase is not Phase.BRING_UP, patience):
        raise SunsetError(f"The computer is too slow: nothing was observed of the system within {limit:g} s.")
    planned = (timing.warm_up_s + timing.duration_s) / spec.settings.speed
    if not wait(lambda: supervisor.phase is Phase.OVER, planned + _PATIENCE_S):
        raise SunsetError(
            f"The experiment did not end in time: {planned + _PATIENCE_S:g} s after it began it is still in its phase "
            f"{supervisor.phase.value}; does the bag player, which publishes /clock, still run?"
        )
    check_injection(supervisor.injection_problem, observer)
    # frames that left the bag before the end are still in the pipeline
    wait(lambda: False, 0.5 / spec.settings.speed)
