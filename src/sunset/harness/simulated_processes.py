"""The processes of nodes in a simulation."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import TypeVar

from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.rmw.sim import SimProcess, Simulation

NodeFactory = Callable[[Context], Node]
Around = Callable[[Callable[[], None]], None]
NodeT = TypeVar("NodeT", bound=Node)


class SimulatedProcesses:
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
        """Start a node in a new process, and let its callbacks run."""
        self._running[node] = process = self._simulation.create_process(node, around=self._around.get(node))
        self._simulation.on_exit(process, lambda _: self._ended(node))
        bring_up(process, self._factories[node])

    def is_running(self, node: str) -> bool:
        """Return whether the process of a node exists."""
        return node in self._running

    def kill(self, node: str) -> None:
        """End the process of a node at once."""
        self._simulation.kill(self._running[node])

    def _ended(self, node: str) -> None:
        del self._running[node]
        self.on_exit(node)


def bring_up(process: SimProcess, factory: Callable[[Context], NodeT]) -> NodeT:
    """Make a node in a new process, and let its callbacks run."""
    context = Context()
    context.init([], middleware=process)
    node = factory(context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    process.run()
    return node
