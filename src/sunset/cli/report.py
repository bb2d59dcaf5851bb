"""`sunset report`: the table from stored records."""

import argparse
import sys
from pathlib import Path

from sunset.cli._progress import progress_bar
from sunset.evaluation import FORMATS, render_report
from sunset.experiments import count_runs

__all__ = ["add_parser", "execute", "print_report"]


def add_parser(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb."""
    parser = verbs.add_parser(
        "report",
        help="print the table of stored runs",
        description="Read the runs below a folder and print the paper's table; nothing is flown again.",
    )
    parser.add_argument(
        "folder", type=Path, metavar="DIR", help="what 'sunset bench --out' or 'run --out' wrote"
    )
    parser.add_argument(
        "--format", default="table", choices=FORMATS, help="how it is printed (default: table)"
    )
    parser.add_argument(
        "--recompute",
        action="store_true",
        help="compute every metric from the recorded messages again instead of reading the stored ones",
    )
    parser.add_argument(
        "--json", action="store_const", dest="format", const="json", help="same as --format json"
    )
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Print the report."""
    print_report(arguments.folder, arguments.format, recompute=arguments.recompute)
    return 0


def print_report(folder: Path, form: str, *, recompute: bool = False) -> None:
    """Print the report of a folder of runs on stdout."""
    with progress_bar("Reading runs") as progress:
        text = render_report(folder, form, recompute=recompute, progress=progress if recompute else None)
    print(text.rstrip("\n"))
    counted = count_runs(folder)
    if counted is not None and counted[0] < counted[1]:
        print(
            f"The campaign in {folder} is not finished: {counted[0]} of {counted[1]} runs are there.",
            file=sys.stderr,
        )
