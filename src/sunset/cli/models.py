"""`sunset models`: segmentation models, their results, and how to add your own."""

import argparse
import json
import sys
from dataclasses import asdict
from typing import Final

from msgspec import to_builtins

import sunset
from sunset.cli.options import add_flag, add_json_option, add_settings, call
from sunset.cli.parser import EXIT_BAD_INPUT, Parser, add_module
from sunset.cli.progress import progress_bar, rendering_progress
from sunset.texts.tables import aligned

_OTHERS: Final = {
    "sunset_lab.verbs.models_import": "make a model of the published checkpoints",
    "sunset_lab.verbs.models_calibrate": "give a model its temperatures, thresholds and card",
    "sunset_lab.verbs.models_curves": (
        "measure what each fault does to a model, by its strength, and what its cure brings back"
    ),
    "sunset_lab.verbs.models_iou": "tabulate the IoU of models on towns that they were not trained on",
}
"""Module of an action, by whose last word it is called → its help; imported when it is used."""


def add_arguments(parser: Parser) -> None:
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    actions.add_parser(
        "list",
        help="list the models that are installed, and those that could be",
        description="List the models that are installed: how large they are, the IoU of colour and depth together on "
        "flights over town 8, which were kept for the test, and how long that network takes for a frame on this "
        "computer, measured now. Then the models that are distributions of their own and are not installed.",
        add=_add_list,
    )
    showing = actions.add_parser("show", help="print a model's card")
    showing.add_argument("model", help="a model's name or folder")
    add_flag(showing, "--json", "print the card as one JSON object")
    showing.set_defaults(execute=show)
    actions.add_parser(
        "flights",
        help="find the thresholds of a model on flights, and how well they do",
        description="Find the thresholds of a model on flights, as it is done when a run is prepared, and print how "
        "well they tell healthy frames from faulty ones.",
        add=_add_flights,
    )
    for module, text in _OTHERS.items():
        actions.add_parser(module.rpartition("_")[2], help=text, add=add_module(module))


def _add_list(parser: Parser) -> None:
    add_json_option(parser)
    add_settings(parser, "device")
    parser.set_defaults(execute=list_models)


def _add_flights(parser: Parser) -> None:
    parser.add_argument("model", nargs="?", default="lite", help="a model's name or folder")
    parser.add_argument(
        "--flights",
        default="panel",
        metavar="A,B,…",
        help="panel (eight flights), one of the panel, default, or a bag's path, also as LABEL=PATH",
    )
    add_settings(parser, "device")
    add_json_option(parser)
    parser.set_defaults(execute=measure_flights)


def list_models(arguments: argparse.Namespace) -> int:
    from sunset.api.model_list import survey_models  # noqa: PLC0415  slow, and not needed to show a model

    with progress_bar("Measuring"):
        listed, missing, complaints = survey_models(arguments.device)
    if arguments.json:
        models = list(map(asdict, listed))
        print(json.dumps({"models": models, "not_installed": missing}, sort_keys=True))
    else:
        header = ("MODEL", "IMAGES", "WEIGHTS", "FILES", "IOU OVER TOWN 8", "A FRAME TAKES")
        rows = [
            (
                row.name,
                f"{row.width}x{row.height}",
                f"{row.parameters / 1e6:.1f} million",
                f"{row.bytes / 1e6:.1f} MB",
                "N/A" if row.iou is None else f"{row.iou:.2f}",
                f"{row.frame_ms:.0f} ms",
            )
            for row in listed
        ]
        print("\n".join(aligned([header, *rows], left=range(len(header)))))
        for name, command in missing.items():
            print(f"{name} is not installed; in a clone of SUNSET's repository: {command}")
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    return EXIT_BAD_INPUT if complaints else 0


def show(arguments: argparse.Namespace) -> None:
    card = sunset.load_model(arguments.model).card
    print(json.dumps(card.to_json(), sort_keys=True) if arguments.json else card.to_text())


def measure_flights(arguments: argparse.Namespace) -> None:
    from sunset.api.flights import flights_text  # noqa: PLC0415  likewise

    model = sunset.load_model(arguments.model)
    with rendering_progress() as progress:
        thresholds = call(sunset.measure_flights, arguments, model=model, progress=progress)
    if arguments.json:
        print(json.dumps(to_builtins(thresholds), sort_keys=True))
    else:
        print(flights_text(model.card.name, thresholds), end="")
