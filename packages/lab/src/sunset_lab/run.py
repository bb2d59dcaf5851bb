"""A training: frames, weights, calibration, measurements, and the model's folder with its card."""

import json
import shutil
from collections.abc import Callable
from dataclasses import asdict, fields, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from sunset.classes import CLASSES
from sunset.errors import InvalidInputError, MissingExtraError, OutputError
from sunset.perception import DEVICES, Modality, Model, load_model
from sunset_lab.architecture import Layer
from sunset_lab.augment import DeviceFrames, class_weights
from sunset_lab.calibrate import calibrate, publish
from sunset_lab.config import Stage, TrainingConfig
from sunset_lab.frames import (
    DEFAULT_FRAMES,
    FURTHER_FRAMES,
    VALIDATION_TOWN,
    FrameSet,
    FrameSets,
    render_sets,
    titled,
)
from sunset_lab.measuring import LookOptions, Measured, measure
from sunset_lab.network import build, folded_weights, frame_inputs, ranges, shift_logits, unfold
from sunset_lab.onnx_graph import Format, Network, export
from sunset_lab.onnx_layers import stored_weights
from sunset_lab.stage import CHECKPOINT, LOG, Material, StageRun, Training, Weights

_FINISH: Final = "finish"
"""The folder in which a model is finished when its weights are learned."""

_Measure = Callable[[str, Model, FrameSet], Measured]


def train(training: Training, out: Path, frames: int | None = None) -> Model:
    """Render about so many training frames, learn weights, calibrate, measure, and write a model.

    Frames, checkpoints and logs are used again. `out` receives the networks, `card.json` and `card.md`.
    """
    if training.start is not None:
        stored_weights(training.start, training.config)  # mistakes are reported before hours of work
    find_torch_device(training.device)
    for folder in (out, training.work):  # without making them
        parent = next(path for path in (folder, *folder.absolute().parents) if path.exists())
        try:
            TemporaryDirectory(dir=parent).cleanup()
        except OSError as error:
            raise OutputError(f"The training cannot write to {folder}: {error.strerror}.") from error
    _check_work(training)
    further, folder = training.start is not None, training.work / "frames"
    count = frames or (FURTHER_FRAMES if further else DEFAULT_FRAMES)
    sets = render_sets(count, folder, further=further, jobs=training.jobs, progress=training.progress)
    return train_on(training, sets, out)


def train_on(training: Training, sets: FrameSets, out: Path) -> Model:
    """Train on given frames; see `train`."""
    try:
        publish(_finished(training, learn(training, sets.train, sets.validation), sets), out)
        shutil.rmtree(training.work / _FINISH)
    except OSError as error:
        raise OutputError(
            f"The training cannot write to {out} or {training.work}: {error.strerror or error}."
        ) from error
    return load_model(out)


def learn(training: Training, frames: FrameSet, validation: FrameSet) -> nn.Module:
    """Learn the weights of all networks of a model, and return them in a torch module on the CPU.

    `validation` are the frames of the log's IoU. Finished stages are not repeated.
    """
    _check_work(training)
    config, device = training.config, find_torch_device(training.device)
    labels = np.asarray(frames.labels[:: max(1, len(frames) // 500)])
    log_weights = np.log(class_weights(labels, config.schedule.class_weight_range))
    material = Material(
        frames=DeviceFrames(frames, device),
        digest=frames.digest(),
        labels=labels,
        validation=DeviceFrames(validation.spread_out(48), device),
        begun=_begun(config, training.start, frames.spread_out(12), log_weights) if training.start else {},
        device=device,
    )
    weights: dict[str, Tensor] = {}
    for stage in config.stages():
        weights |= StageRun(training, material, stage, weights).fit()
    modules = build(config.plan(config.modalities))
    modules.load_state_dict(weights)
    shift_logits(_networks(config), modules, np.float32(-config.logit_adjustment) * log_weights)
    return modules.eval()


def _check_work(training: Training) -> None:
    """Refuse to begin a training in a folder with a checkpoint, unless it is resumed."""
    folders = [training.work / stage.name for stage in training.config.stages()]
    if not training.resume and any((folder / CHECKPOINT).exists() for folder in folders):
        raise InvalidInputError(
            f"The work folder {training.work} holds a training already: go on with it (--resume), or name another "
            "folder."
        )


def find_torch_device(wanted: str) -> torch.device:
    """Return torch's device for "cpu", "cuda" or "auto"."""
    if wanted not in DEVICES:
        raise InvalidInputError(f"The device must be one of {', '.join(DEVICES)}, got {wanted!r}.")
    offered = torch.cuda.is_available()
    if wanted == "cuda" and not offered:
        raise MissingExtraError(
            f"Training with CUDA needs a graphics card and a torch that is made for it, and torch {torch.__version__} "
            "finds none: install another torch, or choose the device cpu."
        )
    return torch.device("cuda" if wanted != "cpu" and offered else "cpu")


def _networks(config: TrainingConfig) -> dict[str, tuple[Layer, ...]]:
    """Return the plan of each network; for the fusion, of its merging layers only."""
    return {name: config.plan((name,)) for name in config.modalities}


def _begun(
    config: TrainingConfig, start: Model, few: FrameSet, log_weights: npt.NDArray[np.float32]
) -> Weights:
    """Return the weights that a training begins with; normalisation is estimated on a few frames.

    The logit adjustment of the training before is undone.
    """
    stored = stored_weights(start, config)
    modules = build(config.plan(config.modalities)).eval()
    logits: dict[str, Tensor] = {}
    for name, layers in _networks(config).items():
        results = frame_inputs(few.bgr, few.depth) | logits
        unfold(layers, modules, stored, results)
        logits[f"{name}.logits"] = results[f"{name}.logits"]
    share = start.card.training.get("logit_adjustment")
    adjustment = float(share) if isinstance(share, int | float) else 0.0
    shift_logits(_networks(config), modules, np.float32(adjustment) * log_weights)
    weights: Weights = modules.state_dict()
    return weights


def _finished(training: Training, modules: nn.Module, sets: FrameSets) -> Path:
    """Return the folder of the exported, calibrated and measured model."""
    home, progress = training.work / _FINISH, training.progress
    draft = home / "draft"
    options: LookOptions = {"jobs": training.jobs, "kept": home / "kept"}

    def measured(title: str, model: Model, frames: FrameSet) -> Measured:
        noted: LookOptions = {**options, "progress": titled(progress, title)}
        return measure(model, frames, **noted)

    results = _export(training.config, modules, sets, draft, measured)
    source = f"two flights over town {VALIDATION_TOWN}"
    model = calibrate(load_model(draft), sets.validation_flight, source, progress, **options)
    results |= _held_out_results(model, sets, measured)
    facts = _facts(training, sets)
    replace(model.card, training=facts, results={**results, **model.card.results}).write(draft)
    return draft


def _export(
    config: TrainingConfig, modules: nn.Module, sets: FrameSets, draft: Path, measured: _Measure
) -> dict[str, object]:
    """Write the networks in 8 bits, and a card without temperatures and thresholds.

    Returns:
        The IoU in 8 bits and in float32, in which the networks are written before.
    """
    weights = folded_weights(config.plan(config.modalities), modules)
    limits = ranges(config.plan(config.branches), modules, sets.train)
    networks = {
        modality: Network(config.layers(modality.key), weights)
        for modality in Modality
        if modality.key in config.modalities
    }
    card = {
        "name": config.name,
        "description": config.shape.description + _DESCRIPTION,
        "architecture": config.shape.name,
    }
    ious: dict[str, dict[str, float]] = {modality.key: {} for modality in networks}
    for precision, form in (("float32", Format()), ("int8", Format(ranges=limits))):
        shutil.rmtree(draft, ignore_errors=True)
        export(draft, networks, form, card)
        model = load_model(draft)
        found = _iou_per_image(model, measured(f"Measuring {precision}", model, sets.validation))
        for key, iou in found.items():
            ious[key][precision] = iou
    return {"iou_by_precision_on_the_validation_town": ious}


def _iou_per_image(model: Model, measured: Measured) -> dict[str, float]:
    keys = [modality.key for modality in sorted(model.card.networks)]
    return {key: round(float(iou), 4) for key, iou in zip(keys, measured.per_image(), strict=True)}


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


def _facts(training: Training, sets: FrameSets) -> dict[str, object]:
    """Return the card's `training`, from the logs of the stages."""
    config, start = training.config, training.start
    return {
        "data": (
            "rendered towns 2 to 6; town 7 for temperatures and thresholds, town 8 for the test; the default "
            "flight's town, 1, was never seen. Colour frames mirrored, enlarged up to 1.3 times and up to 10 % "
            "brighter or darker; nothing that resembles a fault"
        ),
        "frames": {field.name: {"frames": len(getattr(sets, field.name))} for field in fields(sets)},
        "seed": config.seed,
        "device": find_torch_device(training.device).type,
        "network": asdict(config.shape),
        "stages": {stage.name: _stage_facts(training, stage) for stage in config.stages()},
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
        **({"before": dict(start.card.training)} if start is not None else {}),
    }


def _stage_facts(training: Training, stage: Stage) -> dict[str, object]:
    text = (training.work / stage.name / LOG).read_text(encoding="utf-8")
    lines = [json.loads(line) for line in text.splitlines()]
    tenth = max(1, len(lines) // 10)
    begun = training.origin or stage.begun_with or "random weights"
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
