"""What a redeploy and a start of the live system cost beyond the nodes' activation delays.

Usage: python benchmarks/redeploy.py [ROUNDS], 5 redeploys of each managed node if left out.

Prints, in seconds: from the start of the system until all nodes are up, less the longest activation delay; and as
medians for each node from the request to the launcher until its old process is gone, the new node is heard of first,
is configured, and its first message comes, the last less the activation delay. A message comes every 0.1 s, so that
0.05 s of the last are the wait for an input on average.
"""

import os
import sys
import time
from collections.abc import Callable
from functools import partial
from statistics import median

from sunset.experiments import RunSpec, prepare
from sunset.experiments.live import LiveSystem
from sunset.experiments.operator import Operator
from sunset.interfaces import Message
from sunset.interfaces.diagnostic_msgs.msg import DiagnosticArray
from sunset.interfaces.sensor_msgs.msg import Image
from sunset.interfaces.system_interfaces.msg import SensorFusion
from sunset.interfaces.system_interfaces.srv import Redeploy
from sunset.nodes import NODES
from sunset.rmw.domains import free_domain_id
from sunset.ros import Node
from sunset.scenarios import Scenario

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
    delay = NODES[node].lifecycle_activation_delay.default  # type: ignore[attr-defined]
    watch.ask(node)
    _await(system, lambda: "output" in watch.times, node)
    system.spin_until(lambda: False, 2.0)  # until all is as before
    return watch.times | {"beyond delay": watch.times["output"] - delay}


def _await(system: LiveSystem, predicate: Callable[[], bool], what: str) -> None:
    if not system.spin_until(predicate, LIMIT_S):
        sys.exit(f"{what} did not come within {LIMIT_S:g} s")


def main(rounds: int) -> None:
    """Measure and print."""
    spec = RunSpec(scenario=Scenario("none"), manager="external", middleware="cyclonedds")
    resources = prepare(spec)
    print(f"load of the computer: {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    with free_domain_id() as domain_id:
        began = time.perf_counter()
        with LiveSystem(spec, resources, domain_id, loop=True) as system:
            operator = Operator(inject=False, warm_up_s=0.0, context=system.context)
            system.executor.add_node(operator)
            _await(system, lambda: operator.up, "the system")
            print(
                f"start until all are up, beyond the longest delay: {time.perf_counter() - began - 4.0:.2f} s"
            )
            watch = Watch(system)
            system.executor.add_node(watch)
            system.spin_until(lambda: False, 3.0)
            print(f"{'median of ' + str(rounds):16}" + "".join(f"{step:>14}" for step in STEPS))
            for node in OUTPUTS:
                times = [measure(system, watch, node) for _ in range(rounds)]
                cells = [median(one.get(step, float("nan")) for one in times) for step in STEPS]
                print(f"{node:16}" + "".join(f"{cell:14.3f}" for cell in cells), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
