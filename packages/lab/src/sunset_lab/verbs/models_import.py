"""`sunset models import`: a model of the published checkpoints."""

import argparse
import sys
from pathlib import Path

import sunset
from sunset.cli.options import add_path
from sunset.cli.progress import stages_progress
from sunset.experiments import missing_networks


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the action's parser."""
    parser.description = (
        "Read rgb.pth, depth.pth and fusion.pth, those that are there, without executing code from them, and write a "
        "model folder. Needs the extra 'train'."
    )
    add_path(parser, "checkpoints", "DIR", "the folder of the checkpoints")
    add_path(
        parser,
        "--out",
        "DIR",
        "the new model's folder (default: in the current folder, named after that of the checkpoints, with "
        "-model behind)",
    )
    parser.add_argument("--name", metavar="NAME", help="the model's name (default: its folder's)")
    parser.add_argument("--size", type=_size, default="256x144", metavar="WxH", help="of the images it takes")


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise argparse.ArgumentTypeError(
            f"expected width and height in pixels, such as 256x144, got {text!r}"
        )
    return int(width), int(height)


def execute(arguments: argparse.Namespace) -> None:
    """Make a model of checkpoints."""
    out = arguments.out or Path(f"{arguments.checkpoints.resolve().name}-model")
    with stages_progress() as progress:
        model = sunset.import_model(
            arguments.checkpoints, out, name=arguments.name, size=arguments.size, progress=progress
        )
    print(
        f"The model is in {out}; its thresholds are not known yet: run 'sunset models calibrate {out}' next, with "
        "--bag if it is meant for frames of your own.",
        file=sys.stderr,
    )
    if missing := missing_networks(model):
        print(f"It can be measured, but a run also needs {missing}.", file=sys.stderr)
