"""`sunset view`: replay a stored run, or two side by side, in a page."""

import argparse
import sys

import sunset
from sunset.api.viewing import can_show_pages
from sunset.cli.options import add_path, call
from sunset.cli.progress import stages_progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.description = (
        "Write one HTML file that replays a stored run: its pictures, labels and truth, faults, failures, adaptations "
        "and figures over time; and open it. It loads nothing, so that it can be sent around. The images of a "
        "record without any are made in the simulation, by its commands: no managing system is run."
    )
    add_path(
        parser,
        "run",
        "RUN",
        "what 'sunset run --out' wrote (default: the last run that was given no folder)",
        nargs="?",
    )
    add_path(
        parser,
        "other",
        "RUN",
        "one of another managing system, on the same scenario, seed and flight, which is shown beside it",
        nargs="?",
    )
    add_path(parser, "--out", "FILE", "the page (default: in this folder, named after the run)")
    parser.add_argument(
        "--no-open", action="store_false", dest="show", help="do not open the page in a browser"
    )
    parser.add_argument("--model", metavar="NAME|DIR", help="the model, if it has moved since the run")
    add_path(parser, "--bag", "PATH", "the flight, if it is not the default one")


def execute(arguments: argparse.Namespace) -> None:
    if arguments.run is None:
        from sunset.api.running import last_run  # noqa: PLC0415  slow, and rarely needed

        arguments.run = last_run()
    with stages_progress() as stage:
        file = call(sunset.view, arguments, progress=stage)
    remedy = "" if arguments.show and can_show_pages() else ": open it in a browser"
    print(f"The page is {file}{remedy}.", file=sys.stderr)
