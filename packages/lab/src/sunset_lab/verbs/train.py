"""`sunset train`: train the networks of a model on rendered towns."""

import argparse
import sys
from collections.abc import Callable
from time import monotonic
from typing import cast

import sunset
from sunset.cli.options import add_count_option, add_flag, add_path, add_settings
from sunset.cli.progress import stages_progress
from sunset.experiments import missing_networks
from sunset_lab import CONFIGS, MODALITIES


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.description = (
        "Render frames of towns other than the flight's, train the networks, calibrate "
        "their thresholds, and write a model folder with its card. Needs the extra 'train'."
    )
    _add_networks(parser)
    _add_scale(parser)
    parser.add_argument(
        "--compile",
        action="store_true",
        dest="compiled",
        help="let torch compile the networks; needs a C compiler",
    )
    add_count_option(parser, "--minutes", "stop after so many minutes, with exit code 1; --resume continues")
    add_flag(parser, "--resume", "continue the training in the work folder where it was interrupted")
    add_path(parser, "--work", "DIR", "keeps frames, checkpoints and logs", default="training")
    add_path(parser, "--out", "DIR", "the model's folder", required=True)


def _add_networks(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--model", choices=list(CONFIGS), default="lite", help="architecture and schedule")
    parser.add_argument("--name", metavar="NAME", help="the model's name (default: its folder's)")
    parser.add_argument(
        "--modality",
        default="all",
        choices=["all", *MODALITIES],
        help="which networks; the fusion contains both branches, so it means all",
    )
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of everything that is drawn")
    steps = ", ".join(f"{config.schedule.steps} for {name}" for name, config in CONFIGS.items())
    add_count_option(
        parser,
        "--steps",
        "optimiser steps, of each branch where branches are trained one by one; merging them takes its own number "
        f"(default: {steps})",
    )
    parser.add_argument(
        "--start-from",
        metavar="MODEL",
        help="train a model's networks further: a name or a folder (default: from random weights)",
    )


def _add_scale(parser: argparse.ArgumentParser) -> None:
    add_count_option(
        parser,
        "--frames",
        "about how many training frames; with fewer than the default, fewer are rendered to validate and test "
        "too, for a quick training (default: 5500; 20000 with --start-from)",
    )
    add_count_option(
        parser,
        "--batch",
        "frames a step, more of which fill an accelerator (default: as planned for --model)",
    )
    add_settings(parser, "device", device="what networks are trained on; auto: CUDA where torch offers it")
    add_count_option(parser, "--jobs", "processes that render and measure (default: one a core)")


def execute(arguments: argparse.Namespace) -> int:
    """Train."""
    names = sunset.TrainingOptions.__annotations__
    chosen = {name: value for name, value in vars(arguments).items() if name in names}
    options = cast("sunset.TrainingOptions", chosen)
    try:
        with stages_progress() as progress:
            progress("Preparing")
            ending = _until(arguments.minutes, progress) if arguments.minutes else progress
            model = sunset.train_model(arguments.model, arguments.out, progress=ending, **options)
    except _TimeIsUpError:
        print(
            f"The {arguments.minutes} min are over; the same command with --resume continues the training.",
            file=sys.stderr,
        )
        return 1
    missing = missing_networks(model)
    use = f"a run also needs {missing}" if missing else f"'sunset run --model {arguments.out}' runs with it"
    print(f"The model is in {arguments.out}; {use}.", file=sys.stderr)
    return 0


class _TimeIsUpError(Exception):
    """The training has used the minutes that it may take."""


def _until(minutes: float, progress: Callable[..., None]) -> Callable[..., None]:
    """Return a function that passes progress on, and raises after so many minutes."""
    end = monotonic() + 60 * minutes

    def update(stage: str, done: int, total: int, note: str = "") -> None:
        progress(stage, done, total, note)
        if monotonic() >= end:
            raise _TimeIsUpError

    return update
