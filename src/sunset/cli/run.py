"""`sunset run`: run one scenario and measure the adaptation."""

import argparse
import json
import sys
import tempfile
from contextlib import redirect_stdout
from pathlib import Path

from sunset.cli._options import add_images_option, add_middleware_options, add_run_options, run_spec
from sunset.cli._progress import progress_bar, rendering_progress
from sunset.experiments import DEFAULT_SCENARIO, prepare, run


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "Bring the managed system up, run it for 3 s without a fault, inject the scenario's faults, let the "
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
        metavar="[LABEL=]NAME|FILE.py:CLASS|MODULE:CLASS",
        help="the managing system: none, baseline, or your own; live, also external: one that you start yourself",
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="a whole number from 0 on")
    add_run_options(parser)
    add_middleware_options(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="keep the record in this new folder")
    add_images_option(parser)
    parser.add_argument(
        "--json", action="store_true", help="print one JSON object on stdout and nothing else"
    )


def execute(arguments: argparse.Namespace) -> None:
    """Run, and print."""
    spec = run_spec(arguments)
    with rendering_progress() as progress:
        prepare(spec, progress=progress)
    with tempfile.TemporaryDirectory(prefix="sunset-") as temporary:
        folder = arguments.out or Path(temporary) / "run"
        with progress_bar("Running"), redirect_stdout(sys.stderr):
            # what is logged stands in the time line, which JSON has not, and which a live run leaves much later
            result = run(spec, folder, log=arguments.json or spec.settings.live)
        if arguments.json:
            print(json.dumps(result.summary(), sort_keys=True))
            return
        result.print_story()
    if arguments.out is None:
        print("The record was not kept; '--out DIR' keeps it.", file=sys.stderr)
    else:
        print(f"The record is in {arguments.out}.", file=sys.stderr)
