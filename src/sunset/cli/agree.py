"""`sunset agree`: the same seeds in the simulation and live, and how well they agree."""

import argparse
import sys

import sunset
from sunset.api.results import AGREEMENT_FORMATS, format_agreement
from sunset.cli.options import (
    add_campaign_options,
    add_count_option,
    add_flag,
    add_format_options,
    add_path,
    add_settings,
    call,
)
from sunset.cli.progress import run_progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Run scenarios with the same seeds in the simulation and live, into DIR/sim and DIR/live, and "
        "print how much each figure differs, and whether the same failures appeared and the same adaptations were "
        "executed. Finished runs are kept: the same command continues what was interrupted, and runs nothing where "
        "all runs are there."
    )
    add_campaign_options(parser, suite="artifact", managers="baseline", repetitions=1, runs="pairs")
    add_settings(
        parser,
        without=("middleware", "viewers", "images"),
        rate="seconds of /clock in a second of the live runs",
    )
    add_count_option(
        parser,
        "--jobs",
        "worker processes of the simulation (default: one a core); live runs take place one at a time",
    )
    add_path(parser, "--out", "DIR", "folder of the results", required=True)
    add_flag(parser, "--stored", "run nothing: compare the runs that are in DIR already")
    add_format_options(parser, AGREEMENT_FORMATS, "how the report is printed")


def execute(arguments: argparse.Namespace) -> None:
    stage = "Comparing" if arguments.stored else "Running pairs"
    with run_progress(stage, campaigns=2) as (preparing, counter):
        agreements = call(sunset.agree, arguments, progress=counter, preparing=preparing)
    if not arguments.stored:
        print(counter, file=sys.stderr)
    print(format_agreement(agreements, arguments.format).rstrip("\n"))
