"""A simulated world for tests: real nodes, real services, virtual time."""

import fcntl
import gc
import os
import signal
from collections import defaultdict
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import pytest
from hypothesis import settings

from sunset.data import cache_folder, default_flight
from sunset_ros import Context, Node, Parameter, SingleThreadedExecutor
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.msg import SetParametersResult
from sunset_ros.interfaces.rcl_interfaces.srv import SetParameters
from sunset_ros.rmw.core.port import EndpointKind, qualified_name
from sunset_ros.rmw.sim import SimProcess, Simulation, Tap

NodeT = TypeVar("NodeT", bound=Node)

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as a shell does for what it starts with "&"
    signal.signal(signal.SIGINT, signal.default_int_handler)  # tests, and what they start, are interrupted


for name in ("FORCE_COLOR", "NO_COLOR", "TTY_COMPATIBLE", "COLUMNS", "LINES"):
    os.environ.pop(name, None)  # who runs the tests may have set how rich draws

settings.register_profile("untimed", deadline=None)  # a busy computer is no failure
settings.load_profile("untimed")

LARGE = tuple(Path(__file__).parent / name for name in ("bundling", "cli/test_models.py", "data", "viewing"))
LARGE += (Path(__file__).parents[1] / "packages/lab/tests",)


@cache
def leaves_a_large_process(path: Path) -> bool:
    """Whether the tests of a file leave their process large."""
    return any(map(path.is_relative_to, LARGE))


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--first-cases", action="store_true", help="run each test with the first of its cases only"
    )


@pytest.hookimpl(trylast=True)  # when -m has chosen
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    # a large process takes long to be forked, and most tests fork it; a group is run by one process, while others help
    items.sort(
        key=lambda item: (
            leaves_a_large_process(item.path),
            item.get_closest_marker("xdist_group") is None,
        )
    )
    if config.getoption("--first-cases"):
        first = {item.nodeid.partition("[")[0]: item for item in reversed(items)}
        left_out = [item for item in items if first[item.nodeid.partition("[")[0]] is not item]
        items[:] = [item for item in items if first[item.nodeid.partition("[")[0]] is item]
        config.hook.pytest_deselected(items=left_out)


def pytest_collection_finish() -> None:
    gc.collect()
    gc.freeze()  # the garbage collector would look at thousands of tests again and again, in each forked process, too


class World:
    """A simulation, a node `/tester` that publishes and calls, and a record of what was published.

    Callbacks take no modelled time but the simulation's 0.2 ms, so that times in tests are easy to tell.
    """

    def __init__(self) -> None:
        self.sim = Simulation(seed=1, compute={}, jitter=0.0)
        self.messages: dict[str, list[Any]] = defaultdict(list)
        self.times: dict[str, list[float]] = defaultdict(list)
        self.sim.add_tap(_Recorder(self))
        self._processes: dict[str, SimProcess] = {}
        self._publishers: dict[str, Any] = {}
        self.tester = self.start(Node, "tester")

    @property
    def now(self) -> float:
        """Virtual time in seconds."""
        return self.sim.now / 1e9

    def publishers_of(self, node: str) -> list[tuple[str, str]]:
        """Return (topic, type) of the publishers of a node, given by its fully qualified name."""
        return self._of(node, EndpointKind.PUBLISHER)

    def subscriptions_of(self, node: str) -> list[tuple[str, str]]:
        """Return (topic, type) of the subscriptions of a node, given by its fully qualified name."""
        return self._of(node, EndpointKind.SUBSCRIPTION)

    def _of(self, node: str, kind: EndpointKind) -> list[tuple[str, str]]:
        return [
            (info.name, info.type_name)
            for info in self.sim.endpoints()
            if info.kind is kind and qualified_name(info.node_namespace, info.node_name) == node
        ]

    def start(
        self,
        node_class: Callable[..., NodeT],
        *arguments: object,
        parameters: Mapping[str, object] | None = None,
        **options: object,
    ) -> NodeT:
        """Start a process with a node; a later one of the same name is a redeployed one."""
        process = self.sim.create_process(getattr(node_class, "__name__", "node"))
        context = Context()
        context.init([], middleware=process)
        overrides = [Parameter(name, value=value) for name, value in (parameters or {}).items()]
        node = node_class(*arguments, context=context, parameter_overrides=overrides, **options)
        SingleThreadedExecutor(context=context).add_node(node)
        process.run()
        self._processes[node.get_name()] = process
        return node

    def run(self, seconds: float) -> None:
        """Let virtual time pass."""
        self.sim.run_until(self.sim.now + round(seconds * 1e9))

    def kill(self, name: str) -> None:
        """End a node's process at once."""
        self.sim.kill(self._processes[name])

    def publish(self, topic: str, message: Message) -> None:
        """Publish a message as `/tester`; it arrives when time passes."""
        if topic not in self._publishers:
            self._publishers[topic] = self.tester.create_publisher(type(message), topic, 10)
        self._publishers[topic].publish(message)

    def call(self, service: type[Any], name: str, request: object, *, within: float = 0.05) -> Any:
        """Call a service as `/tester`; return its response, or None if there was none in that time."""
        client = self.tester.create_client(service, name)
        future = client.call_async(request)
        self.run(within)
        return future.result()

    def set(self, node: str, name: str, value: object) -> SetParametersResult:
        """Set a parameter of a managed node through its service."""
        parameter = Parameter(name, value=value).to_parameter_msg()
        request = SetParameters.Request(parameters=[parameter])
        response = self.call(SetParameters, f"/managed_subsystem/{node}/set_parameters", request)
        result: SetParametersResult = response.results[0]
        return result

    def transition(self, node: str, label: str) -> bool:
        """Take a managed node through a transition; return whether it went."""
        request = ChangeState.Request(transition=Transition(label=label))
        return bool(self.call(ChangeState, f"/managed_subsystem/{node}/change_state", request).success)


class _Recorder(Tap):
    def __init__(self, world: World) -> None:
        self._world = world

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
        del node
        self._world.messages[topic].append(message)
        self._world.times[topic].append(time_ns / 1e9)


@pytest.fixture
def world() -> World:
    return World()


@pytest.fixture(scope="session")
def flight() -> Path:
    """The default flight, rendered by one of the test processes if it is not in the cache yet."""
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".tests.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return default_flight()
