"""`sunset models`: what segmentation models there are, what they can do, and how to bring one's own."""

import argparse
import json
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from time import perf_counter
from typing import Final

from sunset.cli._options import add_device_option
from sunset.cli._parser import EXIT_BAD_INPUT
from sunset.cli._progress import progress_bar
from sunset.errors import ModelError
from sunset.perception import OFFERED, Modality, Model, Segmenter, load_model
from sunset.perception import list_models as installed_models
from sunset.tables import aligned

_FRAMES: Final = 4
"""How many are segmented to see how long one takes; the quickest counts."""

_OTHERS: Final = {
    "import": "make a model of the published checkpoints",
    "calibrate": "give a model its temperatures, thresholds and card",
    "curves": "measure what each fault does to a model, by its strength, and what its cure brings back",
    "flights": "find the thresholds of a model on flights, and how well they do",
    "iou": "tabulate the IoU of models on towns that they were not trained on",
}
"""Actions that have modules of their own, since they need what trains models."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    listing = actions.add_parser(
        "list",
        help="list the models that are installed, and those that could be",
        description="List the models that are installed: how large they are, the IoU of colour and depth together on "
        "flights over town 8, which were kept for the test, and how long that network takes for a frame on this "
        "computer, measured now. Then the models that are distributions of their own and are not installed.",
    )
    listing.add_argument("--json", action="store_true", help="print one JSON object")
    add_device_option(listing)
    listing.set_defaults(execute=list_models)
    showing = actions.add_parser("show", help="print a model's card")
    showing.add_argument("model", help="a model's name or folder")
    showing.add_argument("--json", action="store_true", help="print the card as one JSON object")
    showing.set_defaults(execute=show)
    for name, text in _OTHERS.items():
        actions.add_parser(name, help=text, module=f"_models_{name}")


def list_models(arguments: argparse.Namespace) -> int:
    """Print what there is, and what could be."""
    names = installed_models()
    rows, complaints = [], []
    with progress_bar("Measuring"):
        for name in names:
            try:
                rows.append(_measured(name, load_model(name), arguments.device))
            except ModelError as error:  # maybe of another distribution, whose model is broken
                complaints.append(str(error))
    missing = {name: command for name, command in OFFERED.items() if name not in names}
    if arguments.json:
        print(json.dumps({"models": [asdict(row) for row in rows], "not_installed": missing}, sort_keys=True))
    else:
        header = ("MODEL", "IMAGES", "WEIGHTS", "FILES", "IOU OVER TOWN 8", "A FRAME TAKES")
        print("\n".join(aligned([header, *map(_cells, rows)], left=range(len(header)))))
        for name, command in missing.items():
            print(f"{name} is not installed; in a clone of SUNSET's repository: {command}")
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    return EXIT_BAD_INPUT if complaints else 0


@dataclass(frozen=True)
class _Row:
    """What a list tells of a model; the IoU is None where the training that wrote its card did not measure it."""

    name: str
    width: int
    height: int
    parameters: int
    bytes: int
    iou: float | None
    frame_ms: float


def _cells(row: _Row) -> tuple[str, ...]:
    return (
        row.name,
        f"{row.width}x{row.height}",
        f"{row.parameters / 1e6:.1f} million",
        f"{row.bytes / 1e6:.1f} MB",
        "N/A" if row.iou is None else f"{row.iou:.2f}",
        f"{row.frame_ms:.0f} ms",
    )


def _measured(name: str, model: Model, device: str) -> _Row:
    """Return what a list tells of a model; how long its fusion takes for a frame is measured, here and now."""
    card, modality = model.card, min(model.card.networks)
    files = {file for network in card.networks.values() for file in network.files}
    segmenter = Segmenter(model, device=device)
    times = []
    for _ in range(_FRAMES):
        begun = perf_counter()
        segmenter.warm_up(modality)
        times.append(perf_counter() - begun)
    return _Row(
        name=name,
        width=card.width,
        height=card.height,
        parameters=card.networks[modality].parameters,
        bytes=sum((model.folder / file).stat().st_size for file in files),
        iou=_test_iou(card.results, modality),
        frame_ms=min(times) * 1e3,
    )


def _test_iou(results: Mapping[str, object], modality: Modality) -> float | None:
    """Return the IoU on the town that was kept for the test, where the training that wrote the card measured it."""
    found: object = results
    for key in ("iou_per_image", "test town", modality.key):
        found = found.get(key) if isinstance(found, Mapping) else None
    return float(found) if isinstance(found, int | float) else None


def show(arguments: argparse.Namespace) -> None:
    """Print a card."""
    model = load_model(arguments.model)
    print(json.dumps(model.card.to_json(), sort_keys=True) if arguments.json else model.card.to_text())
