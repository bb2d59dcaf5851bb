"""Models that are made: trained, or of published checkpoints."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from sunset.api.options import as_path, check_flags, check_progress, count_of, whole_of
from sunset.errors import InvalidInputError, OutputError
from sunset.perception import Model, load_model
from sunset.processes.workers import processors
from sunset.texts import shown, suggestion


def train_model(
    model: str,
    out: str | Path,
    *,
    name: str | None = None,
    modality: str = "all",
    seed: int = 1,
    steps: int | None = None,
    frames: int | None = None,
    batch: int | None = None,
    start_from: str | Path | None = None,
    resume: bool = False,
    work: str | Path = "training",
    jobs: int | None = None,
    device: str = "cpu",
    compiled: bool = False,
    progress: Callable[..., None] | None = None,
) -> Model:
    """Train the networks of a model on rendered towns, as `sunset train` does, and return it.

    Args:
        model: architecture and schedule: `lite` or `reference`.
        out: the model's folder.
        name: in the model's card, in records and reports; that of its folder if None.
        modality: which networks: `rgb`, `depth` or `all`; the fusion contains both branches, so it means all.
        seed: of everything that is drawn.
        steps: of the optimiser; as planned for `model` if None.
        frames: about how many to train on; if None 5500, and 20,000 for a model that is trained further.
        batch: frames a step; as planned for `model` if None.
        start_from: the name or folder of a model that is trained further; random weights if None.
        resume: whether to continue what an interrupted training left in `work`.
        work: the folder of frames, checkpoints and logs.
        jobs: processes that render and measure; one a core if None.
        device: what networks are trained on: `cpu`, `cuda` or `auto`.
        compiled: whether torch compiles the networks.
        progress: called with (what is done, how much of it, how much in all, a note); what it raises ends the training
            in order, so that it can be resumed.

    Raises:
        SunsetError: torch or onnx is not installed, a value cannot be used, or a folder cannot be written.
    """
    from sunset.training import CONFIGS, MODALITIES, FrameCounts, train  # noqa: PLC0415  takes long to import

    check_progress(progress)
    check_flags(resume=resume, compiled=compiled)
    for value, values in ((model, tuple(CONFIGS)), (modality, ("all", *MODALITIES))):
        if value not in values:
            raise InvalidInputError(
                f"There is nothing to train called {shown(value)}: {suggestion(value, values)}choose among "
                f"{', '.join(values)}."
            )
    steps, frames = count_of(steps, "steps"), count_of(frames, "frames")
    batch, jobs = count_of(batch, "batch"), count_of(jobs, "jobs")
    folder = as_path(out, "model's folder")
    config = replace(
        CONFIGS[model](),
        name=name or folder.resolve().name,
        modalities=MODALITIES if modality in {"all", "fusion"} else (modality,),
        seed=whole_of(seed),
    )
    config = config if start_from is None else config.started()
    config = config if steps is None else config.with_steps(steps)
    if start_from is None:
        counts = FrameCounts() if frames is None else FrameCounts.of(frames)
    else:  # learned weights know the default flight's setting best
        counts = FrameCounts.of(frames or 20_000, flight=2, other=3)
    return train(
        config if batch is None else config.with_batch(batch),
        folder,
        work=as_path(work, "work folder"),
        counts=counts,
        start=None if start_from is None else load_model(start_from),
        resume=resume,
        jobs=jobs or processors(),
        device=device,
        compiled=compiled,
        progress=progress,
    )


def import_model(
    checkpoints: str | Path,
    out: str | Path,
    *,
    name: str | None = None,
    size: tuple[int, int] = (256, 144),
    progress: Callable[[str, int, int], None] | None = None,
) -> Model:
    """Make a model of the published checkpoints, as `sunset models import` does, and return it.

    It has no thresholds until `calibrate_model` gave it some. No code of the checkpoints is executed.

    Args:
        checkpoints: the folder of `rgb.pth`, `depth.pth` and `fusion.pth`, those that are there.
        out: the new model's folder.
        name: in the model's card; that of its folder if None.
        size: width and height of the images that it takes, in pixels.
        progress: called with (what is done, how much of it, how much in all).

    Raises:
        SunsetError: torch or onnx is not installed, a checkpoint is not usable, or the folder exists or cannot be
            written.
    """
    from sunset.training import import_checkpoints  # noqa: PLC0415  takes long to import

    check_progress(progress)
    folder = as_path(out, "model's folder")
    if folder.exists():
        raise OutputError(
            f"The folder {folder} exists: name a new one for the model with --out, in Python with out."
        )
    match size:
        case int(width), int(height):
            pass
        case _:
            raise InvalidInputError(
                f"The size must be width and height in pixels, such as (256, 144), got {size!r}."
            )
    return import_checkpoints(
        as_path(checkpoints, "folder of the checkpoints"),
        folder,
        name=name or folder.resolve().name,
        height=height,
        width=width,
        progress=progress,
    )
