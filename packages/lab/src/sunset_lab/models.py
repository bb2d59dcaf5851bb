"""Segmentation models: trained, imported, calibrated and measured."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TypedDict, Unpack

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
from sunset.errors import InvalidInputError, MissingExtraError, OutputError
from sunset.experiments import cache_file
from sunset.perception import Model, find_device, list_models, load_model
from sunset.processes.workers import Progress, processors
from sunset_lab import (
    CONFIGS,
    MODALITIES,
    TrainingConfig,
    curves,
    frames_of_bag,
    tables,
    validation_flight,
)
from sunset_lab.measuring import LookOptions
from sunset_ros.texts import shown, suggestion

# ruff: noqa: PLC0415  torch and onnx, of the extra `train`, are imported when they are needed


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
    check_names(options, TrainingOptions.__annotations__)
    resume, compiled = options.get("resume", False), options.get("compiled", False)
    folder, work = as_path(out, "model's folder"), as_path(options.get("work", "training"), "work folder")
    config = _training_config(model, options.get("name") or folder.resolve().name, options)
    start = options.get("start_from")
    _check_extra("Training", "torch", "onnx")
    from sunset_lab.run import train
    from sunset_lab.stage import Training

    training = Training(
        config,
        work,
        start=None if start is None else load_model(start),
        resume=resume,
        jobs=count_of(options.get("jobs"), "jobs") or processors(),
        device=options.get("device", "cpu"),
        compiled=compiled,
        progress=progress,
    )
    return train(training, folder, count_of(options.get("frames"), "frames"))


def _training_config(model: str, name: str, options: TrainingOptions) -> TrainingConfig:
    modality = options.get("modality", "all")
    for value, values in ((model, tuple(CONFIGS)), (modality, ("all", *MODALITIES))):
        if value not in values:
            raise InvalidInputError(
                f"There is nothing to train called {shown(value)}: {suggestion(value, values)}choose among "
                f"{', '.join(values)}."
            )
    modalities = MODALITIES if modality in {"all", "fusion"} else (modality,)
    config = replace(CONFIGS[model], name=name, modalities=modalities, seed=whole_of(options.get("seed", 1)))
    config = config if options.get("start_from") is None else config.started()
    steps, batch = count_of(options.get("steps"), "steps"), count_of(options.get("batch"), "batch")
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
    folder = as_path(out, "model's folder")
    if folder.exists():
        raise OutputError(
            f"The folder {folder} exists: name a new one for the model with --out, in Python with out."
        )
    width, height = _sides(size)
    source, name = as_path(checkpoints, "folder of the checkpoints"), name or folder.resolve().name
    _check_extra("Importing checkpoints", "torch", "onnx")
    from sunset_lab.importing import import_checkpoints

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
    loaded, target = _loaded(model), optional_path(out, "model's folder")
    _check_extra("Calibrating", "onnx")
    from sunset_lab import calibrate

    calibrate.check_target(loaded, target)
    options = _look_options(device, jobs)
    if (path := optional_path(bag, "bag")) is None:
        frames = validation_flight(_size(loaded), jobs=options["jobs"], progress=progress)
        source = "flights over town 7"
    else:
        frames = frames_of_bag(path, _size(loaded))
        source = f"the bag {os.fsencode(path.resolve().name).decode('utf-8', 'replace')}"  # as the card can hold it
    with extended(extensions):
        return calibrate.calibrate_model(loaded, frames, target, source=source, stages=progress, **options)


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
) -> curves.Curves:
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
    loaded, options = _loaded(model), _look_options(device, jobs, progress)
    device, jobs = options["device"], options["jobs"]
    groups = count_of(every, "groups of frames") or 1
    with extended(extensions):
        plan = replace(DEFAULT_FLIGHT, size=_size(loaded))
        path = optional_path(bag, "bag") or flight_bag(plan, progress=rendering, jobs=jobs)
        chosen, cache = _strengths_of(strengths), cache_file() if device == "cpu" else None
        with read_bag(path, size=_size(loaded)) as reader:  # the thresholds that hold on it
            fitted, _ = fit_to_flight(loaded, reader, device=device, cache=cache, jobs=jobs)
        return curves.measure_curves(fitted, path, every=groups, strengths=chosen, **options)


def measure_iou(
    models: str | Path | Model | Sequence[str | Path | Model] = (),
    *,
    frames: int | None = None,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
    rendering: Progress | None = None,
) -> tables.IouTables:
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
    listed = [models] if isinstance(models, str | Path | Model) else models
    if not isinstance(listed, list | tuple):
        raise InvalidInputError(f"The models must be a list of names or folders, got {shown(models)}.")
    return tables.measure_iou(
        list({model.folder: model for model in map(_loaded, listed or list_models())}.values()),
        frames=count_of(frames, "frames"),
        rendering=rendering,
        **_look_options(device, jobs, progress),
    )


def _loaded(model: str | Path | Model) -> Model:
    return model if isinstance(model, Model) else load_model(model)


def _size(model: Model) -> tuple[int, int]:
    return model.card.height, model.card.width


def _look_options(device: str, jobs: int | None, progress: Progress | None = None) -> LookOptions:
    return {"device": find_device(device), "jobs": count_of(jobs, "jobs"), "progress": progress}


def _strengths_of(strengths: Mapping[str, float] | None) -> dict[str, float]:
    if strengths is None:
        return {}
    if isinstance(strengths, Mapping):
        numbers = {name: number_of(value) for name, value in strengths.items()}
        if all(type(number) is float for number in numbers.values()):
            return numbers
    raise InvalidInputError(
        f"The strengths must be numbers by fault, such as {{'image_shift': 8}}, got {shown(strengths)}."
    )


def _check_extra(purpose: str, *packages: str) -> None:
    """Check that packages of the extra `train` are installed."""
    missing = [name for name in packages if find_spec(name) is None]
    if missing:
        raise MissingExtraError(
            f"{purpose} needs {' and '.join(missing)}, not installed: pip install 'sunset-exemplar[train]'."
        )
