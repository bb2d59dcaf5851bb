"""Tests of nodes in virtual time: each node runs in a simulated process, and nothing waits.

>>> from sunset_ros import Node
>>> world = World()
>>> node = world.start(Node, "clockwork")
>>> _ = node.create_timer(0.5, lambda: print(f"tick at {world.now:.1f} s"))
>>> world.run(1.2)
tick at 0.5 s
tick at 1.0 s
"""

from collections import defaultdict
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from sunset_ros.context import Context, default_context
from sunset_ros.executors import SingleThreadedExecutor
from sunset_ros.interfaces import Message
from sunset_ros.node import Node
from sunset_ros.rmw.core.tap import Tap
from sunset_ros.rmw.sim import Simulation

NodeT = TypeVar("NodeT", bound=Node)


class World(Tap):
    """A network in a `sunset_ros.rmw.sim.Simulation`, which takes the options, with a record of its messages."""

    def __init__(self, **options: Any) -> None:
        self.simulation = Simulation(**options)
        self.simulation.add_tap(self)
        self._messages: dict[str, list[Any]] = defaultdict(list)

    @property
    def now(self) -> float:
        """Virtual time in seconds."""
        return self.simulation.now / 1e9

    def start(
        self,
        node_class: Callable[..., NodeT],
        *arguments: object,
        args: Sequence[str] = (),
        **options: object,
    ) -> NodeT:
        """Start a process with a node, which `node_class(*arguments, **options)` makes.

        The process has the default context while the node is made, so that the class need not take a context.
        `args` is its command line, such as `["--ros-args", "-p", "rate:=10"]`.
        """
        process = self.simulation.create_process(getattr(node_class, "__name__", "node"))
        context = Context()
        context.init(args, middleware=process)
        with default_context(context):
            node = node_class(*arguments, **options)
        SingleThreadedExecutor(context=context).add_node(node)
        process.run()
        return node

    def run(self, seconds: float) -> None:
        """Let virtual time pass; raise a `CallbackError` if a callback of a node raised."""
        self.simulation.run_until(self.simulation.now + round(seconds * 1e9))

    def messages(self, topic: str) -> list[Any]:
        """Return all messages that were published on a topic until now."""
        return list(self._messages[topic])

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        """Record a message."""
        del time_ns, node
        self._messages[topic].append(message)
