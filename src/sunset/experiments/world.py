"""A simulated experiment: processes, the managing system, the observer, and the time."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import TypeVar

from sunset.errors import SunsetError
from sunset.experiments.manager import (
    bring_up_timeout_error,
    check_injection,
    check_name,
    manager_parameters,
    node_error,
    node_parameters,
)
from sunset.experiments.observer import Observer
from sunset.experiments.resources import Resources
from sunset.experiments.spec import RunSpec
from sunset.harness.bag_player import BagPlayer
from sunset.harness.confined_manager import ManagerProcess
from sunset.harness.executor import ScenarioExecutor
from sunset.harness.launcher import Launcher
from sunset.harness.simulated_processes import NodeFactory, SimulatedProcesses, bring_up
from sunset.harness.supervisor import Phase, Supervisor
from sunset.processes.calls import Watch
from sunset.recording import request_of
from sunset.system import (
    BAG_PLAYER,
    EXPERIMENT,
    MANAGER_PROCESS,
    SCENARIO_EXECUTOR,
    SURROUNDING,
    current_system,
    full_name,
)
from sunset.system_interfaces.msg import Command
from sunset_ros import Context, Node, Parameter
from sunset_ros.rmw.remote import Gateway, PipeError
from sunset_ros.rmw.sim import Simulation, Tap
from sunset_ros.seeding import generator

NodeT = TypeVar("NodeT", bound=Node)

_S = 10**9
_LAUNCH_NS = _S
"""Nodes start within this time, in turn, and the managing system within this time after the last node."""


class _SignOfLife(Tap):
    """Reports to the waiting parent process, hundreds of times per simulated second, that the simulation is alive."""

    def __init__(self, watch: Watch) -> None:
        self._watch = watch

    def on_message(self, *_: object) -> None:
        self._watch.tick()


@contextmanager
def _blaming_nodes(spec: RunSpec, watch: Watch, *, starting: bool = False) -> Iterator[None]:
    """Translate an exception of an extension's code in the node that runs."""
    try:
        yield
    except BaseException as error:
        blame = node_error(spec, watch.running, error, starting=starting)
        if blame is None:
            raise
        raise blame from error


class World:
    """A simulated experiment that is advanced from outside, with a managing system or without.

    It begins at the moment at which the managing system may start: every other process runs. Resources that the nodes
    share are not copied, so a process that forks goes on with two independent experiments.

    Args:
        spec: the run; its extensions are loaded, and its managing system is ignored.
        resources: of the run.
        observer: sees all messages and commands.
        watch: gets the signs of life, for a process that waits for this process.

    Attributes:
        failure: how the confined managing system has failed, in a sentence; empty if it has not.

    Raises:
        ExtensionError: a node of the extended system raised; other methods raise it, too.
    """

    def __init__(
        self, spec: RunSpec, resources: Resources, observer: Observer, watch: Watch | None = None
    ) -> None:
        self._spec, self._resources, self._observer = spec, resources, observer
        self._timing = spec.timing
        self._watch = watch = watch or Watch()
        self.failure = ""
        timing, system = self._timing, current_system()
        compute = {full_name(node): seconds for node, seconds in system.compute_s.items()}
        self._simulation = simulation = Simulation(
            seed=spec.seed, compute=compute, jitter=timing.jitter, latency_s=timing.latency_s
        )
        simulation.add_tap(observer)
        simulation.add_tap(_SignOfLife(watch))
        around = {name: partial(watch.call_named, name) for name in system.nodes} if spec.extensions else {}
        processes = SimulatedProcesses(simulation, _factories(spec, resources, watch), around)
        with _blaming_nodes(spec, watch):
            self._supervisor = _start_conductors(simulation, processes, spec, resources)
            nodes = (*system.nodes, *SURROUNDING)
            for launch_ns, name in sorted((_launch_ns(spec.seed, name), name) for name in nodes):
                simulation.run_until(launch_ns)
                processes.start(name)
            simulation.run_until(simulation.now + _launch_ns(spec.seed, MANAGER_PROCESS))

    @property
    def now_ns(self) -> int:
        """Nanoseconds of the simulated clock."""
        return self._simulation.now

    @property
    def is_over(self) -> bool:
        """Whether the measured time has ended."""
        return self._supervisor.phase is Phase.OVER

    @property
    def start_ns(self) -> int | None:
        """The time of the injection, at which the measured time begins; None before it."""
        return self._supervisor.start_ns

    def let_in(self, manager: ManagerProcess) -> None:
        """Connect a confined managing system to the network; if it fails, the experiment goes on without it."""
        spec, timing, simulation = self._spec, self._timing, self._simulation
        process = simulation.create_process(MANAGER_PROCESS)
        stage = "could not be constructed"

        def note(failure: PipeError) -> None:
            self.failure += manager.describe(failure, stage)

        gateway = Gateway(
            process,
            manager.pipe,
            limit_s=manager.longest_s,
            longest_ns=round((timing.bring_up_limit_s + timing.warm_up_s + timing.duration_s) * _S),
            end=process.end,
            on_failure=note,
        )
        gateway.start()
        if process.alive:
            process.run()
        stage = f"failed in {spec.scenario.name}, seed {spec.seed}"
        first = next(iter(process.nodes_here), None)
        if first is not None:
            check_name(first.fully_qualified_name, spec.manager)

    def manage(self, make: Callable[..., NodeT]) -> NodeT:
        """Start a managing system in this process, unconfined, and return its node.

        `make` is called as the class of a managing system is, with `context` and `parameter_overrides`.
        """
        values = manager_parameters(self._spec, self._resources)
        overrides = [Parameter(name, value=value) for name, value in values.items()]
        process = self._simulation.create_process(MANAGER_PROCESS)
        return bring_up(process, lambda context: make(context=context, parameter_overrides=overrides))

    def play_back(self, commands: Iterable[Command]) -> None:
        """Serve the recorded commands of a run at their times."""
        self._simulation.play_back(map(request_of, commands))

    def advance_until(self, predicate: Callable[[], bool]) -> bool:
        """Let events happen until a predicate holds, evaluated before each event, or the measured time ends.

        Returns:
            Whether the predicate holds, and the measured time has not ended.

        Raises:
            SunsetError: the managed system does not come up in time.
        """
        supervisor, timing, simulation = self._supervisor, self._timing, self._simulation
        with _blaming_nodes(self._spec, self._watch):
            limit_s = timing.bring_up_limit_s
            is_up = simulation.run_while(
                lambda: supervisor.phase is Phase.BRING_UP and not predicate(), round(limit_s * _S)
            )
            if not is_up:
                raise bring_up_timeout_error(self._spec, limit_s, supervisor.missing, self._observer.commands)
            limit_ns = simulation.now + round((timing.warm_up_s + timing.duration_s + 1) * _S)
            stopped = simulation.run_while(lambda: not (self.is_over or predicate()), limit_ns)
        if not stopped:
            raise SunsetError(
                f"The experiment did not end in time: it is still in its phase {supervisor.phase.value}."
            )
        return not self.is_over

    def advance_to(self, time_ns: int) -> None:
        """Let all events until `time_ns` of the simulated clock happen, also after the measured time."""
        with _blaming_nodes(self._spec, self._watch):
            self._simulation.run_until(time_ns)

    def finish(self) -> int:
        """Let the experiment end, and return the time of the injection, nanoseconds of the simulated clock."""
        self.advance_until(lambda: False)
        check_injection(self._supervisor.injection_problem, self._observer)
        # frames that left the bag before the end are still in the pipeline
        self.advance_to(self.now_ns + _S // 2)
        self._observer.finish(self.now_ns)
        assert self.start_ns is not None  # noqa: S101  the measured time has ended
        return self.start_ns


def _start_conductors(
    simulation: Simulation, processes: SimulatedProcesses, spec: RunSpec, resources: Resources
) -> Supervisor:
    """Start the nodes that conduct the experiment, and return the supervisor."""
    timing, nodes = spec.timing, tuple(current_system().nodes)

    def start(name: str, factory: Callable[[Context], NodeT]) -> NodeT:
        return bring_up(simulation.create_process(name, is_protected=True), factory)

    start("launcher", lambda context: Launcher(processes, nodes, context=context))
    start(SCENARIO_EXECUTOR, lambda context: ScenarioExecutor(resources.scenario, context=context))
    return start(
        EXPERIMENT,
        lambda context: Supervisor(
            spec.scenario.name, warm_up_s=timing.warm_up_s, duration_s=timing.duration_s, context=context
        ),
    )


def _launch_ns(seed: int, process: str) -> int:
    """Return when a process starts; the phases of its timers depend on it."""
    return int(generator(seed, "launch", process).integers(_LAUNCH_NS))


def _factories(spec: RunSpec, resources: Resources, watch: Watch) -> dict[str, NodeFactory]:
    """Return the factories of the managed nodes, and of the nodes that feed and watch them."""
    parameters = node_parameters(spec, resources)
    system = current_system()
    # loaded resources are passed on: neither loading time nor a path gets into the record
    given: dict[str, Callable[..., Node]] = {
        "segmentation": partial(system.node_class("segmentation"), segmenter=resources.segmenter),
        BAG_PLAYER: partial(BagPlayer, frames=resources.frames),
    }

    def make(name: str, context: Context) -> Node:
        values = parameters.get(name, {})
        overrides = [Parameter(parameter, value=value) for parameter, value in values.items()]
        node_class = given.get(name) or system.node_class(name)
        return node_class(context=context, parameter_overrides=overrides)

    def make_watched(name: str, context: Context) -> Node:
        with _blaming_nodes(spec, watch, starting=True):
            return watch.call_named(name, lambda: make(name, context))

    watched = system.nodes if spec.extensions else ()
    names = (*system.nodes, *SURROUNDING)
    return {name: partial(make_watched if name in watched else make, name) for name in names}
