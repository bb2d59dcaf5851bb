"""`sunset run`: run a scenario and measure the adaptation."""

import argparse
import json
import shlex
import sys
import tempfile
from pathlib import Path

import sunset
from sunset.api.running import DEFAULT_SCENARIO, keep_last_run
from sunset.cli.options import add_flag, add_path, add_settings, call, print_next_steps
from sunset.cli.progress import run_progress
from sunset.errors import OutputError
from sunset_ros.texts import printable


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Bring the managed system up, run it for 3 to 6 s without a fault, inject the scenario's faults, let the "
        "managing system adapt for 20 s, and print what happened and how well it did."
    )
    parser.add_argument(
        "scenario",
        nargs="?",
        default=DEFAULT_SCENARIO,
        help="a scenario's name ('sunset scenarios list'), a YAML file, or faults joined by +",
    )
    parser.add_argument(
        "--manager",
        default="baseline",
        metavar="[LABEL=]NAME|FILE.py:CLASS|MODULE:CLASS|exec:COMMAND",
        help=f"the managing system: {', '.join(sunset.list_managers())}, or your own; live, also external, which you "
        "start",
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="a whole number from 0 on")
    add_settings(parser)
    add_path(parser, "--out", "DIR", "keep the record in this new folder, and not only until the next run")
    add_flag(parser, "--json", "print one JSON object on stdout and nothing else")


def execute(arguments: argparse.Namespace) -> None:
    with tempfile.TemporaryDirectory(prefix="sunset-") as temporary:
        folder = arguments.out or Path(temporary) / "run"
        with run_progress("Running") as (preparing, _):
            # the log is part of the time line, which JSON lacks, and which a live run prints much later
            log = arguments.json or arguments.middleware != "sim"
            result = call(sunset.run, arguments, out=folder, log=log, preparing=preparing)
        if result.record.manager_failed is not None:
            print(f"{printable(result.record.manager_failed)} The run went on without it.", file=sys.stderr)
        if arguments.json:
            print(json.dumps(result.summary(), sort_keys=True))
            return
        result.print_story()
        if arguments.out is None:
            view = _keep(folder)
        else:
            view = f"sunset view {shlex.quote(str(folder))}"
            print(f"The record is in {folder}.", file=sys.stderr)
    if arguments.scenario == DEFAULT_SCENARIO and arguments.bag is None:
        print_next_steps(_next_steps(arguments, view))


def _keep(folder: Path) -> str:
    """Keep the record until the next run, and return the command that shows it; empty where it cannot be kept."""
    try:
        record = keep_last_run(folder)
    except OutputError as error:  # the result of the run has been printed
        print(error, file=sys.stderr)
        return ""
    print(f"The record is in {record} until the next run; '--out DIR' keeps it.", file=sys.stderr)
    return "sunset view"


def _next_steps(arguments: argparse.Namespace, view: str) -> list[tuple[str, str]]:
    """Return suggestions for a newcomer after the default scenario."""
    steps = [(view, "look at this run, frame by frame")] if view else []
    if arguments.manager in {"none", "baseline"}:
        better = "sunset run --manager reactive" + (
            f" --seed {arguments.seed}" if arguments.seed != 1 else ""
        )
        steps.append((better, "the same faults, and a managing system that looks for their causes"))
    steps.append(("sunset faults list", "what else can go wrong, and what cures it"))
    return steps
