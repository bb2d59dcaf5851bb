"""Whether redeploys of a live system on a busy computer are what they should be.

Usage: python benchmarks/redeploy_bursts.py [BURSTS [BUSY]], 34 bursts beside 4 busy processes if left out.

In each burst, three processes ask a node each to shut down, as soon as they have found it, and the launcher starts the
nodes anew. Prints for each redeploy how long the new node knew the time before it was active, and its
`lifecycle_activation_delay`; and how the observer of live runs recorded the shutdowns. A node knows the time at the
latest when it begins to configure itself, and 0.1 s before its first heartbeat. Ends with exit code 1 where a delay
is more than 0.3 s off, or a shutdown is not recorded as executed.
"""

import multiprocessing
import subprocess
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from itertools import cycle, islice

from sunset.experiments import RunSpec, Settings, prepare
from sunset.experiments.live import LiveSystem
from sunset.experiments.observer import Observer
from sunset.harness.operator import Operator
from sunset.scenarios import Scenario
from sunset.system import COMMANDS_TOPIC, current_system
from sunset.system_interfaces.msg import Command
from sunset.system_interfaces.srv import Redeploy
from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition, TransitionEvent
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.rmw.dds import CycloneDDS, CycloneTap
from sunset_ros.rmw.dds.domains import free_domain_id

PROCESSES = multiprocessing.get_context("forkserver")
PROCESSES.set_forkserver_preload(["sunset.experiments.live", "sunset.harness.operator", "sunset_ros.rmw.dds"])
AT_ONCE = 3
ACTIVE = ("camera", "depth", "sensor_fusion", "segmentation")
DELAYS: dict[str, float] = {node: current_system().nodes[node].activation_delay_s for node in ACTIVE}
HEARTBEAT_S = 0.1
TOLERANCE_S = 0.3
LIMIT_S = 120.0


class Record:
    """Keeps what tells how far nodes are, and the shutdowns."""

    def __init__(self) -> None:
        self._steps: dict[str, list[tuple[int, str]]] = defaultdict(list)
        self.shutdowns: list[Command] = []

    def write(self, topic: str, time_ns: int, message: Message) -> None:
        """Keep one message."""
        if isinstance(message, DiagnosticArray):
            (status,) = message.status
            self._steps[status.hardware_id].append((time_ns, "heartbeat"))
        elif isinstance(message, TransitionEvent):
            self._steps[topic.split("/")[-2]].append((time_ns, message.goal_state.label))
        elif topic == COMMANDS_TOPIC and isinstance(message, Command) and message.kind == "shutdown":
            self.shutdowns.append(message)

    def first(self, node: str, step: str, since_ns: int) -> float:
        """Return when a step of a node came first since a moment [s], 0 if it did not."""
        times = (time_ns / 1e9 for time_ns, what in self._steps[node] if what == step and time_ns >= since_ns)
        return next(times, 0.0)

    def knew_time(self, node: str, since_ns: int) -> float:
        """Return when a node that was started since a moment knew the time at the latest [s]."""
        heartbeat = self.first(node, "heartbeat", since_ns) - HEARTBEAT_S
        return min(heartbeat, self.first(node, "configuring", since_ns) or heartbeat)


@contextmanager
def busy_processes(count: int) -> Iterator[None]:
    """Keep the processor busy."""
    with ExitStack() as stack:
        for _ in range(count):
            process = stack.enter_context(subprocess.Popen([sys.executable, "-c", "while True: pass"]))
            stack.callback(process.kill)
        yield


def ask_to_shut_down(domain_id: int, name: str) -> None:
    """Ask a node to shut down as soon as it is found, and wait for the answer."""
    with CycloneDDS(domain_id=domain_id) as middleware:
        context = Context()
        context.init([], middleware=middleware)
        node = Node("_client", context=context)
        client = node.create_client(ChangeState, f"/managed_subsystem/{name}/change_state")
        client.wait_for_service(LIMIT_S)
        future = client.call_async(ChangeState.Request(transition=Transition(label="shutdown")))
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        executor.spin_until_future_complete(future, LIMIT_S)


def shut_down(system: LiveSystem, nodes: list[str]) -> None:
    """Let a new process each ask the nodes to shut down, and wait until they have ended."""
    clients = [PROCESSES.Process(target=ask_to_shut_down, args=(system.domain_id, node)) for node in nodes]
    for client in clients:
        client.start()
    wait(system, lambda: not any(system.processes.is_running(node) for node in nodes), "the end of the nodes")
    wait(system, lambda: not any(client.is_alive() for client in clients), "the end of the clients")


def wait(system: LiveSystem, predicate: Callable[[], bool], what: str) -> None:
    """Let the system go on until a predicate holds."""
    if not system.spin_until(predicate, LIMIT_S):
        sys.exit(f"{what} did not come within {LIMIT_S:g} s")


def redeploy(system: LiveSystem, node: Node, record: Record, nodes: list[str]) -> dict[str, float]:
    """Shut nodes down and start them anew; return how long each was there before it was active [s]."""
    shut_down(system, nodes)
    start_ns = time.time_ns()
    client = node.create_client(Redeploy, "/launcher/redeploy")
    for name in nodes:
        client.call_async(Redeploy.Request(node=name))

    def are_active() -> bool:
        return all(record.first(name, "active", start_ns) for name in nodes)

    wait(system, are_active, "the activation of the new nodes")
    return {name: record.first(name, "active", start_ns) - record.knew_time(name, start_ns) for name in nodes}


def main(bursts: int, busy: int) -> int:
    """Measure and print; return the exit code."""
    spec = RunSpec(scenario=Scenario("none"), manager="external", settings=Settings(middleware="cyclonedds"))
    resources = prepare(spec)
    record = Record()
    observer = Observer(record)
    worst = 0.0
    names = cycle(ACTIVE)
    with ExitStack() as stack:
        domain_id = stack.enter_context(free_domain_id())
        tap = stack.enter_context(CycloneTap(observer, domain_id=domain_id))
        system = stack.enter_context(LiveSystem(spec, resources, domain_id, loop=True))
        operator = Operator(inject=False, warm_up_s=0.0, context=system.context)
        system.executor.add_node(operator)
        wait(system, lambda: operator.up, "the system")
        first = PROCESSES.Process(target=list)  # it waits until all is imported that the others need
        first.start()
        first.join()
        stack.enter_context(busy_processes(busy))
        for burst in range(bursts):
            found = redeploy(system, operator, record, list(islice(names, AT_ONCE)))
            worst = max(worst, *(abs(seconds - DELAYS[node]) for node, seconds in found.items()))
            cells = [f"{node} {seconds:.2f} ({DELAYS[node]:g})" for node, seconds in found.items()]
            print(f"{burst + 1:3}  {', '.join(cells)}", flush=True)
        tap.finish()
    observer.finish(time.time_ns())
    outcomes = Counter(one.reason or "answered" for one in record.shutdowns)
    executed = sum(one.successful for one in record.shutdowns)
    print(f"farthest from a delay: {worst:.2f} s")
    print(f"shutdowns: {bursts * AT_ONCE}, recorded as executed: {executed} ({dict(outcomes)})")
    return int(worst > TOLERANCE_S or executed < bursts * AT_ONCE)


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:]]
    sys.exit(main(*numbers, *(34, 4)[len(numbers) :]))
