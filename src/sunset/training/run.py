"""A training run, from nothing to a model's folder with its card."""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sunset.classes import CLASSES
from sunset.errors import MissingExtraError, OutputError
from sunset.perception import Modality, Model, ModelCard, NetworkCard, Segmenter, load_model
from sunset.training.architecture import convolutions
from sunset.training.batches import FrameSet
from sunset.training.calibrate import temperature_for
from sunset.training.config import TrainingConfig
from sunset.training.frames import FrameCounts, FrameSets, render_sets
from sunset.training.inputs import HEIGHT, WIDTH
from sunset.training.report import results, thresholds, training_facts

if TYPE_CHECKING:
    from sunset.training.loop import Progress
    from sunset.training.network import Weights

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
    from sunset.training.network import folded_weights  # noqa: PLC0415

    try:
        modules = learn(config, sets.train, sets.validation, work, resume=resume, progress=progress)
        weights = folded_weights(config.plan(config.modalities), modules)
        out.mkdir(parents=True, exist_ok=True)
        temperatures = _calibrate(config, weights, sets.validation_flight, out)
        card = _export(config, weights, out, temperatures)
        segmenter = Segmenter(load_model(out))
        limits = thresholds(segmenter, sets.validation_flight)
        card = replace(
            card,
            entropy_threshold=limits.entropy.threshold,
            sharpness_threshold=limits.sharpness.threshold,
            training=training_facts(config, sets, work),
            results=results(segmenter, sets, limits),
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


def _export(
    config: TrainingConfig, weights: "Weights", out: Path, temperatures: Mapping[Modality, float]
) -> ModelCard:
    """Write the networks and a card that does not know its thresholds yet."""
    from sunset.training.onnx_graph import export  # noqa: PLC0415  onnx is an optional dependency

    networks = {}
    for modality in _modalities(config):
        layers, path = config.layers(modality.key), out / f"{modality.key}.onnx"
        inputs = config.branches if modality is Modality.FUSION else (modality.key,)
        temperature = temperatures[modality]
        export(path, layers, weights, inputs=inputs, temperature=temperature)
        parameters = sum(
            weights[layer.name][0].size + weights[layer.name][1].size for layer in convolutions(layers)
        )
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
        networks[modality] = NetworkCard(path.name, digest, parameters, temperature)
    digests = "".join(network.sha256 for network in networks.values())
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
    )
    card.write(out)
    return card


_DESCRIPTION = (
    " Trained from scratch on rendered towns. The networks take raw frames: colours are normalised with "
    "ImageNet's mean and standard deviation; depth enters as log(depth / 50 m) and as its difference to its "
    "mean over blocks of 16 and 8 pixels, cut at 10 m and 2 m."
)


def _calibrate(
    config: TrainingConfig, weights: "Weights", frames: FrameSet, out: Path
) -> dict[Modality, float]:
    """Return the temperatures that give every network the nominal entropy that the main one has untempered."""
    modalities = _modalities(config)
    plain = dict.fromkeys(modalities, 1.0)
    _export(config, weights, out, plain)
    segmenter = Segmenter(load_model(out))
    chosen = np.linspace(0, len(frames) - 1, min(_CALIBRATION_FRAMES, len(frames))).astype(int)
    pairs = [(np.asarray(frames.bgr[i]), np.asarray(frames.depth[i])) for i in chosen]
    target = float(np.mean([segmenter.segment(modalities[0], *pair).entropy for pair in pairs]))
    return {
        modality: 1.0
        if modality is modalities[0]
        else temperature_for([segmenter.logits(modality, *pair) for pair in pairs], target)
        for modality in modalities
    }
