"""Models: training, import and calibration.

The functions raise a `SunsetError` where an extra is missing, a value cannot be used, or a file cannot be written.
"""

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

from sunset.api.options import (
    Extensions,
    as_path,
    check_flags,
    check_progress,
    count_of,
    extended,
    whole_of,
)
from sunset.errors import InvalidInputError, OutputError
from sunset.perception import Model, find_device, load_model
from sunset.processes.workers import processors
from sunset.texts import shown, suggestion

if TYPE_CHECKING:
    from sunset.training import TrainingConfig


class TrainingOptions(TypedDict, total=False):
    """The options of a training, each of which can be left out.

    Attributes:
        name: in the model's card, in records and reports; by default the name of its folder.
        modality: `rgb`, `depth`, or `all`, the default; the fusion contains both branches, so it means all.
        seed: of all random numbers; 1 by default.
        steps: of the optimiser; by default as planned for the model.
        frames: about how many to train on; by default 5500, and 20,000 with `start_from`.
        batch: frames a step; by default as planned for the model.
        start_from: the name or folder of a model to train further; random weights by default.
        resume: whether to continue an interrupted training in `work`.
        work: the folder of frames, checkpoints and logs; `training` by default.
        jobs: processes that render and measure; by default one a core.
        device: of the training: `cpu`, the default, `cuda` or `auto`.
        compiled: whether torch compiles the networks.
        progress: called with (title, work done, work in all, a note); its exceptions end the training in order, so that
            it can be resumed.
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
    progress: Callable[..., None] | None


def train_model(model: str, out: str | Path, **options: Unpack[TrainingOptions]) -> Model:
    """Train the networks of a model on rendered towns, as `sunset train` does, and return it.

    Args:
        model: architecture and schedule: `lite` or `reference`.
        out: the model's folder.
        **options: see `TrainingOptions`.
    """
    from sunset.training import FrameCounts, check_extra  # noqa: PLC0415  takes long to import

    folder = as_path(out, "model's folder")
    start_from, progress = options.get("start_from"), options.get("progress")
    check_progress(progress)
    config = _configuration(model, folder, options)
    frames, jobs = count_of(options.get("frames"), "frames"), count_of(options.get("jobs"), "jobs")
    work = as_path(options.get("work", "training"), "work folder")
    check_extra("Training", "torch", "onnx", "matplotlib")
    from sunset.training.run import train  # noqa: PLC0415  needs the extra

    if start_from is None:
        counts = FrameCounts() if frames is None else FrameCounts.of(frames)
    else:  # learned weights know the default flight's setting best
        counts = FrameCounts.of(frames or 20_000, flight=2, other=3)
    return train(
        config,
        folder,
        work=work,
        counts=counts,
        start=None if start_from is None else load_model(start_from),
        resume=options.get("resume", False),
        jobs=jobs or processors(),
        device=options.get("device", "cpu"),
        compiled=options.get("compiled", False),
        progress=progress,
    )


def _configuration(model: str, folder: Path, options: TrainingOptions) -> "TrainingConfig":
    """Return the configuration of a training."""
    unknown = sorted(options.keys() - TrainingOptions.__annotations__.keys())
    if unknown:
        raise InvalidInputError(f"A training has no option {unknown[0]!r}.")
    from sunset.training import CONFIGS, MODALITIES  # noqa: PLC0415  takes long to import

    modality = options.get("modality", "all")
    for value, values in ((model, tuple(CONFIGS)), (modality, ("all", *MODALITIES))):
        if value not in values:
            raise InvalidInputError(
                f"There is nothing to train called {shown(value)}: {suggestion(value, values)}choose among "
                f"{', '.join(values)}."
            )
    check_flags(resume=options.get("resume", False), compiled=options.get("compiled", False))
    steps, batch = count_of(options.get("steps"), "steps"), count_of(options.get("batch"), "batch")
    config = replace(
        CONFIGS[model](),
        name=options.get("name") or folder.resolve().name,
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

    `calibrate_model` gives it thresholds. Code in the checkpoints is not executed.

    Args:
        checkpoints: the folder of `rgb.pth`, `depth.pth` and `fusion.pth`, at least one of them.
        out: the new model's folder.
        name: in the model's card; the name of its folder if None.
        size: width and height of the images that it takes, in pixels.
        progress: called with (title, work done, work in all).
    """
    from sunset.training import check_extra  # noqa: PLC0415  takes long to import

    check_progress(progress)
    folder = as_path(out, "model's folder")
    if folder.exists():
        raise OutputError(
            f"The folder {folder} exists: name a new one for the model with --out, in Python with out."
        )
    width, height = _sides(size)
    check_extra("Importing checkpoints", "torch", "onnx")
    from sunset.training.importing import import_checkpoints  # noqa: PLC0415  needs the extra

    return import_checkpoints(
        as_path(checkpoints, "folder of the checkpoints"),
        folder,
        name=name or folder.resolve().name,
        height=height,
        width=width,
        progress=progress,
    )


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
    """Give a model temperatures and thresholds, as `sunset models calibrate` does, and return it.

    Args:
        model: its name or folder, or a loaded model.
        bag: with the frames; flights over a held-out town if it is None.
        out: a new folder for the calibrated model; the model's own is changed if it is None.
        jobs: worker processes; one a core if None.
        device: what networks run on: `cpu`, `cuda` or `auto`.
        progress: called with (title, work done, work in all).
        extensions: of the managed system, whose faults are used, too.
    """
    from sunset.training import check_extra, frames_of_bag, validation_flight  # noqa: PLC0415  takes long to import

    check_extra("Calibrating", "onnx")
    from sunset.training import calibrate  # noqa: PLC0415  needs the extra

    check_progress(progress)
    loaded, target = as_model(model), None if out is None else as_path(out, "model's folder")
    calibrate.check_target(loaded, target)
    device, jobs = find_device(device), count_of(jobs, "jobs")
    size = (loaded.card.height, loaded.card.width)
    if bag is None:
        frames, source = validation_flight(size, jobs=jobs, progress=progress), "flights over town 7"
    else:
        path = as_path(bag, "bag")
        name = os.fsencode(path.resolve().name).decode("utf-8", "replace")  # as the card can hold it
        frames, source = frames_of_bag(path, size), f"the bag {name}"
    with extended(extensions):
        return calibrate.calibrate_model(
            loaded, frames, target, source=source, jobs=jobs, device=device, progress=progress
        )


def as_model(model: str | Path | Model) -> Model:
    """Return a model that was given by name, by folder, or loaded."""
    return model if isinstance(model, Model) else load_model(model)


def _sides(size: tuple[int, int]) -> tuple[int, int]:
    match size:
        case int(width), int(height):
            return width, height
    raise InvalidInputError(f"The size must be width and height in pixels, such as (256, 144), got {size!r}.")
