"""A training: frames, weights, calibration, measurements, and the model's folder with its card."""

import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import asdict, fields, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, TypedDict, Unpack

import numpy as np
import torch
from torch import nn

from sunset.classes import CLASSES
from sunset.errors import OutputError
from sunset.perception import Modality, Model, Segmenter, load_model
from sunset_lab.batches import FrameSet
from sunset_lab.calibrate import calibrate_model
from sunset_lab.config import Stage, TrainingConfig
from sunset_lab.evaluate import Measured, measure
from sunset_lab.frames import VALIDATION_TOWN, FrameCounts, FrameSets, render_sets
from sunset_lab.loop import Start, check_work, find_torch_device, learn
from sunset_lab.network import folded_weights, forward, frame_inputs
from sunset_lab.onnx_graph import Format, Network, export
from sunset_lab.onnx_layers import Weights
from sunset_lab.onnx_reader import stored_weights
from sunset_lab.plots import draw_log
from sunset_lab.quantise import ranges
from sunset_lab.stage import LOG, Progress

_FINISH: Final = "finish"
"""The folder in which a model is finished when its weights are learned."""
_KEPT: Final = "kept"
"""The folder in that folder with the results of measurements."""

_Measure = Callable[[str, Model, FrameSet], Measured]


class RunOptions(TypedDict, total=False):
    """The options of `train`."""

    start: Model | None
    """A model to train further; None for random weights."""
    resume: bool
    """Whether to continue at the last checkpoint in the work folder, which must hold none otherwise."""
    jobs: int
    """Processes that render and measure; 1 by default."""
    device: str
    """Of the training: "cpu", "cuda", or "auto" for "cuda" where torch offers it."""
    compiled: bool
    """Whether torch compiles the networks."""
    progress: Progress | None
    """Called now and then; its exceptions end the training in order, so that it can be resumed."""


def train(
    config: TrainingConfig,
    out: Path,
    *,
    work: Path,
    counts: FrameCounts | None = None,
    **options: Unpack[RunOptions],
) -> Model:
    """Render frames, learn weights, calibrate, measure, and write a model.

    Frames, checkpoints and logs are kept in `work` and used again. `out` receives the networks, `card.json` and
    `card.md`.
    """
    _start(options.get("start"), config)  # mistakes are reported before hours of work
    find_torch_device(options.get("device", "cpu"))
    for folder in (out, work):  # without making them
        parent = next(path for path in (folder, *folder.absolute().parents) if path.exists())
        try:
            TemporaryDirectory(dir=parent).cleanup()
        except OSError as error:
            raise OutputError(f"The training cannot write to {folder}: {error.strerror}.") from error
    check_work(config, work, resume=options.get("resume", False))
    jobs, progress = options.get("jobs", 1), options.get("progress")
    sets = render_sets(counts or FrameCounts(), work / "frames", jobs=jobs, progress=progress)
    return train_on(config, sets, out, work=work, **options)


def train_on(
    config: TrainingConfig, sets: FrameSets, out: Path, *, work: Path, **options: Unpack[RunOptions]
) -> Model:
    """Train on given frames; see `train`."""
    start = _start(options.get("start"), config)
    try:
        modules = learn(
            config,
            sets.train,
            sets.validation,
            work,
            start=start,
            resume=options.get("resume", False),
            device=options.get("device", "cpu"),
            compiled=options.get("compiled", False),
            progress=options.get("progress"),
        )
        for log in _logs(config, work).values():
            draw_log(log, log.with_suffix(".png"))
        draft = _finished(config, modules, sets, work, start=start, options=options)
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


def _start(model: Model | None, config: TrainingConfig) -> Start | None:

    if model is None:
        return None
    card = model.card
    return Start(f"{card.name}, version {card.version}", stored_weights(model, config), card.training)


def _logs(config: TrainingConfig, work: Path) -> dict[str, Path]:
    """Return the logs of a training's stages."""
    return {stage.name: work / stage.name / LOG for stage in config.stages()}


def _empty_folder(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def _finished(
    config: TrainingConfig,
    modules: nn.Module,
    sets: FrameSets,
    work: Path,
    *,
    start: Start | None,
    options: RunOptions,
) -> Path:
    """Return the folder of the exported, calibrated and measured model."""
    jobs, progress = options.get("jobs", 1), options.get("progress")
    draft, kept = _empty_folder(work / _FINISH / "draft"), work / _FINISH / _KEPT

    def measured(title: str, model: Model, frames: FrameSet) -> Measured:
        note = partial(progress, title) if progress else None
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
    results |= _held_out_results(model, sets, measured)
    facts = _facts(config, sets, work, options.get("device", "cpu"), start)
    replace(model.card, training=facts, results={**results, **model.card.results}).write(draft)
    return draft


def _export(
    config: TrainingConfig, modules: nn.Module, sets: FrameSets, draft: Path, measured: _Measure
) -> dict[str, object]:
    """Write the networks in 8 bits, and a card without temperatures and thresholds.

    Returns:
        The IoU in 8 bits and in float32, and the errors of the networks in float32, which are written temporarily.
    """
    weights = folded_weights(config.plan(config.modalities), modules)
    limits = ranges(config.plan(config.branches), modules, sets.train, draft.parent / _KEPT)
    _write(config, weights, Format(ranges=limits), draft)
    exact = _empty_folder(draft.parent / "exact")
    _write(config, weights, Format(), exact)
    models = {"float32": load_model(exact), "int8": load_model(draft)}
    iou = {
        name: _iou_per_image(model, measured(f"Measuring {name}", model, sets.validation))
        for name, model in models.items()
    }
    errors = _errors(config, modules, Segmenter(models["float32"]), sets.validation)
    return {
        "iou_by_precision_on_the_validation_town": {
            key: {name: values[key] for name, values in iou.items()} for key in iou["int8"]
        },
        "largest_difference_of_logits_from_torch": errors,
    }


def _iou_per_image(model: Model, measured: Measured) -> dict[str, float]:
    keys = [modality.key for modality in sorted(model.card.networks)]
    return {key: round(float(iou), 4) for key, iou in zip(keys, measured.per_image(), strict=True)}


def _errors(
    config: TrainingConfig, modules: nn.Module, segmenter: Segmenter, frames: FrameSet
) -> dict[str, float]:
    """Return, by network, the largest difference of logits from torch's on four frames."""
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


def _write(config: TrainingConfig, weights: Weights, form: Format, out: Path) -> None:
    """Write networks and a card."""
    modalities = [modality for modality in Modality if modality.key in config.modalities]
    networks = {modality: Network(config.layers(modality.key), weights) for modality in modalities}
    card = {
        "name": config.name,
        "description": config.shape.description + _DESCRIPTION,
        "architecture": config.shape.name,
    }
    export(out, networks, form, card)


_DESCRIPTION = (
    " Trained on rendered towns. The networks take raw frames: colours are normalised with "
    "ImageNet's mean and standard deviation; depth enters as log(depth / 50 m) and as its difference to its "
    "mean over blocks of 16 and 8 pixels, cut at 10 m and 2 m."
)


def _held_out_results(model: Model, sets: FrameSets, measured: _Measure) -> dict[str, object]:
    """Return the IoU of every network on the held-out towns, and by class on the test town."""
    held_out = {
        name: measured(f"Measuring on the {name} town", model, frames)
        for name, frames in (("validation", sets.validation), ("test", sets.test))
    }
    classes: dict[str, dict[str, float]] = {}
    by_class = held_out["test"].by_class()
    for modality, ious in zip(sorted(model.card.networks), by_class, strict=True):
        for index in np.flatnonzero(~np.isnan(ious)):
            classes.setdefault(CLASSES[index], {})[modality.key] = round(float(ious[index]), 4)
    return {
        "iou_per_image": {f"{name} town": _iou_per_image(model, part) for name, part in held_out.items()},
        "iou_per_class_on_the_test_town": classes,
    }


def _facts(
    config: TrainingConfig, sets: FrameSets, work: Path, device: str, start: Start | None
) -> dict[str, object]:
    """Return the card's `training`, from the logs of the stages."""
    logs = _logs(config, work)
    origin = None if start is None else start.origin
    return {
        "data": (
            "rendered towns 2 to 6; town 7 for temperatures and thresholds, town 8 for the test; the default "
            "flight's town, 1, was never seen. Colour frames mirrored, enlarged up to 1.3 times and up to 10 % "
            "brighter or darker; nothing that resembles a fault"
        ),
        "frames": {field.name: {"frames": len(getattr(sets, field.name))} for field in fields(sets)},
        "seed": config.seed,
        "device": find_torch_device(device).type,
        "network": asdict(config.shape),
        "stages": {stage.name: _stage_facts(stage, logs[stage.name], origin) for stage in config.stages()},
        "loss": (
            "cross entropy at every second row and column, classes weighted by 1/sqrt(share of pixels) within "
            "class_weight_range; the sum over the networks learned at once, and for the fusion the same on "
            "misaligned pairs; AdamW, bfloat16"
        ),
        "logit_adjustment": config.logit_adjustment,
        "left_out": (
            "one run with one seed; no search over architectures, no frames of other renderers or "
            "cameras; classes of a few pixels (riders, motorcycles, bicycles) are hardly learned"
        ),
        **({"before": dict(start.training)} if start is not None else {}),
    }


def _stage_facts(stage: Stage, log: Path, origin: str | None) -> Mapping[str, object]:
    lines: list[dict[str, Any]] = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]
    tenth = max(1, len(lines) // 10)
    begun = origin or stage.begun_with or "random weights"
    return {
        "learned": list(stage.learned),
        "started_from": f"{' and '.join(stage.frozen)}, frozen" if stage.frozen else begun,
        "schedule": asdict(stage.schedule) | {"steps": stage.schedule.steps},
        "hours": round(lines[-1]["seconds"] / 3600, 2),
        "losses": {
            f"step {line['step']}": {name: line[name] for name in stage.learned}
            for line in lines[tenth - 1 :: tenth]
        },
        "iou_on_validation_frames": {f"step {line['step']}": line["iou"] for line in lines if "iou" in line},
    }
