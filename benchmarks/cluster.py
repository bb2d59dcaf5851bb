"""Whether a campaign on a cluster that fails has the results of one that does not.

Run it with `python benchmarks/cluster.py` (extra `cluster`). On this computer it starts a scheduler of dask and two
workers, runs a campaign on them, kills a worker in the middle, then the scheduler, starts both again and continues. It
prints how many runs each part did, and whether all files are byte for byte those of the same campaign with `--jobs 2`.
"""

import argparse
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import sunset

PATIENCE_S = 120


def campaign(out: Path, scenarios: int, *options: str) -> list[str]:
    """Return the command of a campaign of short runs: two managing systems and three repetitions of each scenario."""
    names = ",".join(sunset.list_scenarios("paper")[:scenarios])
    command = [sys.executable, "-m", "sunset", "bench", "--suite", "paper", "--scenarios", names]
    command += [
        "--managers",
        "none,baseline",
        "--repetitions",
        "3",
        "--duration",
        "1",
        "--no-references",
        "--no-score",
    ]
    return [*command, *options, "--out", str(out)]


class Cluster:
    """A scheduler and workers, each a process of this computer that listens on loopback only."""

    def __init__(self, folder: Path) -> None:
        with socket.create_server(("127.0.0.1", 0)) as free:
            self._port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self._port}"
        self._folder = folder
        self.processes: list[subprocess.Popen[bytes]] = []

    def start(self, workers: int) -> None:
        """Start it, and wait until the scheduler listens.

        Raises:
            SystemExit: that takes too long.
        """
        self._run("scheduler", "--host", "127.0.0.1", "--port", str(self._port), "--no-dashboard")
        until = time.monotonic() + PATIENCE_S
        while not self._listens():
            if time.monotonic() > until:
                sys.exit(f"No scheduler of dask listened at {self.address} in {PATIENCE_S} s.")
            time.sleep(0.1)  # noqa: TID251  a real process is waited for
        for _ in range(workers):
            self.add_worker()

    def _listens(self) -> bool:
        with socket.socket() as tried:
            return tried.connect_ex(("127.0.0.1", self._port)) == 0

    def add_worker(self) -> None:
        """Start one more worker, which nobody starts again when it is killed."""
        place = str(self._folder)
        options = (
            "--host",
            "127.0.0.1",
            "--no-nanny",
            "--nthreads",
            "1",
            "--no-dashboard",
            "--local-directory",
            place,
        )
        self._run("worker", self.address, *options)

    def kill(self, number: int) -> None:
        """Kill the scheduler (0) or a worker, in the order in which they were started."""
        process = self.processes.pop(number)
        process.send_signal(signal.SIGKILL)
        process.wait()

    def close(self) -> None:
        """Kill all."""
        while self.processes:
            self.kill(0)

    def _run(self, *words: str) -> None:
        dask = str(Path(sys.executable).parent / "dask")
        self.processes.append(
            subprocess.Popen([dask, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # noqa: S603  the command is ours
        )


def records(out: Path) -> int:
    """Return how many runs are finished."""
    return sum(1 for _ in out.glob("runs/*/*/*/*/run.json"))


def wait_for(out: Path, runs: int, process: "subprocess.Popen[str]") -> None:
    """Wait until so many runs are finished.

    Raises:
        SystemExit: the campaign has ended before, or that takes too long.
    """
    until = time.monotonic() + PATIENCE_S
    while records(out) < runs:
        if process.poll() is not None or time.monotonic() > until:
            sys.exit(f"{records(out)} runs were finished, {runs} were waited for.")
        time.sleep(0.1)  # noqa: TID251  real processes are waited for


def content_of(folder: Path) -> dict[str, bytes]:
    """Return the content of each file in a folder, but of those that tell who works in it."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not path.name.startswith(".lock")
    }


def run_disturbed(command: Sequence[str], out: Path, cluster: Cluster, runs: int) -> None:
    """Run a campaign on a cluster, kill a worker after a third of the runs and the scheduler after two."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)  # noqa: S603  the command is ours
    with process:
        wait_for(out, runs // 3, process)
        cluster.kill(1)
        print(f"{records(out)} of {runs} runs done: one of two workers is killed")
        wait_for(out, 2 * runs // 3, process)
        cluster.kill(0)
        print(f"{records(out)} of {runs} runs done: the scheduler is killed")
        _, told = process.communicate(timeout=PATIENCE_S)
    print(f"exit code {process.returncode}: {told.strip().splitlines()[-1]}")


def main() -> None:
    """Run both campaigns and compare."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenarios", type=int, default=34, help="of the suite paper; each is six runs")
    scenarios = parser.parse_args().scenarios
    runs = 6 * scenarios
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="sunset-")))
        undisturbed, disturbed = folder / "undisturbed", folder / "disturbed"
        subprocess.run(campaign(undisturbed, scenarios, "--jobs", "2"), check=True, capture_output=True)  # noqa: S603  the command is ours
        cluster = Cluster(folder / "dask")
        stack.callback(cluster.close)
        cluster.start(workers=2)
        command = campaign(disturbed, scenarios, "--scheduler", cluster.address)
        run_disturbed(command, disturbed, cluster, runs)
        cluster.close()
        cluster.start(workers=2)
        subprocess.run(command, check=True, capture_output=True)  # noqa: S603  the command is ours
        print(f"{records(disturbed)} of {runs} runs done: the same command has continued")
        ours, theirs = content_of(disturbed), content_of(undisturbed)
        differing = sorted(name for name in ours.keys() | theirs.keys() if ours.get(name) != theirs.get(name))
        if differing:
            sys.exit(f"{len(differing)} of {len(theirs)} files differ, {differing[0]} for one.")
        print(f"all {len(theirs)} files are byte for byte those of the campaign with --jobs 2")


if __name__ == "__main__":
    main()
