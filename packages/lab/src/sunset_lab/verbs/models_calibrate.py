"""`sunset models calibrate`: the temperatures, thresholds and card of a model."""

import argparse
import sys
from typing import Final, cast

import sunset
from sunset.cli.options import add_count_option, add_path, add_settings
from sunset.cli.progress import stages_progress
from sunset.experiments import missing_networks

_POOR: Final = 0.1
"""With a lower IoU on healthy frames, a network is of no use."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the action's parser."""
    parser.description = (
        "Give all networks of a model the same entropy on good frames, choose its two thresholds, measure it, and "
        "write its card, without training. Needs onnx, which the extra 'train' installs."
    )
    parser.add_argument("model", help="a model's name or folder")
    add_path(parser, "--bag", "PATH", "a rosbag2 of good frames (default: rendered flights over town 7)")
    add_path(parser, "--out", "DIR", "a new folder for a calibrated copy (default: change the model)")
    add_count_option(parser, "--jobs", "processes; no influence on results (default: one a core)")
    add_settings(parser, "device")


def execute(arguments: argparse.Namespace) -> None:
    """Calibrate a model."""
    with stages_progress() as progress:
        calibrated = sunset.calibrate_model(
            arguments.model,
            arguments.bag,
            out=arguments.out,
            jobs=arguments.jobs,
            device=arguments.device,
            progress=progress,
        )
    card = calibrated.card
    keys = [modality.key for modality in sorted(card.networks)]
    for modality, network in sorted(card.networks.items()):
        print(f"{modality.key + ' temperature':22}{network.temperature:.4f}")
    print(f"{'entropy threshold':22}{card.entropy_threshold:.4f}")
    print(f"{'sharpness threshold':22}{card.sharpness_threshold:.4f}")
    measured = cast("dict[str, dict[str, float]]", card.results["faults_at_suite_strength"])
    iou = {key: measured[f"nominal, {key}"]["iou"] for key in keys}
    for key, value in iou.items():
        print(f"{key + ' IoU':22}{value:.4f}")
    if min(iou.values()) < _POOR:
        print(
            f"A network segments healthy frames with an IoU of {min(iou.values()):.2f} only, so that its entropy means "
            "little: calibrate on good frames of the kind that the model is meant for.",
            file=sys.stderr,
        )
    missing = missing_networks(calibrated)
    use = (
        f"a run also needs {missing}" if missing else f"'sunset run --model {calibrated.folder}' runs with it"
    )
    print(f"The model in {calibrated.folder} is calibrated; {use}.", file=sys.stderr)
