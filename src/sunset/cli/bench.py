"""`sunset bench`: a campaign over a suite, and the table of the paper."""

import argparse
import sys
from contextlib import redirect_stdout
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
from sunset.cli._progress import progress_bar, rendering_progress
from sunset.cli.report import print_report
from sunset.evaluation import FORMATS
from sunset.experiments import bench, plan, prepare


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
    with rendering_progress() as progress:
        prepare(runs[0], progress=progress)
    # what a managing system prints must not get into the table
    with progress_bar("Running the campaign") as progress, redirect_stdout(sys.stderr):
        done = bench(spec, arguments.out, jobs=arguments.jobs, progress=progress)
    print(f"{done} runs done, {len(runs) - done} were there already.", file=sys.stderr)
    print_report(arguments.out, arguments.format)
