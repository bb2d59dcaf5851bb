"""The scores of the managing systems of `tests/managing/cheats.py`, which aim at figures, not at a segmentation.

Run it with `python benchmarks/cheats.py RESULTS`; with some scenarios of the suite only, it is quicker. It prints the
scores, and what became of the faults, beside those of the managing systems that come with SUNSET.
"""

import argparse
import runpy
from pathlib import Path

import sunset
from sunset.managing import MANAGERS

CHEATS = Path(__file__).parents[1] / "tests" / "managing" / "cheats.py"


def main() -> None:
    """Fly them and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("results", type=Path)
    parser.add_argument("--suite", default="paper")
    parser.add_argument("--scenarios", nargs="*", default=())
    parser.add_argument("--repetitions", type=int, default=1)
    arguments = parser.parse_args()
    cheats = [cheat.__name__ for cheat in runpy.run_path(str(CHEATS))["CHEATS"]]
    results = sunset.bench(
        arguments.suite,
        {name: f"{CHEATS}:{name}" for name in cheats} | {name: name for name in MANAGERS},
        out=arguments.results,
        scenarios=arguments.scenarios,
        repetitions=arguments.repetitions,
        references=False,
    )
    table = results.table()
    for title in ("The score", "What became of the faults"):
        print(title + "\n\n" + table.partition(title + "\n\n")[2].partition("\n\n")[0] + "\n")


if __name__ == "__main__":
    main()
