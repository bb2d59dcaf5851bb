"""Segmentation models: trained, imported, calibrated and measured."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

from sunset.api.arguments import (
    Extensions,
    as_path,
    check_names,
    count_of,
    extended,
    number_of,
    optional_path,
    whole_of,
)
from sunset.calibration import fit_to_flight
from sunset.data import DEFAULT_FLIGHT, flight_bag, read_bag
from sunset.errors import InvalidInputError, OutputError
from sunset.experiments import inference_file, missing_networks
from sunset.perception import Model, find_device, list_models, load_model
from sunset.perception.card import MAX_SIDE
from sunset.processes.workers import Progress, processors
from sunset_ros.texts import shown, suggestion

__all__ = [
    "MAX_SIDE",
    "TrainingOptions",
    "calibrate_model",
    "import_model",
    "measure_curves",
    "measure_iou",
    "missing_networks",
    "train_model",
]

if TYPE_CHECKING:
    from sunset_lab import FrameCounts, TrainingConfig
    from sunset_lab.curves import Curves
    from sunset_lab.tables import IouTables

# The functions import `sunset_lab` when they are called, since it takes long.
# ruff: noqa: PLC0415


class TrainingOptions(TypedDict, total=False):
    """Options of a training; each can be left out.

    Attributes:
        name: in the model's card, in records and reports; its folder's name if left out.
        modality: which networks: `rgb`, `depth` or `all`; the fusion contains both branches, so it means all.
        seed: of everything that is drawn; 1 if left out.
        steps: of the optimiser; as planned for the architecture if left out.
        frames: about how many to train on; 5500 if left out, and 20,000 for a model that is trained further.
        batch: frames a step; as planned for the architecture if left out.
        start_from: the name or folder of a model that is trained further; random weights if left out.
        resume: whether to continue an interrupted training with the files in `work`.
        work: the folder of frames, checkpoints and logs; `training` if left out.
        jobs: processes that render and measure; a process per core if left out.
        device: where networks are trained: `cpu`, `cuda` or `auto`.
        compiled: whether torch compiles the networks.
    """

    name: str | None
    modality: str
    seed: int
    steps: int | None
    frames: int | None
    batch: int | None
    start_from: str | Path | None
    resume: bool
    work: str | Path
    jobs: int | None
    device: str
    compiled: bool


def train_model(
    model: str,
    out: str | Path,
    *,
    progress: Callable[..., None] | None = None,
    **options: Unpack[TrainingOptions],
) -> Model:
    """Train the networks of a model on rendered towns, as `sunset train` does, and return it.

    Args:
        model: architecture and schedule: `lite` or `reference`.
        out: the model's folder.
        progress: called with (stage, steps done, all steps, a note); an exception that it raises ends the training in
            order, so that it can be resumed.
        **options: as in `sunset.TrainingOptions`.

    Raises:
        SunsetError: torch or onnx is not installed, a value cannot be used, or a folder cannot be written.
    """
    from sunset_lab import check_extra

    check_names(options, TrainingOptions.__annotations__)
    resume, compiled = options.get("resume", False), options.get("compiled", False)
    folder, start_from = as_path(out, "model's folder"), options.get("start_from")
    config = replace(_training_config(model, options), name=options.get("name") or folder.resolve().name)
    work = as_path(options.get("work", "training"), "work folder")
    check_extra("Training", "torch", "onnx", "matplotlib")
    from sunset_lab.run import train

    return train(
        config,
        folder,
        work=work,
        counts=_frame_counts(options),
        start=None if start_from is None else load_model(start_from),
        resume=resume,
        jobs=count_of(options.get("jobs"), "jobs") or processors(),
        device=options.get("device", "cpu"),
        compiled=compiled,
        progress=progress,
    )


def _frame_counts(options: TrainingOptions) -> "FrameCounts":
    from sunset_lab import FrameCounts

    count = count_of(options.get("frames"), "frames")
    if options.get("start_from") is not None:  # learned weights know the default flight's setting best
        return FrameCounts.of(count or 20_000, flight=2, other=3)
    return FrameCounts() if count is None else FrameCounts.of(count)


def _training_config(model: str, options: TrainingOptions) -> "TrainingConfig":
    from sunset_lab import CONFIGS, MODALITIES

    modality = options.get("modality", "all")
    for value, values in ((model, tuple(CONFIGS)), (modality, ("all", *MODALITIES))):
        if value not in values:
            raise InvalidInputError(
                f"There is nothing to train called {shown(value)}: {suggestion(value, values)}choose among "
                f"{', '.join(values)}."
            )
    steps, batch = count_of(options.get("steps"), "steps"), count_of(options.get("batch"), "batch")
    config = replace(
        CONFIGS[model](),
        modalities=MODALITIES if modality in {"all", "fusion"} else (modality,),
        seed=whole_of(options.get("seed", 1)),
    )
    config = config if options.get("start_from") is None else config.started()
    config = config if steps is None else config.with_steps(steps)
    return config if batch is None else config.with_batch(batch)


def import_model(
    checkpoints: str | Path,
    out: str | Path,
    *,
    name: str | None = None,
    size: tuple[int, int] = (256, 144),
    progress: Callable[[str, int, int], None] | None = None,
) -> Model:
    """Make a model of the published checkpoints, as `sunset models import` does, and return it.

    It lacks thresholds until `calibrate_model` sets them. No code of the checkpoints is executed.

    Args:
        checkpoints: the folder of `rgb.pth`, `depth.pth` and `fusion.pth`, those that exist.
        out: the new model's folder.
        name: in the model's card; its folder's name if None.
        size: width and height of the images that it takes, in pixels.
        progress: called with (stage, steps done, all steps).

    Raises:
        SunsetError: torch or onnx is not installed, a checkpoint is not usable, or the folder exists or cannot be
            written.
    """
    from sunset_lab import check_extra

    folder = as_path(out, "model's folder")
    if folder.exists():
        raise OutputError(
            f"The folder {folder} exists: name a new one for the model with --out, in Python with out."
        )
    width, height = _sides(size)
    source = as_path(checkpoints, "folder of the checkpoints")
    check_extra("Importing checkpoints", "torch", "onnx")
    from sunset_lab.importing import import_checkpoints

    name = name or folder.resolve().name
    return import_checkpoints(source, folder, name=name, height=height, width=width, progress=progress)


def _sides(size: tuple[int, int]) -> tuple[int, int]:
    match size:
        case int(width), int(height):
            return width, height
    raise InvalidInputError(f"The size must be width and height in pixels, such as (256, 144), got {size!r}.")


def calibrate_model(
    model: str | Path | Model,
    bag: str | Path | None = None,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Callable[..., None] | None = None,
    extensions: Extensions = (),
) -> Model:
    """Set a model's temperatures and thresholds, as `sunset models calibrate` does, and return it.

    Args:
        model: its name or folder, or a model of `load_model`.
        bag: good frames for the calibration; flights over a held-out town if it is None.
        out: a new folder for the calibrated model; the model's own is changed if it is None.
        jobs: worker processes; a process per core if None.
        device: where networks run: `cpu`, `cuda` or `auto`.
        progress: called with (stage, steps done, all steps).
        extensions: whose faults are looked at, too.

    Raises:
        SunsetError: the model or the bag is not usable, or the result cannot be written.
    """
    from sunset_lab import check_extra, frames_of_bag, validation_flight

    loaded, target = _loaded(model), optional_path(out, "model's folder")
    check_extra("Calibrating", "onnx")
    from sunset_lab import calibrate

    calibrate.check_target(loaded, target)
    device, jobs = find_device(device), count_of(jobs, "jobs")
    if (path := optional_path(bag, "bag")) is None:
        frames = validation_flight(_size(loaded), jobs=jobs, progress=progress)
        source = "flights over town 7"
    else:
        frames = frames_of_bag(path, _size(loaded))
        source = f"the bag {os.fsencode(path.resolve().name).decode('utf-8', 'replace')}"  # as the card can hold it
    with extended(extensions):
        return calibrate.calibrate_model(
            loaded, frames, target, source=source, jobs=jobs, device=device, progress=progress
        )


def measure_curves(
    model: str | Path | Model,
    bag: str | Path | None = None,
    *,
    every: int = 1,
    strengths: Mapping[str, float] | None = None,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
    rendering: Progress | None = None,
    extensions: Extensions = (),
) -> "Curves":
    """Measure a model by fault and strength, as `sunset models curves` does.

    Args:
        model: its name or folder, or a model of `load_model`.
        bag: with the frames; the default flight in the model's size if it is None.
        every: measure every n-th group of five consecutive frames only.
        strengths: fault → strength to measure at in place of the suites' strengths.
        jobs: worker processes; a process per core if None.
        device: where networks run: `cpu`, `cuda` or `auto`.
        progress: called with (frames done, all frames).
        rendering: called likewise while the flight is rendered.
        extensions: whose faults are measured, too.

    Raises:
        SunsetError: the model, the bag, a fault or a strength is not usable.
    """
    from sunset_lab import curves

    loaded, device, jobs = _loaded(model), find_device(device), count_of(jobs, "jobs")
    groups = count_of(every, "groups of frames") or 1
    with extended(extensions):
        plan = replace(DEFAULT_FLIGHT, size=_size(loaded))
        path = optional_path(bag, "bag") or flight_bag(plan, progress=rendering, jobs=jobs)
        chosen, fitted = _strengths_of(strengths), _fitted(loaded, path, device, jobs)
        return curves.measure_curves(
            fitted, path, every=groups, strengths=chosen, jobs=jobs, device=device, progress=progress
        )


def measure_iou(
    models: str | Path | Model | Sequence[str | Path | Model] = (),
    *,
    frames: int | None = None,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
    rendering: Progress | None = None,
) -> "IouTables":
    """Measure models on held-out towns, as `sunset models iou` does.

    Args:
        models: names, folders or models of `load_model`, as a list or alone; all installed models if empty.
        frames: views of each held-out town, and frames of the default flight; if None, two views of every setting, and
            the whole flight.
        jobs: worker processes; a process per core if None.
        device: where networks run: `cpu`, `cuda` or `auto`.
        progress: called with (frames done, all frames).
        rendering: called likewise while frames are rendered, once.

    Raises:
        SunsetError: a model is not usable.
    """
    from sunset_lab import tables

    listed = [models] if isinstance(models, str | Path | Model) else models
    if not isinstance(listed, list | tuple):
        raise InvalidInputError(f"The models must be a list of names or folders, got {shown(models)}.")
    return tables.measure_iou(
        list({model.folder: model for model in map(_loaded, listed or list_models())}.values()),
        frames=count_of(frames, "frames"),
        jobs=count_of(jobs, "jobs"),
        device=device,
        progress=progress,
        rendering=rendering,
    )


def _loaded(model: str | Path | Model) -> Model:
    return model if isinstance(model, Model) else load_model(model)


def _size(model: Model) -> tuple[int, int]:
    return model.card.height, model.card.width


def _fitted(model: Model, bag: Path, device: str, jobs: int | None) -> Model:
    """Return a model with the thresholds that hold on a bag."""
    cache = inference_file() if device == "cpu" else None
    with read_bag(bag, size=_size(model)) as reader:
        return fit_to_flight(model, reader, device=device, cache=cache, jobs=jobs)[0]


def _strengths_of(strengths: Mapping[str, float] | None) -> dict[str, float] | None:
    if strengths is None:
        return None
    numbers = isinstance(strengths, Mapping) and {name: number_of(value) for name, value in strengths.items()}
    if not isinstance(numbers, dict) or not all(type(number) is float for number in numbers.values()):
        raise InvalidInputError(
            f"The strengths must be numbers by fault, such as {{'image_shift': 8}}, got {shown(strengths)}."
        )
    return numbers
