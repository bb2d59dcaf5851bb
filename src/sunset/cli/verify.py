"""`sunset verify`: check a bundle."""

import argparse
import json

import sunset
from sunset.cli.options import add_flag, add_path, call
from sunset.cli.progress import progress_bar
from sunset.errors import InvalidInputError

EXIT_DIFFERS = 1
"""A figure or file of the bundle is wrong."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Check what 'sunset bundle' wrote: every file against the checksums, the runs against the plan, the sources "
        "against what the plan says was run, every figure against the recorded messages, and some runs by running them "
        "again. Each difference is named. Nothing in the bundle is executed without --trust. Exit code 1 says that "
        "something differs, 2 that the file cannot be checked."
    )
    add_path(parser, "path", "FILE.zip", "what 'sunset bundle' wrote")
    add_rerun_options(parser)
    parser.add_argument("--model", metavar="DIR", help="the campaign's model, where it is not installed")
    add_path(parser, "--bag", "PATH", "the campaign's flight, where it has one of its own")
    add_flag(parser, "--json", "print a JSON object")


def add_rerun_options(parser: argparse.ArgumentParser) -> None:
    """Add the options for second runs of a bundle's runs."""
    parser.add_argument(
        "--run-again", type=int, default=3, metavar="K", help="runs, chosen at random, that are run again"
    )
    parser.add_argument(
        "--seed", type=int, metavar="N", help="of that choice (default: another one each time)"
    )
    add_flag(
        parser,
        "--trust",
        "run the bundle's own managing systems and extensions, which are programs and may do what you may",
    )


def execute(arguments: argparse.Namespace) -> int:
    if arguments.run_again == 0 and arguments.seed is not None:
        raise InvalidInputError("No run is chosen with --run-again 0: leave out --seed.")
    with progress_bar("Verifying") as progress:
        verification = call(sunset.verify, arguments, progress=progress)
    text = json.dumps(verification.to_json(), ensure_ascii=False) if arguments.json else verification
    print(text)
    return 0 if verification.passed else EXIT_DIFFERS
