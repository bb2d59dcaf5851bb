from collections.abc import Callable
from typing import Any, TypeVar

import pytest

from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.rmw.sim import SimProcess, Simulation

NodeT = TypeVar("NodeT", bound=Node)


class World:
    """A simulation, and nodes that each run in a process of their own."""

    def __init__(self) -> None:
        self.simulation = Simulation()
        self.processes: dict[str, SimProcess] = {}

    def context(self, name: str = "process", arguments: list[str] | None = None) -> Context:
        context = Context()
        self.processes[name] = self.simulation.create_process(name)
        context.init(arguments or [], middleware=self.processes[name])
        return context

    def run(self, node: NodeT) -> NodeT:
        executor = SingleThreadedExecutor(context=node.context)
        executor.add_node(node)
        middleware = node.context.middleware
        assert isinstance(middleware, SimProcess)
        middleware.run()
        return node

    def node(self, name: str = "node", arguments: list[str] | None = None, **options: Any) -> Node:
        return self.run(Node(name, context=self.context(name, arguments), **options))

    def make(self, kind: Callable[..., NodeT], arguments: list[str] | None = None, **options: Any) -> NodeT:
        return self.run(kind(context=self.context(kind.__name__, arguments), **options))

    def pass_time(self, seconds: float) -> None:
        self.simulation.run_until(self.simulation.now + round(seconds * 1e9))


@pytest.fixture
def world() -> World:
    return World()
