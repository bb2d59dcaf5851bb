"""`sunset agree`: the same seeds in the simulation and live, and how well they agree."""

import argparse
import sys
from contextlib import redirect_stdout
from pathlib import Path

from sunset.api.agreeing import paired_campaigns
from sunset.cli._options import (
    add_campaign_options,
    add_count_option,
    add_format_options,
    add_rate_option,
    add_run_options,
    campaign,
)
from sunset.cli._prepare import prepare_flights
from sunset.cli._progress import progress_bar
from sunset.evaluation import AGREEMENT_FORMATS, compare, format_agreement
from sunset.experiments import bench, flights_of, plan
from sunset.rmw.backends import LIVE


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "Run scenarios with the same seeds in the simulation and live, into DIR/sim and DIR/live, and "
        "print how much each figure differs, and whether the same failures appeared and the same adaptations were "
        "executed. Finished runs are kept: the same command continues what was interrupted, and runs nothing where "
        "all runs are there."
    )
    add_campaign_options(parser, suite="artifact", managers="baseline", repetitions=1, what="pairs")
    add_run_options(parser)
    add_rate_option(parser, "seconds of /clock in a second of the live runs")
    add_count_option(
        parser,
        "--jobs",
        "worker processes of the simulation (default: one a core); live runs take place one at a time",
    )
    parser.set_defaults(middleware=LIVE)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the results")
    parser.add_argument(
        "--stored", action="store_true", help="run nothing: compare the runs that are in DIR already"
    )
    add_format_options(parser, AGREEMENT_FORMATS, "how the report is printed")


def execute(arguments: argparse.Namespace) -> None:
    """Run what is not there yet, and print the report."""
    if not arguments.stored:
        _run(arguments)
    with progress_bar("Reading pairs of runs") as progress:
        agreements = compare(arguments.out / "sim", arguments.out / "live", progress=progress)
    print(format_agreement(agreements, arguments.format).rstrip("\n"))


def _run(arguments: argparse.Namespace) -> None:
    campaigns = paired_campaigns(campaign(arguments, references=False, score=False), arguments.jobs)
    runs = plan(campaigns[0][1])
    prepare_flights(flights_of(runs))
    for name, spec, jobs in campaigns:
        # what a managing system prints must not get into the report
        with progress_bar(f"Running, {name}") as progress, redirect_stdout(sys.stderr):
            done = bench(spec, arguments.out / name, jobs=jobs, progress=progress)
        print(f"{name}: {done} runs done, {len(runs) - done} were there already.", file=sys.stderr)
