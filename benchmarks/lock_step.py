"""What it costs that a managing system has a process of its own: of a callback, of a question, and of a whole run.

Run it with `python benchmarks/lock_step.py`. To compare two versions, run each in turns, with the number of runs and
the managing system that you want: a version without `sunset_ros.rmw.remote` prints the run only.
"""

import argparse
import resource
import socket
import sys
import tempfile
import threading
import time
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from sunset.experiments import RunSpec, prepare
from sunset.experiments.run import run_prepared
from sunset.scenarios import load_scenario
from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.rmw.sim import Simulation

SCENARIO = "paper/gpu_failure+image_degradation+depth_degradation"
BATCH = 20_000


class Listener(Node):
    """Hears messages, and asks the graph as often for each as it was told."""

    def __init__(self, context: Context, questions: int) -> None:
        super().__init__("listener", context=context)
        self.out = self.create_publisher(String, "answers", 10)
        self.questions = questions
        self.create_subscription(String, "/messages", self.hear, 10)

    def hear(self, _: String) -> None:
        """Ask."""
        for _question in range(self.questions):
            self.out.get_subscription_count()


def toy(*, remote: bool, questions: int) -> float:
    """Return how many microseconds of CPU a callback with so many questions takes, of both sides together."""
    simulation = Simulation()
    context = Context()
    context.init([], middleware=simulation.create_process("talker"))
    talker = Node("talker", context=context)
    out = talker.create_publisher(String, "/messages", 10)
    process = simulation.create_process("listener")

    def make(middleware: Any) -> None:
        own = Context()
        own.init([], middleware=middleware)
        SingleThreadedExecutor(context=own).add_node(Listener(own, questions))

    thread = None
    if remote:
        from sunset_ros.rmw.remote import Gateway, Pipe, RemoteProcess  # noqa: PLC0415  older versions have none

        ours, theirs = socket.socketpair()
        thread = threading.Thread(target=lambda: RemoteProcess(Pipe(theirs), make).serve())
        thread.start()
        pipe = Pipe(ours)
        gateway = Gateway(process, pipe, limit_s=60.0, end=process.end)
        gateway.start()
    else:
        make(process)
    process.run()
    start = time.process_time()
    for _ in range(BATCH):
        out.publish(String(data="hello"))
        simulation.run_until(simulation.now + 1_000_000)
    used = time.process_time() - start
    if thread is not None:
        pipe.close()
        thread.join()
        theirs.close()
    return used / BATCH * 1e6


def cpu_s() -> float:
    """Return the processor time of this process and of those that it has waited for."""
    uses = [resource.getrusage(whose) for whose in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(use.ru_utime + use.ru_stime for use in uses)


def watch_managers(log: Path) -> None:
    """Write the processor time and the memory of each managing system's process, when it ends, into a file."""
    from sunset.processes.process import Process  # noqa: PLC0415  older versions have none

    end = Process.kill

    def say_and_end(process: Process) -> None:
        nanoseconds = int(Path(f"/proc/{process.pid}/schedstat").read_text(encoding="ascii").split()[0])
        lines = Path(f"/proc/{process.pid}/smaps_rollup").read_text(encoding="ascii").splitlines()[1:]
        pages = {line.split()[0]: int(line.split()[1]) for line in lines}
        with log.open("a", encoding="ascii") as file:
            file.write(f"{nanoseconds / 1e9} {pages['Pss:']} {pages['Private_Dirty:']}\n")
        end(process)

    vars(sys.modules[Process.__module__])["Process"].kill = say_and_end


def fly(runs: int, manager: str) -> None:
    """Print the processor time of a warm run."""
    spec = RunSpec(scenario=load_scenario(SCENARIO), manager=manager, seed=1)
    resources = prepare(spec)
    with tempfile.TemporaryDirectory() as folder:
        has_process = find_spec("sunset_ros.rmw.remote") is not None
        log = Path(folder) / "log"
        if has_process:
            watch_managers(log)
        used = []
        for number in range(runs + 1):
            start = cpu_s()
            run_prepared(spec, resources, Path(folder) / f"{number}")
            used.append(cpu_s() - start)
        theirs = [0.0] * len(used)
        if has_process:
            rows = [line.split() for line in log.read_text(encoding="ascii").splitlines()]
            theirs = [float(row[0]) for row in rows]
            shared, own = (max(int(row[column]) for row in rows) / 1024 for column in (1, 2))
            print(f"memory of the managing system's process: {shared:.0f} MB, {own:.0f} of it its own")
    whole = sorted(ours + his for ours, his in zip(used[1:], theirs[1:], strict=True))
    print(
        f"a warm run with {manager}: {whole[0]:.3f} s of CPU at best, {whole[len(whole) // 2]:.3f} in the middle, "
        f"{min(theirs[1:]):.3f} of it the managing system's"
    )


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--manager", default="baseline")
    arguments = parser.parse_args()
    if find_spec("sunset_ros.rmw.remote") is not None and sys.platform == "linux":
        here, there = (toy(remote=remote, questions=0) for remote in (False, True))
        asked_here, asked_there = (toy(remote=remote, questions=10) for remote in (False, True))
        print(f"a callback: {here:.0f} µs in the simulation's process, {there:.0f} µs in one of its own")
        print(f"a question: {(asked_here - here) / 10:.1f} µs, {(asked_there - there) / 10:.1f} µs")
    fly(arguments.runs, arguments.manager)


if __name__ == "__main__":
    main()
