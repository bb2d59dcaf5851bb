"""A simulated experiment: processes, the managing system, the observer."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from types import MappingProxyType
from typing import TypeVar

from sunset.errors import SunsetError
from sunset.experiments.manager import (
    bring_up_timeout_error,
    check_injection,
    check_name,
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
from sunset.harness.supervisor import Phase, Supervisor
from sunset.processes.calls import Watch
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
from sunset.system_interfaces.srv import Redeploy
from sunset.texts.names import base_name
from sunset_ros import Context, Node, Parameter, SingleThreadedExecutor
from sunset_ros._parameter_files import parse_value
from sunset_ros.interfaces import Message, Service
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.srv import SetParameters, SetParametersAtomically
from sunset_ros.interfaces.stamps import ns_of
from sunset_ros.rmw.remote import Gateway
from sunset_ros.rmw.sim import SimProcess, Simulation, Tap
from sunset_ros.seeding import generator

NodeFactory = Callable[[Context], Node]
Around = Callable[[Callable[[], None]], None]
NodeT = TypeVar("NodeT", bound=Node)

_S = 10**9
_LAUNCH_NS = _S
"""Nodes start within this time, in turn, and the managing system within this time after the last node."""


class _Processes:
    """Processes of nodes in a simulation; a `ProcessHost`.

    `around` has wrappers that call the callbacks of nodes which the simulation does not call directly.
    """

    def __init__(
        self,
        simulation: Simulation,
        factories: Mapping[str, NodeFactory],
        around: Mapping[str, Around] = MappingProxyType({}),
    ) -> None:
        self._simulation = simulation
        self._factories = factories
        self._around = around
        self._running: dict[str, SimProcess] = {}
        self.on_exit: Callable[[str], object] = lambda _: None

    def start(self, node: str) -> None:
        self._running[node] = process = self._simulation.create_process(node, around=self._around.get(node))
        self._simulation.on_exit(process, lambda _: self._ended(node))
        bring_up(process, self._factories[node])

    def is_running(self, node: str) -> bool:
        return node in self._running

    def kill(self, node: str) -> None:
        self._simulation.kill(self._running[node])

    def _ended(self, node: str) -> None:
        del self._running[node]
        self.on_exit(node)


class _SignOfLife(Tap):
    """Reports to the waiting parent process, hundreds of times per simulated second, that the simulation is alive."""

    def __init__(self, watch: Watch) -> None:
        self._watch = watch

    def on_message(self, *_: object) -> None:
        self._watch.tick()


def bring_up(process: SimProcess, factory: Callable[[Context], NodeT]) -> NodeT:
    """Make a node in a new process, and let its callbacks run."""
    context = Context()
    context.init([], middleware=process)
    node = factory(context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    process.run()
    return node


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


def run_simulated(
    spec: RunSpec,
    resources: Resources,
    watch: Watch,
    manager: ManagerProcess,
    observer: Observer,
    *,
    played: Sequence[Command] = (),
) -> tuple[int, str]:
    """Run an experiment in the simulation, with the managing system in a process of its own.

    If the managing system fails, the experiment goes on without it. Recorded commands are played back.

    Returns:
        The time of the injection, nanoseconds of the simulated clock; and how the managing system has failed, in a
        sentence, empty if it has not.
    """
    timing, system = spec.timing, current_system()
    compute = {full_name(node): seconds for node, seconds in system.compute_s.items()}
    simulation = Simulation(seed=spec.seed, compute=compute, jitter=timing.jitter, latency_s=timing.latency_s)
    simulation.add_tap(observer)
    simulation.add_tap(_SignOfLife(watch))
    around = {name: partial(watch.call_named, name) for name in system.nodes} if spec.extensions else {}
    processes = _Processes(simulation, _factories(spec, resources, watch), around)
    with _blaming_nodes(spec, watch):
        supervisor = _start_conductors(simulation, processes, spec, resources)
        nodes = (*system.nodes, *SURROUNDING)
        for launch_ns, name in sorted((_launch_ns(spec.seed, name), name) for name in nodes):
            simulation.run_until(launch_ns)
            processes.start(name)
        simulation.run_until(simulation.now + _launch_ns(spec.seed, MANAGER_PROCESS))
        failed = _let_in(manager, simulation, spec)
        if played:
            simulation.play_back(map(_request_of, played))
        start_ns = _conduct(simulation, supervisor, spec, observer)
    observer.finish(simulation.now)
    return start_ns, "".join(failed)


def _start_conductors(
    simulation: Simulation, processes: _Processes, spec: RunSpec, resources: Resources
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


def _let_in(manager: ManagerProcess, simulation: Simulation, spec: RunSpec) -> list[str]:
    """Connect the managing system to the network; return a list that receives a sentence when it fails."""
    timing, process = spec.timing, simulation.create_process(MANAGER_PROCESS)
    failed: list[str] = []
    stage = "could not be constructed"
    gateway = Gateway(
        process,
        manager.pipe,
        limit_s=manager.longest_s,
        longest_ns=round((timing.bring_up_limit_s + timing.warm_up_s + timing.duration_s) * _S),
        end=process.end,
        on_failure=lambda failure: failed.append(manager.describe(failure, stage)),
    )
    gateway.start()
    if process.alive:
        process.run()
    stage = f"failed in {spec.scenario.name}, seed {spec.seed}"
    first = next(iter(process.nodes_here), None)
    if first is not None:
        check_name(first.fully_qualified_name, spec.manager)
    return failed


def _request_of(command: Command) -> tuple[int, str, type[Service], Message]:
    """Return when a recorded command was served, the service with its type, and the request."""
    time_ns, name = ns_of(command.stamp), command.service
    if command.kind == "redeploy":
        return time_ns, name, Redeploy, Redeploy.Request(node=command.node)
    if command.kind != "set_parameters":
        return time_ns, name, ChangeState, ChangeState.Request(transition=Transition(label=command.kind))
    kind = SetParametersAtomically if base_name(name) == "set_parameters_atomically" else SetParameters
    parameters = [
        Parameter(
            parameter, value=None if text == "unset" else parse_value(text, parameter)
        ).to_parameter_msg()
        for parameter, text in zip(command.parameters, command.values, strict=True)
    ]
    return time_ns, name, kind, kind.Request(parameters=parameters)


def _launch_ns(seed: int, process: str) -> int:
    """Return when a process starts; the phases of its timers depend on it."""
    return int(generator(seed, "launch", process).integers(_LAUNCH_NS))


def _conduct(simulation: Simulation, supervisor: Supervisor, spec: RunSpec, observer: Observer) -> int:
    """Run the experiment; return the time of the injection."""
    limit_s = spec.settings.timing.bring_up_limit_s
    simulation.run_while(lambda: supervisor.phase is Phase.BRING_UP, round(limit_s * _S))
    if supervisor.phase is Phase.BRING_UP:
        raise bring_up_timeout_error(spec, limit_s, supervisor.missing, observer.commands)
    duration_ns = round((spec.timing.warm_up_s + spec.timing.duration_s) * _S)
    simulation.run_while(lambda: supervisor.phase is not Phase.OVER, simulation.now + duration_ns + _S)
    if supervisor.start_ns is None or supervisor.phase is not Phase.OVER:
        raise SunsetError(
            f"The experiment did not end in time: it is still in its phase {supervisor.phase.value}."
        )
    check_injection(supervisor.injection_problem, observer)
    # frames that left the bag before the end are still in the pipeline
    simulation.run_until(simulation.now + _S // 2)
    return supervisor.start_ns


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
