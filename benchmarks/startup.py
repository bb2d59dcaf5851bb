"""How long it takes to start: the package, the command line, and what a shell or a user waits for.

Prints, for each command, the median and the least wall time of several rounds, and of the least what is left without
Python's own start, the first line. The commands take turns, so that a change of the computer's speed meets all of them.
"""

import argparse
import statistics
import subprocess
import sys
import time
from typing import Final

_PROGRAMS: Final = {
    "python": ("-c", "pass"),
    "import sunset": ("-c", "import sunset"),
    **{
        f"sunset {words}".rstrip(): ("-m", "sunset", *words.split())
        for words in (
            "--help",
            "nonsense",
            "run --help",
            "node --help",
            "ros --help",
            "scenarios list",
            "completion bash",
        )
    },
}


def seconds(program: str) -> float:
    """Return how long a program runs."""
    begun = time.perf_counter()
    subprocess.run(  # noqa: S603  the programs stand above
        [sys.executable, *_PROGRAMS[program]],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        check=False,
    )
    return time.perf_counter() - begun


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--rounds", type=int, default=15, metavar="N", help="how often (default: %(default)s)"
    )
    rounds = parser.parse_args().rounds
    for program in _PROGRAMS:
        seconds(program)  # which may compile modules, once
    taken: dict[str, list[float]] = {program: [] for program in _PROGRAMS}
    for _ in range(rounds):
        for program, times in taken.items():
            times.append(seconds(program))
    print(f"{'':24}{'median':>10}{'least':>10}{'without Python':>18}")
    bare = min(taken["python"])
    for program, times in taken.items():
        least = min(times)
        print(f"{program:24}{statistics.median(times):8.3f} s{least:8.3f} s{least - bare:16.3f} s")


if __name__ == "__main__":
    main()
