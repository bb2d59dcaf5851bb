"""How long `sunset report` takes for a campaign of very many runs, and how much memory.

Usage: python benchmarks/report.py RESULTS... [--runs N] [--format F]...

The runs are copies of those of the folders RESULTS, under further seeds and with other digests: only `run.json` is
copied, which is all that a report reads. Prints, for each format, the wall time, the time of the processor, and the
greatest memory that the report has had.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from itertools import count
from pathlib import Path
from typing import Any

from sunset.evaluation.report import FORMATS
from sunset.texts.names import RUN_FILE

_MIB = 1024**2
_KIB = 1024


def copy_runs(sources: list[dict[str, Any]], folder: Path, runs: int) -> None:
    """Write so many runs into a folder: the sources under seeds of their own, one round of seeds after another.

    Args:
        sources: what `run.json` of some runs says.
        folder: a new one.
        runs: how many.
    """
    most = max(source["seed"] for source in sources)
    made = 0
    for turn in count():
        for source in sources:
            if made == runs:
                return
            seed = source["seed"] + turn * most
            digest = hashlib.sha256(f"{source['digest']} {turn}".encode()).hexdigest()
            place = folder / "runs" / f"{made // 1000}" / f"{made}"
            place.mkdir(parents=True)
            content = json.dumps(source | {"seed": seed, "digest": digest}, indent=2, sort_keys=True)
            (place / RUN_FILE).write_text(content + "\n", encoding="utf-8")
            made += 1


def measure(folder: Path, form: str) -> tuple[float, float, float]:
    """Return what a report takes: wall time [s], the processor's [s], and the most memory [MiB]."""
    begun = time.perf_counter()
    process = subprocess.Popen(  # noqa: S603  the words stand here
        [sys.executable, "-m", "sunset", "report", str(folder), "--format", form], stdout=subprocess.DEVNULL
    )
    _, status, used = os.wait4(process.pid, 0)
    wall_s = time.perf_counter() - begun
    if status:
        raise SystemExit(f"The report failed with exit code {os.waitstatus_to_exitcode(status)}.")
    peak = used.ru_maxrss / _MIB if sys.platform == "darwin" else used.ru_maxrss / _KIB
    return wall_s, used.ru_utime + used.ru_stime, peak


def main() -> None:
    """Copy, measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("results", type=Path, nargs="+", help="folders of campaigns")
    parser.add_argument("--runs", type=int, default=10_000, metavar="N", help="default: %(default)s")
    parser.add_argument("--format", action="append", choices=FORMATS, help="default: table and html")
    arguments = parser.parse_args()
    sources = [
        json.loads(file.read_text(encoding="utf-8"))
        for folder in arguments.results
        for file in sorted(folder.rglob(RUN_FILE))
    ]
    with tempfile.TemporaryDirectory() as place:
        copy_runs(sources, Path(place), arguments.runs)
        print(f"{arguments.runs} runs, copies of {len(sources)}")
        for form in arguments.format or ("table", "html"):
            wall_s, processor_s, peak = measure(Path(place), form)
            print(f"{form:6} {wall_s:6.1f} s, {processor_s:6.1f} s of the processor, {peak:5.0f} MiB")


if __name__ == "__main__":
    main()
