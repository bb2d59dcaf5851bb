"""`sunset models iou`: the IoU of models on held-out towns."""

import argparse
import json
from functools import partial

import sunset
from sunset.cli.options import add_count_option, add_json_option, add_path, add_settings
from sunset.cli.progress import stages_progress
from sunset.files.outputs import make_folder, write_text
from sunset_lab.tables import VIEWS, iou_csv, iou_json, iou_markdown


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the action's parser."""
    parser.description = (
        "Measure the IoU of every network on views of towns 7 and 8 and on the default flight: mean, by class, "
        "height, angle, time of day and weather. Prints Markdown."
    )
    parser.add_argument(
        "models", nargs="*", metavar="MODEL", help="names or folders (default: all that are installed)"
    )
    add_count_option(
        parser,
        "--frames",
        f"views of each town and frames of the flight (default: {VIEWS}, and the whole flight)",
    )
    add_path(parser, "--out", "DIR", "receives iou.md and iou.csv")
    add_count_option(parser, "--jobs", "processes; no influence on results (default: one a core)")
    add_settings(parser, "device")
    add_json_option(parser)


def execute(arguments: argparse.Namespace) -> None:
    """Measure models on held-out towns."""
    models = [sunset.load_model(name) for name in arguments.models]
    if arguments.out is not None:
        make_folder(arguments.out)
    with stages_progress() as stage:
        tables = sunset.measure_iou(
            models,
            frames=arguments.frames,
            jobs=arguments.jobs,
            device=arguments.device,
            progress=partial(stage, "Measuring"),
            rendering=partial(stage, "Rendering (once)"),
        )
    text = iou_markdown(tables)
    print(json.dumps(iou_json(tables), sort_keys=True) + "\n" if arguments.json else text, end="")
    if arguments.out is not None:
        write_text(arguments.out / "iou.md", text)
        write_text(arguments.out / "iou.csv", iou_csv(tables))
