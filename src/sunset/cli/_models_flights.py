"""`sunset models flights`: which thresholds a model has on flights, and how well they do."""

import argparse
import json

from msgspec import to_builtins

from sunset.api import measure_flights
from sunset.api.options import chosen_flights
from sunset.cli._options import add_device_option
from sunset.cli._progress import rendering_progress
from sunset.flights import HELD_OUT
from sunset.perception import load_model
from sunset.training.flights_text import flights_text


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
    add_device_option(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def execute(arguments: argparse.Namespace) -> None:
    """Measure a model on flights."""
    model = load_model(arguments.model)
    with rendering_progress() as progress:
        found = measure_flights(
            model, chosen_flights(arguments.flights), device=arguments.device, progress=progress
        )
    if arguments.json:
        print(json.dumps(to_builtins(found), sort_keys=True))
        return
    held_out = {flight.name for flight in HELD_OUT}
    print(flights_text(model.card.name, found, held_out), end="")
