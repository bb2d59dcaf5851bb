"""Measure how much work a training loses when it is interrupted, in every phase, by SIGTERM and by SIGKILL.

Usage: python benchmarks/interrupted_training.py [--frames N] [--steps N] [--wait S]. It needs the extra `train`.

A training is started and gets a signal some seconds after the phase has begun; what it lost is the time between the
last result that it kept and the signal. It is resumed for the next phase, and at last to its end. Then its networks are
compared with those of a training that was not interrupted.
"""

import argparse
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

PHASES = {
    "rendering": "frames/*/partial.json",
    "training": "networks/checkpoint.pt",
    "exporting": "finish/kept/*/*.npz",
    "calibrating": "finish/draft/.calibrating-*",
}
"""What is there when a phase has something to lose."""
KEPT = ("frames/*/*.json", "networks/checkpoint.pt", "finish/kept/*/*.npz")


def training(folder: Path, options: Sequence[str]) -> list[str]:
    """Return the command of a training into a folder."""
    paths = ("--work", str(folder / "work"), "--out", str(folder / "model"))
    return [sys.executable, "-m", "sunset", "train", "--resume", *paths, *options]


def seconds_lost(command: Sequence[str], work: Path, phase: str, number: int, wait_s: float) -> float | None:
    """Send a signal to a training in a phase, and return how old what it kept last was; None if it came too late."""
    started = time.perf_counter()
    process = subprocess.Popen(command, stderr=subprocess.DEVNULL)  # noqa: S603  the command is our own
    began = None
    while process.poll() is None:
        if began is None and any(_written(path) > 0 for path in work.glob(PHASES[phase])):
            began = time.perf_counter()
        if began is not None and time.perf_counter() - max(began, started) >= wait_s:
            now = _now(work)
            process.send_signal(number)
            process.wait()
            last = max((_written(path) for pattern in KEPT for path in work.glob(pattern)), default=now)
            return max(0.0, now - last)
        time.sleep(0.1)  # noqa: TID251  nothing is simulated here
    if process.returncode != 0:
        raise SystemExit(f"The training failed with exit code {process.returncode}.")
    return None


def _written(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except FileNotFoundError:  # it was replaced at this moment
        return 0.0


def _now(folder: Path) -> float:
    """Return the time as the file system tells it."""
    folder.mkdir(parents=True, exist_ok=True)
    mark = folder / "now"
    mark.touch()
    return _written(mark)


def main() -> None:
    """Interrupt, resume, compare and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--frames", default="200", metavar="N", help="training frames (default: 200)")
    parser.add_argument("--steps", default="200", metavar="N", help="of the training (default: 200)")
    parser.add_argument(
        "--wait", type=float, default=5.0, metavar="S", help="seconds in a phase (default: 5)"
    )
    arguments = parser.parse_args()
    options = ("--frames", arguments.frames, "--steps", arguments.steps)
    with TemporaryDirectory(prefix="sunset-") as name:
        parts, whole = Path(name) / "parts", Path(name) / "whole"
        for phase in PHASES:
            for number in (signal.SIGTERM, signal.SIGKILL):
                lost = seconds_lost(training(parts, options), parts / "work", phase, number, arguments.wait)
                told = "over before the signal" if lost is None else f"{lost:.1f} s lost"
                print(f"{phase}, {number.name}: {told}", flush=True)
        for folder in (parts, whole):
            subprocess.run(  # noqa: S603  the command is our own
                training(folder, options), stderr=subprocess.DEVNULL, check=True
            )
        same = all(
            (parts / "model" / path.name).read_bytes() == path.read_bytes()
            for path in (whole / "model").glob("*.[ob]*")
        )
    print("the networks are", "the same" if same else "DIFFERENT")


if __name__ == "__main__":
    main()
