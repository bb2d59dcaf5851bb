"""`sunset train`: train the networks of a model on rendered towns."""

import argparse
import os
import sys
from pathlib import Path

from sunset.cli._options import at_least_one
from sunset.cli._progress import stages_progress
from sunset.training import MODALITIES, Schedule, TrainingConfig, train

__all__ = ["add_parser", "execute"]


def add_parser(verbs: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the verb."""
    parser = verbs.add_parser(
        "train",
        help="train a segmentation model on rendered towns",
        description="Render frames of towns that the flight is not over, train the networks from scratch, calibrate "
        "their thresholds, and write a model folder with its card. Needs the extra 'train'.",
    )
    parser.add_argument("--name", default="lite", help="the model's name in its card (default: lite)")
    parser.add_argument(
        "--modality",
        default="all",
        choices=["all", "rgb", "depth"],
        help="which networks; the fusion is trained together with both branches (default: all)",
    )
    parser.add_argument(
        "--seed", type=int, default=1, metavar="N", help="of everything that is drawn (default: 1)"
    )
    parser.add_argument(
        "--steps",
        type=at_least_one,
        default=Schedule().steps,
        metavar="N",
        help=f"optimiser steps (default: {Schedule().steps})",
    )
    parser.add_argument(
        "--jobs", type=at_least_one, metavar="N", help="processes that render (default: one a core)"
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on at the last checkpoint in the work folder"
    )
    parser.add_argument(
        "--work",
        type=Path,
        default=Path("training"),
        metavar="DIR",
        help="keeps frames, checkpoints and the log",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="the model's folder")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Train."""
    modalities = MODALITIES if arguments.modality == "all" else (arguments.modality,)
    config = TrainingConfig(name=arguments.name, modalities=modalities, seed=arguments.seed)
    with stages_progress() as progress:
        train(
            config.with_steps(arguments.steps),
            arguments.out,
            work=arguments.work,
            resume=arguments.resume,
            jobs=arguments.jobs or os.cpu_count() or 1,
            progress=progress,
        )
    print(f"The model is in {arguments.out}; 'sunset run --model {arguments.out}' flies it.", file=sys.stderr)
    return 0
