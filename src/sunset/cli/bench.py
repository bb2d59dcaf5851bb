"""`sunset bench`: a campaign over a suite, and the table of the paper."""

import argparse
import json
import shlex
import sys
from contextlib import nullcontext, redirect_stdout
from dataclasses import replace
from pathlib import Path

from sunset.api.planning import forecast
from sunset.cli._options import (
    add_campaign_options,
    add_count_option,
    add_format_options,
    add_images_option,
    add_middleware_options,
    add_run_options,
    campaign,
)
from sunset.cli._prepare import prepare_flights, warn_of_walls
from sunset.cli._progress import progress_bar
from sunset.cli._steps import print_next_steps
from sunset.cli.report import print_report
from sunset.errors import InvalidInputError
from sunset.evaluation import FORMATS
from sunset.experiments import (
    BenchSpec,
    Shard,
    added_managers,
    bench,
    connected_scheduler,
    failing_managers,
    flights_of,
    in_turn,
    plan,
)
from sunset.system import loaded_extensions
from sunset.texts import counted, listed, printable


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "Run every scenario of a suite with every managing system, several times, the two reference rows "
        "of the paper, and the managing systems that scores are measured between. Finished runs are kept: the same "
        "command continues an interrupted campaign."
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
    parser.add_argument(
        "--no-score",
        action="store_false",
        dest="score",
        help="leave out the runs of none and oracle, without which there is no score",
    )
    add_run_options(parser)
    add_middleware_options(parser)
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
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of the results")
    parser.add_argument(
        "--plan",
        action="store_true",
        help="print how many runs there would be, how long they take, and which differences they detect; only two "
        "trial runs are done, and none with --like",
    )
    parser.add_argument(
        "--like",
        type=Path,
        metavar="DIR",
        help="with --plan: an earlier campaign, from which time and variances are taken",
    )
    add_images_option(parser)
    add_format_options(parser, FORMATS, "how the table is printed")


def execute(arguments: argparse.Namespace) -> int:
    """Run the campaign, and print the table."""
    spec = campaign(arguments, references=arguments.references, score=arguments.score)
    if arguments.plan:
        _print_plan(spec, arguments)
        return 0
    if arguments.like is not None:
        raise InvalidInputError("An earlier campaign is for a plan only: add --plan, or leave out --like.")
    if arguments.out is None:
        raise InvalidInputError("The results need a folder: name one with --out DIR.")
    shard = None if arguments.shard is None else Shard.parse(arguments.shard)
    runs = in_turn(plan(spec))
    wanted = runs if shard is None else shard.of(runs)
    address = arguments.scheduler
    with nullcontext() if address is None else connected_scheduler(address) as executor:
        prepare_flights(flights_of(runs))
        warn_of_walls(run.manager for run in runs)
        # what a managing system prints must not get into the table
        with progress_bar(_title(spec)) as progress, redirect_stdout(sys.stderr):
            done = bench(
                spec, arguments.out, jobs=arguments.jobs, executor=executor, shard=shard, progress=progress
            )
    part = "" if shard is None else f" Part {shard.number} of {shard.count} is done."
    print(f"{done} runs done, {len(wanted) - done} were there already.{part}", file=sys.stderr)
    print_report(arguments.out, arguments.format)
    failures = failing_managers(arguments.out, wanted)
    for name, failure in failures.items():
        print(f"{name} failed in each of its runs: {printable(failure)}", file=sys.stderr)
    if arguments.format == "table":
        out = shlex.quote(str(arguments.out))
        added = "".join(f" --extension {shlex.quote(extension.where)}" for extension in loaded_extensions())
        report = f"sunset report {out}"
        whole = f"sunset report {shlex.quote(str(arguments.out.parent))}{added}"
        print_next_steps(
            [(whole, "the table of all parts, once they are done")]
            if shard
            else [
                (f"{report} --site site{added}", "a folder of pages: the table, and each run to look at"),
                (f"{report} --format latex{added}", "the table for a paper"),
                (f"{report} --runs{added}", "the runs, one a row, for your own statistics"),
                (f"sunset bundle {out} --out results.zip{added}", "one file that others can check"),
            ]
        )
    return 1 if failures else 0


def _print_plan(spec: BenchSpec, arguments: argparse.Namespace) -> None:
    """Print what the campaign would be, as text or JSON."""
    if arguments.shard is not None:
        raise InvalidInputError("A plan is of the whole campaign: leave out --shard, or --plan.")
    if arguments.format not in {"table", "json"}:
        raise InvalidInputError(f"A plan is printed as table or json, got {arguments.format!r}.")
    if arguments.like is None:
        prepare_flights(flights_of(plan(spec))[:1])
    with progress_bar("Planning"), redirect_stdout(sys.stderr):
        found = forecast(spec, arguments.like, jobs=arguments.jobs)
    print(json.dumps(found.to_json(), indent=2, ensure_ascii=False) if arguments.format == "json" else found)


def _title(spec: BenchSpec) -> str:
    """Return what is done while a campaign runs, and how many runs are added automatically."""
    bare = replace(spec, score=False)
    references = len(plan(bare)) - len(plan(replace(bare, references=False)))
    scored = len(plan(spec)) - len(plan(bare))
    added = [counted(references, "reference run")] if references else []
    added += [f"{counted(scored, 'run')} of {listed(added_managers(spec))} for the score"] if scored else []
    return f"Running the campaign with {listed(added)}" if added else "Running the campaign"
