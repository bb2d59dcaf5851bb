"""`sunset bench`: a campaign over a suite, and the table of the paper."""

import argparse
import json
import shlex
import sys
from contextlib import nullcontext

import sunset
from sunset.api.results import FORMATS
from sunset.api.running import added_runs, connected_scheduler
from sunset.cli.options import (
    add_campaign_options,
    add_count_option,
    add_flag,
    add_format_options,
    add_path,
    add_settings,
    call,
    print_next_steps,
)
from sunset.cli.progress import run_progress
from sunset.cli.report import print_table
from sunset.errors import InvalidInputError
from sunset_ros.texts import printable


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Run every scenario of a suite with every managing system, several times, the two reference rows "
        "of the paper, and none and oracle for the scores. Finished runs are kept: the same "
        "command continues an interrupted campaign."
    )
    more = "; live, also external: one that you start yourself"
    add_campaign_options(parser, suite="paper", managers="none,baseline", repetitions=3, more=more)
    parser.add_argument(
        "--no-references",
        action="store_false",
        dest="references",
        help="leave out the paper's two reference rows, which ignore --scenarios",
    )
    parser.add_argument(
        "--no-score",
        action="store_false",
        dest="score",
        help="leave out the runs of none and oracle, without which there is no score",
    )
    add_settings(parser)
    _add_work(parser)
    add_path(parser, "--out", "DIR", "folder of the results")
    add_flag(
        parser,
        "--plan",
        "print how many runs there would be, how long they take, and which differences they detect; only two "
        "trial runs are done, and none with --like",
    )
    add_path(
        parser, "--like", "DIR", "with --plan: an earlier campaign, from which time and variances are taken"
    )
    add_format_options(parser, FORMATS, "how the table is printed")


def _add_work(parser: argparse.ArgumentParser) -> None:
    add_count_option(parser, "--jobs", "worker processes (default: one a core; live: 1)")
    parser.add_argument(
        "--scheduler",
        metavar="tcp://HOST:PORT",
        help="let the workers of a dask scheduler do the runs, on any computers (extra cluster)",
    )
    parser.add_argument(
        "--shard",
        metavar="I/N",
        help="do the I-th of N parts of the campaign only, as a job of an array does",
    )


def execute(arguments: argparse.Namespace) -> int:
    if arguments.plan:
        _print_plan(arguments)
        return 0
    if arguments.like is not None:
        raise InvalidInputError("An earlier campaign is for a plan only: add --plan, or leave out --like.")
    if arguments.out is None:
        raise InvalidInputError("The results need a folder: name one with --out DIR.")
    added = call(added_runs, arguments)
    title = f"Running the campaign with {', and '.join(added)}" if added else "Running the campaign"
    workers = connected_scheduler(arguments.scheduler) if arguments.scheduler else nullcontext()
    with workers as executor, run_progress(title) as (preparing, counter):
        results = call(sunset.bench, arguments, executor=executor, progress=counter, preparing=preparing)
    part = f" Part {' of '.join(arguments.shard.split('/'))} is done." if arguments.shard else ""
    print(f"{counter}{part}", file=sys.stderr)
    print_table(arguments.out, results.table(arguments.format), arguments.format)
    for name, failure in results.failing_managers.items():
        print(f"{name} failed in each of its runs: {printable(failure)}", file=sys.stderr)
    if arguments.format == "table":
        print_next_steps(_next_steps(arguments))
    return 1 if results.failing_managers else 0


def _next_steps(arguments: argparse.Namespace) -> list[tuple[str, str]]:
    out = shlex.quote(str(arguments.out))
    added = "".join(f" --extension {shlex.quote(extension)}" for extension in arguments.extension)
    if arguments.shard:
        whole = f"sunset report {shlex.quote(str(arguments.out.parent))}{added}"
        return [(whole, "the table of all parts, once they are done")]
    report = f"sunset report {out}"
    return [
        (f"{report} --site site{added}", "a folder of pages: the table, and each run to look at"),
        (f"{report} --format latex{added}", "the table for a paper"),
        (f"{report} --runs{added}", "the runs, one a row, for your own statistics"),
        (f"sunset bundle {out} --out results.zip{added}", "one file that others can check"),
    ]


def _print_plan(arguments: argparse.Namespace) -> None:
    """Print the forecast of the campaign, as text or JSON."""
    if arguments.shard is not None:
        raise InvalidInputError("A plan is of the whole campaign: leave out --shard, or --plan.")
    if arguments.format not in {"table", "json"}:
        raise InvalidInputError(f"A plan is printed as table or json, got {arguments.format!r}.")
    with run_progress("Planning") as (preparing, _):
        plan = call(sunset.plan_bench, arguments, preparing=preparing)
    print(json.dumps(plan.to_json(), indent=2, ensure_ascii=False) if arguments.format == "json" else plan)
