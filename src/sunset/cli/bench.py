"""`sunset bench`: a campaign over a suite, and the table of the paper."""

import argparse
import shlex
import sys
from contextlib import redirect_stdout
from dataclasses import replace
from pathlib import Path

from sunset.cli._options import (
    add_campaign_options,
    add_count_option,
    add_format_options,
    add_images_option,
    add_middleware_options,
    add_run_options,
    campaign,
)
from sunset.cli._prepare import prepare_flights
from sunset.cli._progress import progress_bar
from sunset.cli._steps import print_next_steps
from sunset.cli.report import print_report
from sunset.evaluation import FORMATS
from sunset.experiments import BenchSpec, bench, flights_of, plan
from sunset.texts import counted


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "Run every scenario of a suite with every managing system, several times, and the two reference "
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
        help="leave out the paper's two reference rows, which --scenarios does not make smaller",
    )
    add_run_options(parser)
    add_middleware_options(parser)
    add_count_option(parser, "--jobs", "worker processes (default: one a core; live: 1)")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder of the results")
    add_images_option(parser)
    add_format_options(parser, FORMATS, "how the table is printed")


def execute(arguments: argparse.Namespace) -> None:
    """Run the campaign, and print the table."""
    spec = campaign(arguments, references=arguments.references)
    runs = plan(spec)
    prepare_flights(flights_of(runs))
    # what a managing system prints must not get into the table
    with progress_bar(_title(spec)) as progress, redirect_stdout(sys.stderr):
        done = bench(spec, arguments.out, jobs=arguments.jobs, progress=progress)
    print(f"{done} runs done, {len(runs) - done} were there already.", file=sys.stderr)
    print_report(arguments.out, arguments.format)
    if arguments.format == "table":
        out = shlex.quote(str(arguments.out))
        report = f"sunset report {out}"
        print_next_steps(
            [
                (f"{report} --site site", "a folder of pages: the table, and each run to look at"),
                (f"{report} --format latex", "the table for a paper"),
                (f"{report} --runs", "the runs, one a row, for your own statistics"),
                (f"sunset bundle {out} --out results.zip", "one file that others can check"),
            ]
        )


def _title(spec: BenchSpec) -> str:
    """Return what is done while a campaign runs, and how many runs of it nobody asked for by name."""
    references = len(plan(spec)) - len(plan(replace(spec, references=False)))
    return (
        f"Running the campaign with {counted(references, 'reference run')}"
        if references
        else "Running the campaign"
    )
