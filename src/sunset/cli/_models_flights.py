"""`sunset models flights`: the thresholds of a model on flights, and their quality."""

import argparse
import json

from msgspec import to_builtins

import sunset
from sunset.api.flights import flights_text
from sunset.cli.options import add_json_option, add_settings, call
from sunset.cli.progress import rendering_progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the action's parser."""
    parser.description = (
        "Find the thresholds of a model on flights, as it is done when a run is prepared, and print how well they tell "
        "healthy frames from faulty ones."
    )
    parser.add_argument("model", nargs="?", default="lite", help="a model's name or folder")
    parser.add_argument(
        "--flights",
        default="panel",
        metavar="A,B,…",
        help="panel (eight flights), one of the panel, default, or a bag's path, also as LABEL=PATH",
    )
    add_settings(parser, "device")
    add_json_option(parser)


def execute(arguments: argparse.Namespace) -> None:
    """Measure a model on flights."""
    model = sunset.load_model(arguments.model)
    with rendering_progress() as progress:
        thresholds = call(sunset.measure_flights, arguments, model=model, progress=progress)
    if arguments.json:
        print(json.dumps(to_builtins(thresholds), sort_keys=True))
    else:
        print(flights_text(model.card.name, thresholds), end="")
