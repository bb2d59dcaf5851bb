"""How a live system holds 10 Hz for long: frames lost, latency, and the memory of every process.

Usage: python benchmarks/soak.py [SECONDS], the time that is watched, 600 if left out. It starts `sunset up`, at the
speed of real time. Latency is from the arrival of a raw image to that of its segmentation, both here.
"""

import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median, quantiles
from typing import Any, Final

from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.rmw.dds import CycloneDDS
from sunset_ros.rmw.dds.domains import free_domain_id

WARM_UP_S: Final = 5.0
BRING_UP_S: Final = 60.0
ON_ITS_WAY_S: Final = 1.0
"""How long a frame may take; those that arrive in the last second are not counted."""


class Watch(Node):
    """Notes when each frame arrives, raw and segmented."""

    def __init__(self, context: Context) -> None:
        super().__init__("_soak", context=context, enable_rosout=False)
        self.raw: dict[tuple[int, int], int] = {}
        self.segmented: dict[tuple[int, int], int] = {}
        self.create_subscription(Image, "/rgb_raw", self._noting(self.raw), 100)
        self.create_subscription(Image, "/managed_subsystem/segmentation", self._noting(self.segmented), 100)

    def _noting(self, times: dict[tuple[int, int], int]) -> Callable[[Image], None]:
        def note(image: Image) -> None:
            stamp = image.header.stamp
            times[stamp.sec, stamp.nanosec] = time.monotonic_ns()

        return note


class System:
    """A running `sunset up`, and what it prints."""

    def __init__(self, domain_id: int) -> None:
        command = [sys.executable, "-m", "sunset", "up", "--domain-id", str(domain_id)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)  # noqa: S603
        self.lines: list[str] = []
        threading.Thread(target=self._read, args=(self.process.stdout,), daemon=True).start()

    def _read(self, output: Any) -> None:
        self.lines.extend(iter(output.readline, ""))

    def flies(self) -> bool:
        """Return whether the flight has begun."""
        return any("The flight has begun" in line for line in tuple(self.lines))

    def memory_mb(self) -> dict[str, float]:
        """Return what is resident of each process, in MB."""
        found = (re.match(r"(\w+) .* pid (\d+)", line) for line in tuple(self.lines))
        pids = {match[1]: int(match[2]) for match in found if match} | {"launcher": self.process.pid}
        return {node: _resident_mb(pid) for node, pid in pids.items()}


def _resident_mb(pid: int) -> float:
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text(encoding="utf-8").split()[1])
    except FileNotFoundError:
        return 0.0  # it has ended
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def watch(system: System, node: Watch, executor: SingleThreadedExecutor, seconds: float) -> None:
    """Watch a system that comes up, and print."""

    def spin(limit_s: float, until: Callable[[], bool] = lambda: False) -> None:
        end = time.monotonic() + limit_s
        while time.monotonic() < end and not until():
            executor.spin_once(timeout_sec=0.05)

    spin(BRING_UP_S, system.flies)
    if not system.flies():
        sys.exit("The system did not come up:\n" + "".join(system.lines))
    spin(WARM_UP_S)
    node.raw.clear()
    memory = [system.memory_mb()]
    for _ in range(2):
        spin(seconds / 2)
        memory.append(system.memory_mb())
    end_ns = time.monotonic_ns() - round(ON_ITS_WAY_S * 1e9)
    raw = {stamp: time_ns for stamp, time_ns in node.raw.items() if time_ns < end_ns}
    latencies = [
        (node.segmented[stamp] - time_ns) / 1e6 for stamp, time_ns in raw.items() if stamp in node.segmented
    ]
    print(f"{seconds:.0f} s at 10 Hz, {os.cpu_count()} cores")
    print(f"  {len(raw)} frames, {len(raw) - len(latencies)} of them lost")
    late = quantiles(latencies, n=100)[98]
    print(f"  raw image to segmentation: median {median(latencies):.1f} ms, p99 {late:.1f} ms")
    print(f"  {'resident memory in MB':22}{'start':>8}{'middle':>8}{'end':>8}")
    for name, first in memory[0].items():
        print(f"  {name:22}{first:8.1f}{memory[1].get(name, 0.0):8.1f}{memory[2].get(name, 0.0):8.1f}")


def main() -> None:
    """Start a system, watch it, and end it."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 600.0
    with free_domain_id() as domain_id:
        context = Context()
        context.init([], middleware=CycloneDDS(domain_id=domain_id, environment={}))
        node = Watch(context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        system = System(domain_id)
        try:
            watch(system, node, executor, seconds)
        finally:
            context.shutdown()
            system.process.terminate()
            system.process.wait()


if __name__ == "__main__":
    main()
