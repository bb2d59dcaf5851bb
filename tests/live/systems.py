"""What tests of processes need: the whole system in a domain of its own, and a node that asks it."""

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.rmw.dds import CycloneDDS
from sunset_ros.rmw.dds.domains import free_domain_id

_UP = "The flight has begun"
PATIENCE_S = 60.0
"""A test that waits longer for what must happen has failed."""


def eventually(predicate: Callable[[], bool], pause: Callable[[], object] | None = None) -> bool:
    """Wait until a predicate holds; return whether it does."""
    end = time.monotonic() + PATIENCE_S
    while not predicate():
        if time.monotonic() >= end:
            return False
        (pause or (lambda: threading.Event().wait(0.02)))()
    return True


def exists(pid: int) -> bool:
    """Return whether a process runs, or is stopped; one that has ended and is not yet buried does not."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


class Tool:
    """A node of the test in the system's domain."""

    def __init__(self, domain_id: int) -> None:
        context = Context()
        context.init([], middleware=CycloneDDS(domain_id=domain_id), log_to_stderr=False)
        self.node = Node("_tool", context=context)
        self.executor = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)

    def spin(self, until: Callable[[], bool]) -> bool:
        """Run callbacks until a predicate holds; return whether it does."""
        return eventually(until, lambda: self.executor.spin_once(timeout_sec=0.02))

    def call(self, service: type[Any], name: str, request: Message) -> Any:
        """Ask a service as soon as it is there, and wait for the response."""
        client = self.node.create_client(service, name)
        futures: list[Any] = []

        def answered() -> bool:
            if not futures and client.service_is_ready():
                futures.append(client.call_async(request))
            return bool(futures) and futures[0].done()

        assert self.spin(answered), f"{name} " + ("did not answer" if futures else "was not found")
        self.node.destroy_client(client)
        return futures[0].result()


class Flow:
    """Counts what the segmentation sends."""

    def __init__(self, tool: Tool) -> None:
        self.tool = tool
        self.count = 0
        tool.node.create_subscription(Image, "/managed_subsystem/segmentation", self._note, 10)

    def _note(self, message: Image) -> None:
        del message
        self.count += 1

    def lasts(self) -> bool:
        """Wait until frames have come for so long that a managing system must have seen it."""
        due = self.count + 10
        return self.tool.spin(lambda: self.count >= due)


class Up:
    """A running `sunset up`."""

    def __init__(self, domain_id: int, *arguments: str) -> None:
        command = [sys.executable, "-m", "sunset", "up", "--domain-id", str(domain_id), *arguments]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
        )
        self.lines: list[str] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout:
            self.lines.extend(iter(self.process.stdout.readline, ""))

    @property
    def pids(self) -> dict[str, int]:
        """Node → the last process that it had."""
        found = (re.match(r"(\w+) .* pid (\d+)", line) for line in tuple(self.lines))
        return {match[1]: int(match[2]) for match in found if match}

    def state(self, node: str) -> str:
        """Return what was told of a node last."""
        told = [line for line in tuple(self.lines) if line.startswith(f"{node} ")]
        return told[-1].split(maxsplit=1)[1].strip() if told else ""

    def tells(self, text: str) -> bool:
        """Wait for a line with a text; return whether it came."""
        return eventually(lambda: any(text in line for line in tuple(self.lines)))

    def is_up(self) -> bool:
        """Wait until all nodes are up; return whether they are."""
        return self.tells(_UP)

    def end(self, number: int) -> int:
        """Send a signal, and return the exit code."""
        self.process.send_signal(number)
        code = self.process.wait(PATIENCE_S)
        self._reader.join(PATIENCE_S)
        return code


@contextmanager
def going_up(*arguments: str, until: str = _UP) -> Iterator[tuple[Up, Tool]]:
    """Run `sunset up` and a tool in a domain of their own; whatever happens, nothing is left running."""
    with free_domain_id() as domain_id:
        system = Up(domain_id, *arguments)
        tool = Tool(domain_id)
        try:
            assert system.tells(until), "".join(system.lines)
            yield system, tool
        finally:
            tool.node.context.try_shutdown()
            system.process.kill()
            system.process.wait()
            pids = system.pids.values()
            eventually(lambda: not any(exists(pid) for pid in pids))
            left = [pid for pid in pids if exists(pid)]
            for pid in left:
                os.kill(pid, signal.SIGKILL)
            assert left == []


_SHORT = """
import json, sys
from pathlib import Path
from sunset.errors import SunsetError
from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.scenarios import load_scenario

scenario, manager, seconds, out, speed = sys.argv[1:]
timing = Timing(duration_s=float(seconds), warm_up_s=1.0)
spec = RunSpec(
    scenario=load_scenario(scenario), manager=manager,
    settings=Settings(middleware="cyclonedds", timing=timing, cache=False, loop=True, speed=float(speed)),
)
try:
    result = run(spec, Path(out))
except SunsetError as error:
    sys.exit(str(error))
print(json.dumps(result.summary()))
"""


_CAMPAIGN = """
import sys
from pathlib import Path
from sunset.experiments import BenchSpec, Settings, Timing, bench

out, manager, limit_s = sys.argv[1:]
timing = Timing(duration_s=1.0, warm_up_s=1.0, bring_up_limit_s=float(limit_s))
spec = BenchSpec(
    suite="nofault", references=False, score=False, managers=(manager,), repetitions=2,
    settings=Settings(timing=timing, middleware="cyclonedds"),
)
bench(spec, Path(out))
"""


@contextmanager
def flying(
    scenario: str,
    manager: str,
    seconds: float,
    out: Path,
    domain_id: int | None = None,
    *,
    speed: float = 1.0,
) -> Iterator[subprocess.Popen[str]]:
    """Fly a short live run in a process; whatever happens, nothing is left running."""
    with _running([_SHORT, scenario, manager, str(seconds), str(out), str(speed)], domain_id) as process:
        yield process


@contextmanager
def benching(
    out: Path, manager: str = "none", *, bring_up_limit_s: float = 60.0, domain_id: int | None = None
) -> Iterator[subprocess.Popen[str]]:
    """Fly a campaign of two short live runs in a process; whatever happens, nothing is left running."""
    with _running([_CAMPAIGN, str(out), manager, str(bring_up_limit_s)], domain_id) as process:
        yield process


@contextmanager
def commanding(*words: str) -> Iterator[subprocess.Popen[str]]:
    """Run a command that flies live; whatever happens, nothing is left running."""
    with _running(
        ["import sys; from sunset.cli import main; sys.exit(main(sys.argv[1:]))", *words]
    ) as process:
        yield process


@contextmanager
def _running(program: list[str], domain_id: int | None = None) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-c", *program],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env=os.environ | ({} if domain_id is None else {"ROS_DOMAIN_ID": str(domain_id)}),
    )
    nodes: dict[str, int] = {}
    try:
        assert eventually(lambda: set(children(process.pid)) >= {*MANAGED, *ESSENTIAL})
        nodes |= children(process.pid)
        yield process
    finally:
        nodes |= children(process.pid)
        process.kill()
        process.communicate()
        pids = nodes.values()
        assert eventually(lambda: not any(exists(pid) for pid in pids))


ESSENTIAL = ("bag_player", "monitor", "evaluator", "scenario_executor")
MANAGED = ("camera", "depth", "image_enhancement", "sensor_fusion", "segmentation")


def children(pid: int) -> dict[str, int]:
    """Return node → process of those that a process has started, or let its fork server start."""
    found = {}
    for child in _started_by(pid):
        words = _words(child)
        if "node" in words:
            found[next(word for word in words[words.index("node") + 1 :] if word[:2] != "--")] = child
        else:
            found |= children(child)
    return found


def fork_server(pid: int) -> int:
    """Return the process that a live system in a process forks its nodes from."""
    (server,) = (
        child for child in _started_by(pid) if "sunset.harness.node_process:run_forked" in _words(child)
    )
    return server


def domain_of(pid: int) -> int:
    """Return the domain of a live system in a process, which holds the file with the domain's parameters open."""
    held = {found[1] for file in _files(pid) if (found := re.fullmatch(r"domain-(\d+)\.yaml", file.name))}
    (domain_id,) = held
    return int(domain_id)


def _files(pid: int) -> Iterator[Path]:
    for link in Path(f"/proc/{pid}/fd").iterdir():
        with suppress(FileNotFoundError):  # it was closed meanwhile
            yield link.readlink()


def _words(pid: int) -> list[str]:
    try:
        return Path(f"/proc/{pid}/cmdline").read_text(encoding="utf-8").replace("\0", " ").split()
    except (FileNotFoundError, ProcessLookupError):
        return []  # it has ended meanwhile


def _started_by(pid: int) -> list[int]:
    try:
        tasks = list(Path(f"/proc/{pid}/task").glob("*/children"))
        return [int(child) for task in tasks for child in task.read_text(encoding="utf-8").split()]
    except (FileNotFoundError, ProcessLookupError):
        return []
