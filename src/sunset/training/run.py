"""A training run, from nothing to a model's folder with its card."""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from sunset.classes import CLASSES
from sunset.errors import MissingExtraError, OutputError
from sunset.perception import Modality, Model, ModelCard, Segmenter, load_model
from sunset.training.batches import FrameSet
from sunset.training.calibrate import temperature_for
from sunset.training.config import TrainingConfig
from sunset.training.evaluate import measure
from sunset.training.frames import FrameCounts, FrameSets, render_sets
from sunset.training.inputs import HEIGHT, WIDTH
from sunset.training.report import results, thresholds, training_facts

if TYPE_CHECKING:
    from sunset.training.loop import Progress
    from sunset.training.onnx_graph import Format, Weights

__all__ = ["train", "train_on"]

_CALIBRATION_FRAMES = 60


def train(
    config: TrainingConfig,
    out: Path,
    *,
    work: Path,
    counts: FrameCounts | None = None,
    resume: bool = False,
    jobs: int = 2,
    progress: "Progress | None" = None,
) -> Model:
    """Render frames, learn weights, calibrate, measure, and write a model.

    Args:
        config: what to train.
        out: the model's folder: networks, `card.json`, `card.md`.
        work: keeps frames, checkpoints and the log; what is there already is used again.
        counts: how many frames to render.
        resume: go on at the last checkpoint in `work`, if there is one.
        jobs: processes that render.
        progress: called now and then.

    Raises:
        MissingExtraError: torch or onnx is not installed.
        OutputError: a folder cannot be written.
        InvalidInputError: the checkpoint to resume at is another training's.
    """
    _check_extra()
    counts = counts or FrameCounts()
    sets = render_sets(counts, work / "frames", jobs=jobs, progress=progress)
    return train_on(config, sets, out, work=work, resume=resume, progress=progress)


def train_on(
    config: TrainingConfig,
    sets: FrameSets,
    out: Path,
    *,
    work: Path,
    resume: bool = False,
    progress: "Progress | None" = None,
) -> Model:
    """Do what `train` does with frames that are there already.

    Raises:
        MissingExtraError: torch or onnx is not installed.
        OutputError: a folder cannot be written.
        InvalidInputError: the checkpoint to resume at is another training's.
    """
    _check_extra()
    from sunset.training.loop import learn  # noqa: PLC0415  torch is an optional dependency

    try:
        modules = learn(config, sets.train, sets.validation, work, resume=resume, progress=progress)
        card = _export(config, modules, sets, out, work)
        segmenter = Segmenter(load_model(out))
        limits = thresholds(segmenter, sets.validation_flight)
        card = replace(
            card,
            entropy_threshold=limits.entropy.threshold,
            sharpness_threshold=limits.sharpness.threshold,
            training=training_facts(config, sets, work),
            results={**results(segmenter, sets, limits), **card.results},
        )
        card.write(out)
    except OSError as error:
        raise OutputError(f"The training cannot write to {out} or {work}: {error.strerror}.") from error
    return load_model(out)


def _check_extra() -> None:
    missing = [name for name in ("torch", "onnx") if find_spec(name) is None]
    if missing:
        raise MissingExtraError(
            f"Training needs {' and '.join(missing)}, not installed: pip install 'sunset-exemplar[train]'."
        )


def _modalities(config: TrainingConfig) -> list[Modality]:
    return [modality for modality in Modality if modality.key in config.modalities]


def _export(config: TrainingConfig, modules: Any, sets: FrameSets, out: Path, work: Path) -> ModelCard:
    """Write the networks and a card that does not know its thresholds yet.

    Networks in 8 bits are also written in float32, for a while, and compared.
    """
    from sunset.training.network import folded_weights  # noqa: PLC0415  torch is an optional dependency
    from sunset.training.onnx_graph import Format  # noqa: PLC0415  onnx is one, too
    from sunset.training.quantise import ranges  # noqa: PLC0415

    weights = folded_weights(config.plan(config.modalities), modules)
    if not config.eight_bits:
        return _tempered(config, weights, Format(dtype=np.float16), sets.validation_flight, out)
    limits = ranges(config.plan(config.branches), modules, sets.train)
    card = _tempered(config, weights, Format(ranges=limits), sets.validation_flight, out)
    with TemporaryDirectory(dir=work) as exact:
        _write(config, weights, Format(), Path(exact))
        pair = {"float32": Segmenter(load_model(exact)), "int8": Segmenter(load_model(out))}
        iou = {
            modality.key: {
                name: round(float(measure(segmenter, modality, sets.validation).iou.mean()), 4)
                for name, segmenter in pair.items()
            }
            for modality in card.networks
        }
    return replace(card, results={"iou_by_precision_on_the_validation_town": iou})


def _tempered(
    config: TrainingConfig, weights: "Weights", form: "Format", frames: FrameSet, out: Path
) -> ModelCard:
    """Write networks that all have the nominal entropy that the main one has untempered."""
    modalities = list(_write(config, weights, form, out).networks)
    segmenter = Segmenter(load_model(out))
    chosen = np.linspace(0, len(frames) - 1, min(_CALIBRATION_FRAMES, len(frames))).astype(int)
    pairs = [(np.asarray(frames.bgr[i]), np.asarray(frames.depth[i])) for i in chosen]
    target = float(np.mean([segmenter.segment(modalities[0], *pair).entropy for pair in pairs]))
    temperatures = {
        modality: temperature_for([segmenter.logits(modality, *pair) for pair in pairs], target)
        for modality in modalities[1:]
    }
    return _write(config, weights, form, out, temperatures)


def _write(
    config: TrainingConfig,
    weights: "Weights",
    form: "Format",
    out: Path,
    temperatures: Mapping[Modality, float] | None = None,
) -> ModelCard:
    """Write networks, with temperature 1 where none is given, and a card without results."""
    from sunset.training.onnx_graph import export  # noqa: PLC0415  onnx is an optional dependency

    plans = {
        modality: config.layers(modality.key) for modality in Modality if modality.key in config.modalities
    }
    networks = export(out, plans, weights, {**dict.fromkeys(plans, 1.0), **(temperatures or {})}, form)
    digests = "".join(network.digest for network in networks.values())
    card = ModelCard(
        name=config.name,
        version=hashlib.sha256(digests.encode()).hexdigest()[:12],
        description=config.shape.description + _DESCRIPTION,
        height=HEIGHT,
        width=WIDTH,
        classes=CLASSES,
        entropy_threshold=1.0,
        sharpness_threshold=0.0,
        networks=networks,
        architecture=config.shape.name,
        precision=form.precision,
    )
    card.write(out)
    return card


_DESCRIPTION = (
    " Trained from scratch on rendered towns. The networks take raw frames: colours are normalised with "
    "ImageNet's mean and standard deviation; depth enters as log(depth / 50 m) and as its difference to its "
    "mean over blocks of 16 and 8 pixels, cut at 10 m and 2 m."
)
