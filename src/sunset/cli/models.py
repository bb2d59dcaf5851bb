"""`sunset models`: what segmentation models there are, what they can do, and how to bring one's own."""

import argparse
import json
import os
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Final, TypedDict

from sunset.cli._columns import print_columns
from sunset.cli._options import add_device_option
from sunset.cli._parser import EXIT_BAD_INPUT, Actions, at_least_one
from sunset.cli._progress import progress_bar, rendering_progress, stages_progress
from sunset.data import DEFAULT_FLIGHT, flight_bag
from sunset.errors import MissingExtraError, ModelError, OutputError
from sunset.experiments.files import make_folder, write_text
from sunset.experiments.resources import missing_networks
from sunset.perception import OFFERED, Modality, Model, Segmenter, find_device, load_model
from sunset.perception import list_models as installed_models
from sunset.perception.card import MAX_SIDE
from sunset.training import import_checkpoints
from sunset.training.curves import measure_curves
from sunset.training.curves_text import as_csv, as_json, as_text
from sunset.training.plots import draw
from sunset.training.recalibrate import calibrate_model, check_target, frames_of_bag, validation_flight
from sunset.training.tables import VIEWS, measure_iou
from sunset.training.tables_text import iou_csv, iou_json, iou_markdown

_FRAMES: Final = 4
"""How many are segmented to see how long one takes; the quickest counts."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Complete the verb's parser."""
    parser.set_defaults(execute=lambda _: parser.print_help())
    actions = parser.add_subparsers(title="actions", metavar="ACTION")
    listing = actions.add_parser(
        "list",
        help="list the models that are installed, and those that could be",
        description="List the models that are installed: how large they are, the IoU of colour and depth together on "
        "the town that was kept for the test, and how long that network takes for a frame on this computer, measured "
        "now. Then the models that are distributions of their own and are not installed.",
    )
    listing.add_argument("--json", action="store_true", help="print one JSON object")
    add_device_option(listing)
    listing.set_defaults(execute=list_models)
    showing = actions.add_parser("show", help="print a model's card")
    showing.add_argument("model", help="a model's name or folder")
    showing.add_argument("--json", action="store_true", help="print the card as one JSON object")
    showing.set_defaults(execute=show)
    _add_import(actions)
    _add_calibrate(actions)
    _add_curves(actions)
    _add_iou(actions)


def _add_import(actions: Actions) -> None:
    parser = actions.add_parser(
        "import",
        help="make a model of the published checkpoints",
        description="Read rgb.pth, depth.pth and fusion.pth, those that are there, without executing code from them, "
        "and write a model folder. Needs the extra 'train'.",
    )
    parser.add_argument("checkpoints", type=Path, metavar="DIR", help="the folder of the checkpoints")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="the new model's folder (default: in the current folder, named after that of the checkpoints, with "
        "-model behind)",
    )
    parser.add_argument("--name", metavar="NAME", help="the model's name (default: its folder's)")
    parser.add_argument(
        "--size",
        type=_size,
        default=(256, 144),
        metavar="WxH",
        help="of the images it takes (default: 256x144)",
    )
    parser.set_defaults(execute=import_model)


def _add_calibrate(actions: Actions) -> None:
    parser = actions.add_parser(
        "calibrate",
        help="give a model its temperatures, thresholds and card",
        description="Give all networks of a model the same entropy on good frames, choose its two thresholds, measure "
        "it, and write its card, without training. Needs onnx, which the extra 'train' installs.",
    )
    parser.add_argument("model", help="a model's name or folder")
    parser.add_argument(
        "--bag",
        type=Path,
        metavar="PATH",
        help="a rosbag2 of good frames (default: rendered flights over town 7)",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="a new folder for a calibrated copy (default: change the model)",
    )
    _add_processing_options(parser)
    parser.set_defaults(execute=calibrate)


def _add_curves(actions: Actions) -> None:
    parser = actions.add_parser(
        "curves",
        help="measure what each fault does to a model, by its strength, and what its cure brings back",
        description="Measure IoU, entropy and sharpness for every fault that degrades images at many strengths, after "
        "each cure, and for every two of these faults at once. Strengths of the suites are marked with *.",
    )
    parser.add_argument("model", nargs="?", default="lite", help="a model's name or folder (default: lite)")
    parser.add_argument("--bag", type=Path, metavar="PATH", help="a rosbag2 (default: the default flight)")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="receives curves.csv, curves.json and figures (PNG)"
    )
    parser.add_argument(
        "--every",
        type=at_least_one,
        default=1,
        metavar="K",
        help="look at one of K groups of five consecutive frames only (default: 1)",
    )
    parser.add_argument(
        "--at",
        type=_strength,
        action="append",
        default=[],
        metavar="FAULT=STRENGTH",
        help="measure at this strength instead of that of the suites; may be repeated",
    )
    _add_measuring_options(parser)
    parser.set_defaults(execute=curves)


def _add_iou(actions: Actions) -> None:
    parser = actions.add_parser(
        "iou",
        help="tabulate the IoU of models on towns that they were not trained on",
        description="Measure the IoU of every network on views of towns 7 and 8 and on the default flight: mean, by "
        "class, height, angle, time of day and weather. Prints Markdown.",
    )
    parser.add_argument(
        "models", nargs="*", metavar="MODEL", help="names or folders (default: all that are installed)"
    )
    parser.add_argument(
        "--frames",
        type=at_least_one,
        metavar="N",
        help=f"views of each town and frames of the flight (default: {VIEWS}, and the whole flight)",
    )
    parser.add_argument("--out", type=Path, metavar="DIR", help="receives iou.md and iou.csv")
    _add_measuring_options(parser)
    parser.set_defaults(execute=iou)


def _add_processing_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--jobs",
        type=at_least_one,
        metavar="N",
        help="processes; no influence on results (default: one a core)",
    )
    add_device_option(parser)


def _add_measuring_options(parser: argparse.ArgumentParser) -> None:
    _add_processing_options(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    digits = len(str(MAX_SIDE))
    sides = [int(side) if side.isdecimal() and len(side) <= digits else 0 for side in (width, height)]
    if not all(1 <= side <= MAX_SIDE for side in sides):
        raise argparse.ArgumentTypeError(
            f"expected width and height in pixels, of at most {MAX_SIDE} each, such as 256x144, got {text!r}"
        )
    return int(width), int(height)


def _strength(text: str) -> tuple[str, float]:
    fault, _, number = text.partition("=")
    try:
        return fault, float(number)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"expected a fault and its strength such as image_shift=8, got {text!r}"
        ) from None


def list_models(arguments: argparse.Namespace) -> int:
    """Print what there is, and what could be."""
    names = installed_models()
    models, complaints = [], []
    with progress_bar("Measuring"):
        for name in names:
            try:
                models.append(_described(name, load_model(name), arguments.device))
            except ModelError as error:  # maybe of another distribution, whose model is broken
                complaints.append(str(error))
    missing = {name: command for name, command in OFFERED.items() if name not in names}
    if arguments.json:
        print(json.dumps({"models": models, "not_installed": missing}, sort_keys=True))
    else:
        header = ("MODEL", "IMAGES", "WEIGHTS", "FILES", "IOU", "A FRAME TAKES")
        print_columns(header, map(_cells, models))
        for name, command in missing.items():
            print(f"{name} is not installed; in a clone of SUNSET's repository: {command}")
    for complaint in complaints:
        print(complaint, file=sys.stderr)
    return EXIT_BAD_INPUT if complaints else 0


class _Described(TypedDict):
    """What a list tells of a model."""

    name: str
    width: int
    height: int
    parameters: int
    bytes: int
    iou: float | None
    frame_ms: float


def _cells(model: _Described) -> tuple[str, ...]:
    return (
        model["name"],
        f"{model['width']}x{model['height']}",
        f"{model['parameters'] / 1e6:.1f} million",
        f"{model['bytes'] / 1e6:.1f} MB",
        "N/A" if model["iou"] is None else f"{model['iou']:.2f}",
        f"{model['frame_ms']:.0f} ms",
    )


def _described(name: str, model: Model, device: str) -> _Described:
    """Return what a list tells of a model; how long its fusion takes for a frame is measured, here and now."""
    card, modality = model.card, min(model.card.networks)
    files = {file for network in card.networks.values() for file in network.files}
    segmenter = Segmenter(model, device=device)
    times = []
    for _ in range(_FRAMES):
        begun = perf_counter()
        segmenter.warm_up(modality)
        times.append(perf_counter() - begun)
    return {
        "name": name,
        "width": card.width,
        "height": card.height,
        "parameters": card.networks[modality].parameters,
        "bytes": sum((model.folder / file).stat().st_size for file in files),
        "iou": _test_iou(card.results, modality),
        "frame_ms": min(times) * 1e3,
    }


def _test_iou(results: Mapping[str, object], modality: Modality) -> float | None:
    """Return the IoU on the town that was kept for the test, where the training that wrote the card measured it."""
    found: object = results
    for key in ("iou_per_image", "test town", modality.key):
        found = found.get(key) if isinstance(found, Mapping) else None
    return float(found) if isinstance(found, int | float) else None


def show(arguments: argparse.Namespace) -> int:
    """Print a card."""
    model = load_model(arguments.model)
    print(json.dumps(model.card.to_json(), sort_keys=True) if arguments.json else model.card.to_text())
    return 0


def import_model(arguments: argparse.Namespace) -> int:
    """Make a model of checkpoints."""
    out = arguments.out or Path(f"{arguments.checkpoints.resolve().name}-model")
    if out.exists():
        raise OutputError(f"The folder {out} exists: name a new one for the model with --out.")
    width, height = arguments.size
    with stages_progress() as progress:
        model = import_checkpoints(
            arguments.checkpoints,
            out,
            name=arguments.name or out.resolve().name,
            height=height,
            width=width,
            progress=progress,
        )
    print(
        f"The model is in {out}; its thresholds are not known yet: run 'sunset models calibrate {out}' next, with "
        "--bag if it is meant for frames of your own.",
        file=sys.stderr,
    )
    if missing := missing_networks(model):
        print(f"It can be measured, but cannot fly without {missing}.", file=sys.stderr)
    return 0


def calibrate(arguments: argparse.Namespace) -> int:
    """Calibrate a model."""
    model = load_model(arguments.model)
    check_target(model, arguments.out)
    device = find_device(arguments.device)
    size = (model.card.height, model.card.width)
    with stages_progress() as progress:
        if arguments.bag is None:
            source = "flights over town 7"
            frames = validation_flight(size, jobs=arguments.jobs, progress=progress)
        else:
            name = os.fsencode(arguments.bag.resolve().name).decode("utf-8", "replace")  # for the card
            source = f"the bag {name}"
            frames = frames_of_bag(arguments.bag, size)
        calibrated = calibrate_model(
            model,
            frames,
            arguments.out,
            source=source,
            jobs=arguments.jobs,
            device=device,
            progress=progress,
        )
    card = calibrated.card
    for modality, network in sorted(card.networks.items()):
        print(f"{modality.key + ' temperature':22}{network.temperature:.4f}")
    print(f"{'entropy threshold':22}{card.entropy_threshold:.4f}")
    print(f"{'sharpness threshold':22}{card.sharpness_threshold:.4f}")
    use = f"'sunset run --model {calibrated.folder}' runs with it"
    if missing := missing_networks(calibrated):
        use = f"it can be measured, but cannot fly without {missing}"
    print(f"The model in {calibrated.folder} is calibrated; {use}.", file=sys.stderr)
    return 0


def curves(arguments: argparse.Namespace) -> int:
    """Measure a model by fault and strength."""
    model, device = load_model(arguments.model), find_device(arguments.device)
    bag = arguments.bag or _default_flight(model, arguments.jobs)
    _prepare(arguments.out)
    with progress_bar("Measuring") as progress:
        measured = measure_curves(
            model,
            bag,
            every=arguments.every,
            strengths=dict(arguments.at),
            jobs=arguments.jobs,
            device=device,
            progress=progress,
        )
    print(
        json.dumps(as_json(measured), sort_keys=True) + "\n" if arguments.json else as_text(measured), end=""
    )
    if arguments.out is not None:
        write_text(arguments.out / "curves.csv", as_csv(measured))
        write_text(arguments.out / "curves.json", json.dumps(as_json(measured), indent=2) + "\n")
        try:
            draw(measured, arguments.out)
        except MissingExtraError as error:
            print(error, file=sys.stderr)
    return 0


def _default_flight(model: Model, jobs: int | None) -> Path:
    plan = replace(DEFAULT_FLIGHT, size=(model.card.height, model.card.width))
    with rendering_progress() as progress:
        return flight_bag(plan, progress=progress, jobs=jobs)


def _prepare(out: Path | None) -> None:
    """Find out whether results can be written before they are computed."""
    if out is not None:
        make_folder(out)


def iou(arguments: argparse.Namespace) -> int:
    """Measure models on held-out towns."""
    models = [load_model(name) for name in dict.fromkeys(arguments.models or installed_models())]
    _prepare(arguments.out)
    with stages_progress() as stage:
        tables = measure_iou(
            models,
            frames=arguments.frames,
            jobs=arguments.jobs,
            device=arguments.device,
            progress=_named(stage, "Measuring"),
            rendering=_named(stage, "Rendering (once)"),
        )
    text = iou_markdown(tables)
    print(json.dumps(iou_json(tables), sort_keys=True) + "\n" if arguments.json else text, end="")
    if arguments.out is not None:
        write_text(arguments.out / "iou.md", text)
        write_text(arguments.out / "iou.csv", iou_csv(tables))
    return 0


def _named(stage: Callable[[str, int, int], None], name: str) -> Callable[[int, int], None]:
    return lambda done, total: stage(name, done, total)
