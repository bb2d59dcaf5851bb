"""`sunset models curves`: the effect of each fault on a model, by its strength."""

import argparse
import json
import sys
from functools import partial

import sunset
from sunset.cli.options import add_count_option, add_json_option, add_path, add_settings
from sunset.cli.parser import at_least_one
from sunset.cli.progress import rendering_stages, stages_progress
from sunset.errors import MissingExtraError
from sunset.files.outputs import make_folder, write_text
from sunset.files.schemas import document_text
from sunset.perception.card import SEVERITIES_NAME
from sunset_lab.curves_text import as_csv, as_json, as_text, draw, severity_table


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the action's parser."""
    parser.description = (
        "Measure IoU, entropy and sharpness for every fault that degrades images at many strengths, after each "
        "cure, and for every two of these faults at once. Strengths of the suites are marked with *."
    )
    parser.add_argument("model", nargs="?", default="lite", help="a model's name or folder")
    add_path(parser, "--bag", "PATH", "a rosbag2 (default: the default flight)")
    add_path(
        parser,
        "--out",
        "DIR",
        "receives curves.csv, curves.json, figures (PNG), and severities.json for the model's folder",
    )
    parser.add_argument(
        "--every",
        type=at_least_one,
        default=1,
        metavar="K",
        help="look at one of K groups of five consecutive frames only",
    )
    parser.add_argument(
        "--at",
        type=_strength,
        action="append",
        default=[],
        metavar="FAULT=STRENGTH",
        help="measure at this strength instead of that of the suites; may be repeated",
    )
    add_count_option(parser, "--jobs", "processes; no influence on results (default: one a core)")
    add_settings(parser, "device")
    add_json_option(parser)


def _strength(text: str) -> tuple[str, float]:
    fault, _, number = text.partition("=")
    try:
        return fault, float(number)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"expected a fault and its strength such as image_shift=8, got {text!r}"
        ) from None


def execute(arguments: argparse.Namespace) -> None:
    """Measure a model by fault and strength."""
    model = sunset.load_model(arguments.model)
    if arguments.out is not None:
        make_folder(arguments.out)
    with stages_progress() as stage:
        curves = sunset.measure_curves(
            model,
            arguments.bag,
            every=arguments.every,
            strengths=dict(arguments.at),
            jobs=arguments.jobs,
            device=arguments.device,
            progress=partial(stage, "Measuring"),
            rendering=partial(rendering_stages(stage), "Rendering"),
        )
    document = as_json(curves)
    print(json.dumps(document, sort_keys=True) + "\n" if arguments.json else as_text(curves), end="")
    if arguments.out is not None:
        write_text(arguments.out / "curves.csv", as_csv(curves))
        write_text(arguments.out / "curves.json", json.dumps(document, indent=2) + "\n")
        write_text(arguments.out / SEVERITIES_NAME, document_text(severity_table(curves)))
        try:
            draw(curves, arguments.out)
        except MissingExtraError as error:
            print(error, file=sys.stderr)
