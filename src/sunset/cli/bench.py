"""`sunset bench`: a campaign over a suite, and the table of the paper."""

import argparse
import sys
from contextlib import redirect_stdout
from pathlib import Path

from sunset.cli._options import (
    add_campaign_options,
    add_flight_options,
    add_middleware_options,
    campaign,
    flight_settings,
)
from sunset.cli._parser import at_least_one
from sunset.cli._progress import progress_bar, rendering_progress
from sunset.cli.report import print_report
from sunset.evaluation import FORMATS
from sunset.experiments import bench, plan, prepare


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "Fly every scenario of a suite with every managing system, several times, and the two reference "
        "rows of the paper. Finished runs are kept: the same command continues an interrupted campaign."
    )
    add_campaign_options(
        parser,
        suite="paper",
        managers="none,baseline",
        repetitions=3,
        more="; live, also external: one that you start yourself",
    )
    parser.add_argument(
        "--no-references",
        action="store_false",
        dest="references",
        help="leave out the paper's two reference rows",
    )
    add_flight_options(parser)
    add_middleware_options(parser)
    parser.add_argument(
        "--jobs", type=at_least_one, metavar="N", help="worker processes (default: one a core; live: 1)"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the results")
    parser.add_argument("--format", default="table", choices=FORMATS, help="how the table is printed")
    parser.add_argument(
        "--json", action="store_const", dest="format", const="json", help="same as --format json"
    )
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Fly, and print the table."""
    settings = flight_settings(arguments, middleware=arguments.middleware, speed=arguments.rate)
    spec = campaign(arguments, settings, references=arguments.references)
    runs = plan(spec)
    with rendering_progress() as progress:
        prepare(runs[0], progress=progress)
    # what a managing system prints must not get into the table
    with progress_bar(f"Flying {len(runs)} runs") as progress, redirect_stdout(sys.stderr):
        flown = bench(spec, arguments.out, jobs=arguments.jobs, progress=progress)
    print(f"{flown} runs flown, {len(runs) - flown} were there already.", file=sys.stderr)
    print_report(arguments.out, arguments.format)
    return 0
