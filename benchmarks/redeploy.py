"""What starting a live system, and redeploying its nodes, costs beyond the nodes' activation delays.

Usage: python benchmarks/redeploy.py [ROUNDS], 5 of each measurement if left out.

Prints medians, in seconds: from the start of `sunset node` until the node is heard of; from that of `sunset up` until
all nodes are up, less the longest activation delay; and for each node from the request to the launcher until its old
process is gone, the new node is heard of, is configured, is active and sends, the last also less the activation delay.
Inputs come every 0.1 s: on average, 0.05 s of that are the wait for one. Last, the memory of all nodes together, where
what several share is counted once.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median

from sunset.experiments import RunSpec, Settings, prepare
from sunset.experiments.live import LiveSystem
from sunset.harness.operator import Operator
from sunset.scenarios import Scenario
from sunset.system import current_system
from sunset.system_interfaces.msg import SensorFusion
from sunset.system_interfaces.srv import Redeploy
from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.rmw.dds import CycloneDDS
from sunset_ros.rmw.dds.domains import free_domain_id

OUTPUTS: dict[str, tuple[type[Message], str]] = {
    "camera": (Image, "rgb_camera"),
    "depth": (Image, "depth_camera"),
    "sensor_fusion": (SensorFusion, "sensors_fused"),
    "segmentation": (Image, "segmentation"),
}
STEPS = ("old gone", "heard", "configured", "active", "output", "beyond delay")
LIMIT_S = 60.0


class Watch(Node):
    """Notes when it heard of each step first since the last `ask`."""

    def __init__(self, system: LiveSystem) -> None:
        super().__init__("_watch", context=system.context)
        self._system = system
        self._client = self.create_client(Redeploy, "/launcher/redeploy")
        self._node = ""
        self._began = 0.0
        self._gone = False
        self.times: dict[str, float] = {}
        self.create_subscription(DiagnosticArray, "/diagnostics", self._on_heartbeat, 50)
        for node, (kind, topic) in OUTPUTS.items():
            self.create_subscription(kind, f"/managed_subsystem/{topic}", partial(self._on_output, node), 10)

    def ask(self, node: str) -> None:
        """Ask for a redeploy."""
        self._node, self._gone, self.times = node, False, {}
        pid = self._system.processes.pid(node)
        self._began = time.perf_counter()
        self._client.call_async(Redeploy.Request(node=node))
        while self._system.processes.pid(node) == pid:
            self._system.spin_until(lambda: False, 0.001)
        self._gone = True
        self._note("old gone")

    def _note(self, step: str) -> None:
        if self._gone:
            self.times.setdefault(step, time.perf_counter() - self._began)

    def _on_heartbeat(self, message: DiagnosticArray) -> None:
        (status,) = message.status
        if status.hardware_id == self._node:
            self._note("heard")
            if status.message == "inactive":
                self._note("configured")
            if status.message == "active":
                self._note("active")

    def _on_output(self, node: str, message: Message) -> None:
        del message
        if node == self._node:
            self._note("output")


def measure(system: LiveSystem, watch: Watch, node: str) -> dict[str, float]:
    """Redeploy a node once; return step → seconds."""
    delay = current_system().nodes[node].activation_delay_s
    watch.ask(node)
    _await(system, lambda: "output" in watch.times, node)
    system.spin_until(lambda: False, 2.0)  # until all is as before
    return watch.times | {"beyond delay": watch.times["output"] - delay}


def _await(system: LiveSystem, predicate: Callable[[], bool], what: str) -> None:
    if not system.spin_until(predicate, LIMIT_S):
        sys.exit(f"{what} did not come within {LIMIT_S:g} s")


def seconds_until_up() -> float:
    """Return how long `sunset up` takes until all nodes are up."""
    with free_domain_id() as domain_id:
        command = [sys.executable, "-m", "sunset", "up", "--domain-id", str(domain_id)]
        began = time.perf_counter()
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:  # noqa: S603  our own
            assert process.stdout is not None  # noqa: S101  a pipe was asked for
            next(line for line in process.stdout if "All nodes are up" in line)
            seconds = time.perf_counter() - began
            process.terminate()
            process.stdout.read()
    return seconds


def seconds_until_heard() -> float:
    """Return how long `sunset node` takes until others hear of it."""
    with free_domain_id() as domain_id, CycloneDDS(domain_id=domain_id) as middleware:
        context = Context()
        context.init([], middleware=middleware)
        heard: list[DiagnosticArray] = []
        node = Node("_watch", context=context)
        node.create_subscription(DiagnosticArray, "/diagnostics", heard.append, 10)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        environment = os.environ | {"ROS_DOMAIN_ID": str(domain_id)}
        began = time.perf_counter()
        with subprocess.Popen([sys.executable, "-m", "sunset", "node", "camera"], env=environment) as process:
            while not heard:
                executor.spin_once(timeout_sec=0.01)
            seconds = time.perf_counter() - began
            process.terminate()
    return seconds


def memory_mb(system: LiveSystem) -> float:
    """Return the memory of all nodes, in MB."""
    total = 0
    for node in system.processes.nodes:
        lines = (
            Path(f"/proc/{system.processes.pid(node)}/smaps_rollup").read_text(encoding="utf-8").splitlines()
        )
        total += sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return total / 1e3


def main(rounds: int) -> None:
    """Measure and print."""
    spec = RunSpec(scenario=Scenario("none"), manager="external", settings=Settings(middleware="cyclonedds"))
    resources = prepare(spec)
    longest = max(current_system().nodes[node].activation_delay_s for node in OUTPUTS)
    print(f"load of the computer: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    print(f"sunset node until it is heard: {median(seconds_until_heard() for _ in range(rounds)):.2f}")
    ups = [seconds_until_up() for _ in range(rounds)]
    print(f"sunset up until all are up: {median(ups):.2f}, beyond the delay {median(ups) - longest:.2f}")
    with free_domain_id() as domain_id, LiveSystem(spec, resources, domain_id, loop=True) as system:
        operator = Operator(inject=False, warm_up_s=0.0, context=system.context)
        system.executor.add_node(operator)
        _await(system, lambda: operator.up, "the system")
        watch = Watch(system)
        system.executor.add_node(watch)
        system.spin_until(lambda: False, 3.0)
        print(f"{'redeploy':16}" + "".join(f"{step:>14}" for step in STEPS))
        for node in OUTPUTS:
            times = [measure(system, watch, node) for _ in range(rounds)]
            cells = [median(one.get(step, float("nan")) for one in times) for step in STEPS]
            print(f"{node:16}" + "".join(f"{cell:14.3f}" for cell in cells), flush=True)
        print(f"memory of {len(system.processes.nodes)} nodes: {memory_mb(system):.0f} MB")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
