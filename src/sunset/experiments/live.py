"""The whole system as processes of the operating system, in a domain of DDS."""

import os
import time
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Final, Self

from msgspec import to_builtins

from sunset.errors import InvalidInputError, ManagerError, MiddlewareError, SunsetError
from sunset.experiments.manager import Parameters, manager_parameters, manager_spec_of, node_parameters
from sunset.experiments.resources import Resources
from sunset.experiments.spec import RunSpec
from sunset.harness.deployment import deployed_scenario, deployment
from sunset.harness.launcher import Launcher
from sunset.harness.node_process import NodeProcesses, NodeSpec
from sunset.managing import EXTERNAL
from sunset.system import (
    BAG_PLAYER,
    MANAGER_PROCESS,
    MANAGING_SYSTEM,
    SCENARIO_EXECUTOR,
    SENSOR_TOPICS,
    SURROUNDING,
    current_system,
    full_name,
)
from sunset_ros import CallbackError, Context, SingleThreadedExecutor
from sunset_ros.interruption import held_signals
from sunset_ros.rmw.backends import live_middleware
from sunset_ros.rmw.core.node import Middleware
from sunset_ros.rmw.core.port import qualified_name

_FIRST: Final = (BAG_PLAYER, SCENARIO_EXECUTOR)
"""Nodes that others wait for; they are started first, with the sensors, which take longest to be active."""
_TURN_S: Final = 0.2
"""Longest wait for one process before the next is started: all at once would take the processor from others."""
_DISCOVERY_S: Final = 0.5
"""How long to listen for nodes that a managing system has left in the domain, before the system's own are started."""
_STEP_NS: Final = 10_000_000


@dataclass(frozen=True)
class LiveClock:
    """The time of `/clock`: 0 at `origin_ns`, nanoseconds since 1970; it runs at `speed` times real time."""

    origin_ns: int
    speed: float

    def at(self, system_ns: int) -> int:
        """Return its time at a time of the system's clock, at least 0, in nanoseconds."""
        return max(0, round((system_ns - self.origin_ns) * self.speed))


class LiveSystem:
    """Runs every node of an experiment as a process of its own, and the launcher in this process.

    All of them end with the context, or with this process. A signal is a `KeyboardInterrupt` in `spin_until`, or at the
    end of the context.

    Args:
        domain_id: the domain of DDS; ROS_DOMAIN_ID, else 0, if None.
        network: whether to be heard beyond this computer.
        distro: the ROS 2 distribution of other nodes; None to find out.
        clock: the time of `/clock`; None for the time since now.
        loop: whether the system lasts: the flight repeats from the bag's first frame to its last, and errors in
            callbacks of this process are logged and do not end it.
        autostart: whether the managed nodes configure and activate themselves.
        on_line: called, on other threads, with a node and a line that it printed.

    Attributes:
        context: this process, whose nodes' callbacks run in `spin_until`.
    """

    def __init__(
        self,
        spec: RunSpec,
        resources: Resources,
        domain_id: int | None,
        *,
        network: bool = False,
        distro: str | None = None,
        clock: LiveClock | None = None,
        loop: bool = False,
        autostart: bool = True,
        on_line: Callable[[str, str], object] = lambda _node, _line: None,
    ) -> None:
        live = live_middleware(spec.settings.middleware)
        _check_discovery()
        self._spec = spec
        self._managed = tuple(current_system().nodes)
        self._lasts = loop
        self._autostart = autostart
        self._clock = clock or LiveClock(time.time_ns(), float(spec.settings.speed))
        with ExitStack() as stack:
            self._check_signals = stack.enter_context(held_signals())
            middleware = stack.enter_context(live.join(domain_id=domain_id, network=network, distro=distro))
            self.domain_id = middleware.domain_id
            self._middleware: Middleware = middleware
            stack.enter_context(live.sole_system(self.domain_id))
            parameters = self._parameters(resources)
            stack.enter_context(deployment(self.domain_id, parameters, resources.scenario.to_yaml()))
            self.context = Context()
            words = ["--ros-args", "-p", "use_sim_time:=true", "-p", "launcher:use_sim_time:=false"]
            self.context.init(words, middleware=middleware, log_to_stderr=False)
            specs = self._specs(resources, network=network, distro=distro)
            self.processes = NodeProcesses(specs, {"ROS_DOMAIN_ID": str(self.domain_id)}, on_line)
            stack.callback(self.processes.close)
            self.executor = SingleThreadedExecutor(context=self.context)
            self._start(specs)
            self._stack = stack.pop_all()

    def _start(self, nodes: Iterable[str]) -> None:
        """Start the launcher in this process, and all nodes in processes of their own."""
        self._refuse_namesakes()
        self._launcher = Launcher(self.processes, self._managed, context=self.context)
        self.executor.add_node(self._launcher)
        managed = current_system().nodes.values()
        sensors = [node.name for node in managed if {*node.inputs} & {*SENSOR_TOPICS}]

        def is_heard(node: str) -> bool:
            return any(name == node for name, _ in self._middleware.nodes())

        for name in sorted(nodes, key=lambda name: name not in {*_FIRST, *sensors}):
            self.processes.start(name)
            self.spin_until(partial(is_heard, name), _TURN_S)
        self.essential = tuple(name for name in nodes if name not in {*self._managed, MANAGER_PROCESS})
        """The nodes that the experiment needs to the end."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stack.__exit__(kind, error, trace)

    def _refuse_namesakes(self) -> None:
        """Raise if the domain has a node of the system already, such as a launched node that outlived its run."""

        def namesakes() -> list[str]:
            nodes = {qualified_name(namespace, name) for name, namespace in self._middleware.nodes()}
            return sorted(nodes & {*current_system().all_nodes})

        if self.spin_until(lambda: bool(namesakes()), _DISCOVERY_S):
            raise MiddlewareError(
                f"Domain {self.domain_id} already has {' and '.join(namesakes())}: end the process that a run before "
                "has left, or choose another domain."
            )

    def _specs(self, resources: Resources, *, network: bool, distro: str | None) -> dict[str, NodeSpec]:
        spec = self._spec
        spec_of = partial(NodeSpec, middleware=spec.settings.middleware, network=network, distro=distro)
        names = [*self._managed, *SURROUNDING]
        if spec.scenario.faults or not self._lasts:
            names.append(SCENARIO_EXECUTOR)
        faults = [fault.name for fault in spec.scenario.faults]
        specs = {name: spec_of(node=name, faults=faults) for name in names}
        if spec.manager != EXTERNAL:
            manager = manager_spec_of(spec, resources, log=True)
            specs[MANAGER_PROCESS] = spec_of(
                node=MANAGING_SYSTEM,
                confined=to_builtins(manager),
                occasion=f"{spec.scenario.name}, seed {spec.seed}",
            )
        return specs

    def _parameters(self, resources: Resources) -> dict[str, Parameters]:
        """Return pattern of full node names → parameter → value; the pattern of all nodes comes first."""
        spec, managed = self._spec, current_system().nodes
        parameters = node_parameters(spec, resources)
        height, width = resources.bag.size
        parameters[BAG_PLAYER] |= {
            "bag": str(resources.bag.path.absolute()),
            "width": width,
            "height": height,
            "speed": self._clock.speed,
            "origin_ns": self._clock.origin_ns,
            "use_sim_time": False,  # it publishes the time
        }
        if self._lasts:
            parameters[BAG_PLAYER] |= {"loop": True, "start_frame": 0, "frames": 0}
        model = _absolute(spec.settings.model)
        parameters["segmentation"] |= {"model": model, "device": resources.segmenter.device}
        parameters[SCENARIO_EXECUTOR] = {"scenario": str(deployed_scenario(self.domain_id))}
        # the managing system's too, since only its class knows the name of its node
        of_all = {"use_sim_time": True} | manager_parameters(spec, resources)
        of_all |= {} if self._autostart else {"autostart": False}
        return {"/**": of_all} | {
            full_name(node) if node in managed else f"/{node}": values for node, values in parameters.items()
        }

    def spin_until(self, predicate: Callable[[], bool], timeout_s: float) -> bool:
        """Run callbacks of this process, and poll the other processes, until a predicate holds.

        Returns:
            Whether it holds.
        """
        end = time.monotonic() + timeout_s
        while not predicate():
            self._check_signals()
            if time.monotonic() >= end:
                return False
            try:
                self._middleware.spin_once(_STEP_NS)
            except CallbackError as error:
                if not self._lasts:
                    raise
                self._launcher.get_logger().error(str(error), throttle_duration_sec=10.0)
            self.processes.poll()
        return True

    @property
    def manager_failure(self) -> str:
        """How the managing system has failed, in a sentence; empty if it has not. The system goes on without it."""
        return self.processes.manager_failure(MANAGER_PROCESS)

    def check(self, *, managed: bool) -> None:
        """Check that the processes that the experiment needs are running.

        Args:
            managed: whether the managed nodes must run too. A node that was shut down through its lifecycle may be
                restarted.
        """
        for node in (*self.essential, *(self._managed if managed else ())):
            needed = node in self.essential or self.processes.has_failed(node)
            if needed and not self.processes.is_running(node):
                end = self.processes.end_of(node)
                raise SunsetError(f"The process of {node}, which the experiment needs, {end}; run it again.")
        # without a managing system that has ended in order, or has failed, the experiment goes on
        if self.processes.has_failed(MANAGER_PROCESS) and not self.manager_failure:
            end = self.processes.end_of(MANAGER_PROCESS)
            raise ManagerError(f"The process of the managing system {self._spec.manager} {end}.")

    def is_disturbed(self) -> bool:
        """Return whether the process of a managed node has ended, and was not redeployed."""
        return not all(map(self.processes.is_running, self._managed))


def _check_discovery() -> None:
    if os.environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").strip() == "OFF":
        raise InvalidInputError(
            "With ROS_AUTOMATIC_DISCOVERY_RANGE=OFF no two processes find each other: unset it, or choose LOCALHOST."
        )


def _absolute(model: str) -> str:
    """Return a model's name, or the absolute path of its folder."""
    return str(Path(model).absolute()) if os.sep in model or Path(model).is_dir() else model
