"""A training run, from nothing to a model's folder with its card."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

import numpy as np

from sunset.classes import CLASSES
from sunset.errors import MissingExtraError, OutputError
from sunset.perception import Modality, Model, ModelCard, Segmenter, load_model
from sunset.training.batches import FrameSet
from sunset.training.config import TrainingConfig
from sunset.training.evaluate import Measured, measure
from sunset.training.frames import VALIDATION_TOWN, FrameCounts, FrameSets, render_sets
from sunset.training.inputs import HEIGHT, WIDTH
from sunset.training.recalibrate import calibrate_model, version_of
from sunset.training.report import held_out_results, training_facts
from sunset.training.training_log import draw_log

if TYPE_CHECKING:
    from torch import nn

    from sunset.training.loop import Start
    from sunset.training.onnx_graph import Format
    from sunset.training.onnx_layers import Weights
    from sunset.training.stage import Progress

_FINISH: Final = "finish"
"""The folder in which a model is finished when its weights are learned."""
_KEPT: Final = "kept"
"""The folder in that one in which results of measuring are kept."""


def train(
    config: TrainingConfig,
    out: Path,
    *,
    work: Path,
    counts: FrameCounts | None = None,
    start: Model | None = None,
    resume: bool = False,
    jobs: int = 2,
    device: str = "cpu",
    compiled: bool = False,
    progress: "Progress | None" = None,
) -> Model:
    """Render frames, learn weights, calibrate, measure, and write a model.

    Args:
        config: what to train.
        out: the model's folder: networks, `card.json`, `card.md`.
        work: keeps frames, checkpoints and the log; what is there already is used again.
        counts: how many frames to render.
        start: a model whose weights the networks begin with; None for random ones.
        resume: go on at the last checkpoint in `work`, if there is one; else it must hold none.
        jobs: processes that render and measure.
        device: what networks are learned on, "cpu", "cuda" or "auto", which is "cuda" where torch offers it.
        compiled: let torch compile the networks for the device.
        progress: called now and then; what it raises ends the training in order, so that it can be resumed.

    Raises:
        MissingExtraError: torch or onnx is not installed, or torch cannot use the device.
        OutputError: a folder cannot be written.
        InvalidInputError: the checkpoint to resume at is another training's or of other frames, or `start` has other
            networks.
        ModelError: a network's file of `start` is not a network.
    """
    _check_extra()
    from sunset.training.loop import check_work, find_torch_device  # noqa: PLC0415  torch is an optional dependency

    _start(start, config)  # to know before hours of work
    find_torch_device(device)
    for folder in (out, work):  # without making them
        there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
        try:
            TemporaryDirectory(dir=there).cleanup()
        except OSError as error:
            raise OutputError(f"The training cannot write to {folder}: {error.strerror}.") from error
    check_work(config, work, resume=resume)
    sets = render_sets(counts or FrameCounts(), work / "frames", jobs=jobs, progress=progress)
    return train_on(
        config,
        sets,
        out,
        work=work,
        start=start,
        resume=resume,
        jobs=jobs,
        device=device,
        compiled=compiled,
        progress=progress,
    )


def train_on(
    config: TrainingConfig,
    sets: FrameSets,
    out: Path,
    *,
    work: Path,
    start: Model | None = None,
    resume: bool = False,
    jobs: int = 1,
    device: str = "cpu",
    compiled: bool = False,
    progress: "Progress | None" = None,
) -> Model:
    """Do what `train` does with frames that are there already.

    Raises:
        SunsetError: as `train`.
    """
    _check_extra()
    from sunset.training.loop import find_torch_device, learn  # noqa: PLC0415  torch is an optional dependency
    from sunset.training.stage import LOG  # noqa: PLC0415

    begin = _start(start, config)
    logs = {stage.name: work / stage.name / LOG for stage in config.stages()}
    try:
        modules = learn(
            config,
            sets.train,
            sets.validation,
            work,
            start=begin,
            resume=resume,
            device=device,
            compiled=compiled,
            progress=progress,
        )
        for log in logs.values():
            draw_log(log, log.with_suffix(".png"))
        draft, kept = _empty_folder(work / _FINISH / "draft"), work / _FINISH / _KEPT

        def measured(what: str, model: Model, frames: FrameSet) -> dict[Modality, Measured]:
            note = partial(progress, what) if progress else None
            return measure(model, frames, jobs=jobs, progress=note, kept=kept)

        results = _export(config, modules, sets, draft, measured)
        model = calibrate_model(
            load_model(draft),
            sets.validation_flight,
            source=f"two flights over town {VALIDATION_TOWN}",
            jobs=jobs,
            progress=progress,
            kept=kept,
        )
        held_out = {
            name: measured(f"Measuring on the {name} town", model, frames)
            for name, frames in (("validation", sets.validation), ("test", sets.test))
        }
        results |= held_out_results(held_out)
        facts = training_facts(config, sets, logs, find_torch_device(device).type, begin)
        replace(model.card, training=facts, results={**results, **model.card.results}).write(draft)
        out.mkdir(parents=True, exist_ok=True)
        for path in sorted(draft.iterdir(), reverse=True):  # the card last
            shutil.copyfile(path, out / f"{path.name}.tmp")
            (out / f"{path.name}.tmp").replace(out / path.name)
        shutil.rmtree(work / _FINISH)
    except OSError as error:
        raise OutputError(
            f"The training cannot write to {out} or {work}: {error.strerror or error}."
        ) from error
    return load_model(out)


def _check_extra() -> None:
    missing = [name for name in ("torch", "onnx", "matplotlib") if find_spec(name) is None]
    if missing:
        raise MissingExtraError(
            f"Training needs {' and '.join(missing)}, not installed: pip install 'sunset-exemplar[train]'."
        )


def _start(model: Model | None, config: TrainingConfig) -> "Start | None":
    from sunset.training.loop import Start  # noqa: PLC0415  torch is an optional dependency
    from sunset.training.onnx_reader import stored_weights  # noqa: PLC0415  onnx is one, too

    if model is None:
        return None
    card = model.card
    return Start(f"{card.name}, version {card.version}", stored_weights(model, config), card.training)


def _empty_folder(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def _export(
    config: TrainingConfig,
    modules: "nn.Module",
    sets: FrameSets,
    draft: Path,
    measured: Callable[[str, Model, FrameSet], dict[Modality, Measured]],
) -> dict[str, object]:
    """Write the networks in 8 bits and a card without temperatures and thresholds.

    Returns:
        What 8 bits cost, and how exact the networks are in float32, in which they are also written, for a while.
    """
    from sunset.training.network import folded_weights  # noqa: PLC0415  torch is an optional dependency
    from sunset.training.onnx_graph import Format  # noqa: PLC0415  onnx is one, too
    from sunset.training.quantise import ranges  # noqa: PLC0415

    weights = folded_weights(config.plan(config.modalities), modules)
    limits = ranges(config.plan(config.branches), modules, sets.train, draft.parent / _KEPT)
    _write(config, weights, Format(ranges=limits), draft)
    exact = _empty_folder(draft.parent / "exact")
    _write(config, weights, Format(), exact)
    models = {"float32": load_model(exact), "int8": load_model(draft)}
    found = {name: measured(f"Measuring {name}", model, sets.validation) for name, model in models.items()}
    errors = _errors(config, modules, Segmenter(models["float32"]), sets.validation)
    return {
        "iou_by_precision_on_the_validation_town": {
            modality.key: {name: round(float(each[modality].iou.mean()), 4) for name, each in found.items()}
            for modality in models["int8"].card.networks
        },
        "largest_difference_of_logits_from_torch": errors,
    }


def _errors(
    config: TrainingConfig, modules: "nn.Module", segmenter: Segmenter, frames: FrameSet
) -> dict[str, float]:
    """Return by network how far logits are from torch's on four frames, at most."""
    import torch  # noqa: PLC0415  an optional dependency

    from sunset.training.network import forward, frame_inputs  # noqa: PLC0415

    errors: dict[str, float] = {}
    for index in range(min(4, len(frames))):
        bgr, depth = np.array(frames.bgr[index]), np.array(frames.depth[index])
        results = frame_inputs(bgr[None], depth[None])
        with torch.no_grad():
            forward(config.plan(config.modalities), modules, results)
        for modality in segmenter.model.card.networks:
            expected = results[f"{modality.key}.logits"][0].numpy()
            error = float(np.abs(segmenter.logits(modality, bgr, depth) - expected).max())
            errors[modality.key] = max(error, errors.get(modality.key, 0.0))
    return errors


def _write(config: TrainingConfig, weights: "Weights", form: "Format", out: Path) -> None:
    """Write networks and a card."""
    from sunset.training.onnx_graph import Network, export  # noqa: PLC0415  onnx is an optional dependency

    modalities = [modality for modality in Modality if modality.key in config.modalities]
    networks = {modality: Network(config.layers(modality.key), weights) for modality in modalities}
    cards = export(out, networks, form)
    ModelCard(
        name=config.name,
        version=version_of(cards),
        description=config.shape.description + _DESCRIPTION,
        height=HEIGHT,
        width=WIDTH,
        classes=CLASSES,
        entropy_threshold=1.0,
        sharpness_threshold=0.0,
        networks=cards,
        architecture=config.shape.name,
        precision=form.precision,
    ).write(out)


_DESCRIPTION = (
    " Trained on rendered towns. The networks take raw frames: colours are normalised with "
    "ImageNet's mean and standard deviation; depth enters as log(depth / 50 m) and as its difference to its "
    "mean over blocks of 16 and 8 pixels, cut at 10 m and 2 m."
)
