"""`sunset bench`: a campaign over a suite, and the table of the paper."""

import argparse
import sys
from contextlib import redirect_stdout
from pathlib import Path

from sunset.cli._options import (
    add_flight_options,
    add_middleware_options,
    at_least_one,
    flight_options,
    middleware_options,
)
from sunset.cli._progress import progress_bar, rendering_progress
from sunset.cli.report import print_report
from sunset.evaluation import FORMATS
from sunset.experiments import BenchSpec, bench, plan, prepare
from sunset.scenarios import suite_names

__all__ = ["add_parser", "execute"]


def add_parser(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb."""
    parser = verbs.add_parser(
        "bench",
        help="run managing systems over a suite and print the paper's table",
        description="Fly every scenario of a suite with every managing system, several times, and the two reference "
        "rows of the paper. Finished runs are kept: the same command continues an interrupted campaign.",
    )
    parser.add_argument(
        "--suite", default="paper", help=f"one of {', '.join(suite_names())} (default: paper)"
    )
    parser.add_argument(
        "--managers",
        default="none,baseline",
        metavar="A,B,…",
        help="managing systems, separated by commas (default: none,baseline)",
    )
    parser.add_argument(
        "--repetitions", type=int, default=3, metavar="N", help="runs a scenario (default: 3)"
    )
    parser.add_argument(
        "--seed", type=int, default=1, metavar="N", help="seed of the first repetition (default: 1)"
    )
    add_flight_options(parser)
    add_middleware_options(parser)
    parser.add_argument(
        "--jobs", type=at_least_one, metavar="N", help="worker processes (default: one a core)"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the results")
    parser.add_argument("--format", default="table", choices=FORMATS, help="how the table is printed")
    parser.add_argument(
        "--json", action="store_const", dest="format", const="json", help="same as --format json"
    )
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Fly, and print the table."""
    spec = BenchSpec(
        suite=arguments.suite,
        managers=tuple(name.strip() for name in arguments.managers.split(",") if name.strip()),
        repetitions=arguments.repetitions,
        seed=arguments.seed,
        **flight_options(arguments),
        **middleware_options(arguments),
    )
    runs = plan(spec)
    with rendering_progress() as progress:
        prepare(runs[0], progress=progress)
    # what a managing system prints must not get into the table
    with progress_bar(f"Flying {len(runs)} runs") as progress, redirect_stdout(sys.stderr):
        flown = bench(spec, arguments.out, jobs=arguments.jobs, progress=progress)
    print(f"{flown} runs flown, {len(runs) - flown} were there already.", file=sys.stderr)
    print_report(arguments.out, arguments.format)
    return 0
