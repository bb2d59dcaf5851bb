"""What a training run measures, and what it writes on the model's card."""

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from itertools import combinations
from pathlib import Path
from typing import Any, Final, SupportsFloat

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASSES
from sunset.faults import EXCLUSIVE, FAULTS, blur, degrade_image, enhance_image, sharpness
from sunset.faults.degradations import BLUR_SIGMA
from sunset.perception import Modality, Segmenter
from sunset.training.batches import FrameSet
from sunset.training.calibrate import Separation, separate
from sunset.training.config import Stage, TrainingConfig
from sunset.training.evaluate import DEGRADATIONS, Degradation, five_frame_means, measure, roc_auc
from sunset.training.frames import FrameSets

__all__ = ["Thresholds", "results", "thresholds", "training_facts"]

_UNSURE: Final = ("image_degradation", "unneeded_enhancement", "image_shift", "depth_degradation")
"""The F4 faults."""

_SEEN_BY: Final = {Modality.RGB: _UNSURE[:3], Modality.DEPTH: _UNSURE[3:], Modality.FUSION: _UNSURE}
_EVERY: Final = 4
"""Pairs of faults are measured on every so-manieth frame."""


@dataclass(frozen=True, slots=True)
class Thresholds:
    """The two thresholds of a model, with their errors on the frames that they were chosen on."""

    entropy: Separation
    sharpness: Separation


def _restore(bgr: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    strength = float(FAULTS["image_degradation"].value)
    return enhance_image(degrade_image(bgr, strength), strength)


def _restored(
    bgr: npt.NDArray[np.uint8], depth: npt.NDArray[np.uint16], _: np.random.Generator
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16]]:
    return _restore(bgr), depth


def _main(segmenter: Segmenter) -> Modality:
    return min(segmenter.model.card.networks)


def thresholds(segmenter: Segmenter, flight: FrameSet) -> Thresholds:
    """Return the thresholds that part healthy from faulty best, on 5-frame means.

    Healthy are, for entropy, the nominal frames with every network, and degraded ones enhanced again;
    faulty are the F4 faults at suite strength with the main network. For sharpness, healthy are nominal,
    darkened and enhanced frames; faulty are blurred ones. Sharpness is compared by its logarithm, since it
    spans decades.
    """
    main = _main(segmenter)

    def entropies(modality: Modality, *degradations: Degradation) -> npt.NDArray[np.float64]:
        return five_frame_means(measure(segmenter, modality, flight, degradations).entropy)

    healthy = [entropies(modality) for modality in segmenter.model.card.networks]
    if main.needs_rgb:
        healthy.append(entropies(main, _restored))
    faulty = [entropies(main, DEGRADATIONS[name]) for name in _SEEN_BY[main]]
    strength = float(FAULTS["image_degradation"].value)
    sharp = [
        _sharpness(flight, change)
        for change in (lambda bgr: bgr, lambda bgr: degrade_image(bgr, strength), _restore)
    ]
    blurred = [_sharpness(flight, lambda bgr: blur(bgr, BLUR_SIGMA))]
    logs = separate([np.log(values) for values in blurred], [np.log(values) for values in sharp])
    # The faulty ones are the low ones here.
    parted = Separation(float(np.exp(logs.threshold)), logs.misses, logs.false_alarms)
    return Thresholds(separate(healthy, faulty), parted)


def _sharpness(
    frames: FrameSet, change: Callable[[npt.NDArray[np.uint8]], npt.NDArray[np.uint8]]
) -> npt.NDArray[np.float64]:
    values = [max(sharpness(change(np.asarray(bgr))), 1e-6) for bgr in frames.bgr]
    return five_frame_means(np.array(values))


def results(segmenter: Segmenter, sets: FrameSets, limits: Thresholds) -> dict[str, object]:
    """Return the measurements of a model: the card's `results`."""
    modalities = list(segmenter.model.card.networks)
    held_out = {
        name: {modality: measure(segmenter, modality, frames) for modality in modalities}
        for name, frames in (("validation", sets.validation), ("test", sets.test))
    }
    classes: dict[str, dict[str, float]] = {}
    for modality, measured in held_out["test"].items():
        for index, iou in measured.class_iou().items():
            classes.setdefault(CLASSES[index], {})[modality.key] = round(iou, 4)
    threshold = limits.entropy.threshold
    return {
        "iou_per_image": {
            f"{name} town": {m.key: round(float(r.iou.mean()), 4) for m, r in measured.items()}
            for name, measured in held_out.items()
        },
        "iou_per_class_on_the_test_town": classes,
        "faults_on_flights_over_the_validation_town": _faults(segmenter, sets.validation_flight, threshold),
        "faults_on_flights_over_the_test_town": _faults(segmenter, sets.test_flight, threshold),
        "pairs_of_faults_on_flights_over_the_test_town": _pairs(segmenter, sets.test_flight),
        "thresholds": {
            "entropy": _rounded(asdict(limits.entropy)),
            "sharpness": _rounded(asdict(limits.sharpness)),
        },
    }


def _faults(segmenter: Segmenter, flight: FrameSet, threshold: float) -> dict[str, dict[str, object]]:
    """Measure every network without fault, and the main one with each fault; entropies are 5-frame means."""
    main = _main(segmenter)
    nominal = five_frame_means(measure(segmenter, main, flight).entropy)
    cases: list[tuple[str, Modality, tuple[Degradation, ...], object]] = [
        (f"nominal, {modality.key}", modality, (), "") for modality in segmenter.model.card.networks
    ]
    cases += [(name, main, (degradation,), _strength(name)) for name, degradation in DEGRADATIONS.items()]
    cases.append(("image_degradation, enhanced again", main, (_restored,), _strength("image_degradation")))
    rows: dict[str, dict[str, object]] = {}
    for name, modality, degradations, strength in cases:
        measured = measure(segmenter, modality, flight, degradations)
        entropy = five_frame_means(measured.entropy)
        rows[name] = {"strength": strength} | _rounded(
            {
                "iou": measured.iou.mean(),
                "entropy": entropy.mean(),
                "deviation": entropy.std(),
                "auc_against_nominal": roc_auc(nominal, entropy),
                "over_threshold": (entropy > threshold).mean(),
            }
        )
    return rows


def _strength(fault: str) -> object:
    """Return what a fault's strength is on the card: that of the enhancement is the degradation's."""
    if fault == "autofocus_needed":
        return BLUR_SIGMA
    return FAULTS["image_degradation" if fault == "unneeded_enhancement" else fault].value


def _pairs(segmenter: Segmenter, flight: FrameSet) -> dict[str, dict[str, object]]:
    main = _main(segmenter)
    few = FrameSet(flight.bgr[::_EVERY], flight.depth[::_EVERY], flight.labels[::_EVERY])
    rows: dict[str, dict[str, object]] = {}
    for pair in _possible_pairs(DEGRADATIONS):
        measured = measure(segmenter, main, few, tuple(DEGRADATIONS[name] for name in pair))
        rows[" + ".join(pair)] = _rounded({"iou": measured.iou.mean(), "entropy": measured.entropy.mean()})
    mean = np.mean([float(str(row["iou"])) for row in rows.values()])
    rows["all pairs"] = _rounded({"iou": mean})
    rows["nominal"] = _rounded({"iou": measure(segmenter, main, few).iou.mean()})
    return rows


def _possible_pairs(names: Iterable[str]) -> list[tuple[str, str]]:
    return [pair for pair in combinations(names, 2) if pair not in EXCLUSIVE and pair[::-1] not in EXCLUSIVE]


def _rounded(values: Mapping[str, SupportsFloat]) -> dict[str, object]:
    return {name: round(float(value), 4) for name, value in values.items()}


def training_facts(config: TrainingConfig, sets: FrameSets, work: Path) -> dict[str, object]:
    """Return how a model was trained: the card's `training`."""
    from sunset.training.loop import LOG  # noqa: PLC0415  torch is an optional dependency

    stages = config.stages()
    logs = {
        stage.name: [json.loads(line) for line in (work / stage.name / LOG).read_text("utf-8").splitlines()]
        for stage in stages
    }
    return {
        "data": (
            "rendered towns 2 to 6; town 7 for temperatures and thresholds, town 8 for the test; the default "
            "flight's town, 1, was never seen. Colour frames mirrored, enlarged up to 1.3 times and up to 10 % "
            "brighter or darker; nothing that resembles a fault"
        ),
        "frames": {
            name: {"frames": len(getattr(sets, name))}
            for name in ("train", "validation", "validation_flight", "test", "test_flight")
        },
        "seed": config.seed,
        "network": asdict(config.shape),
        "stages": {stage.name: _stage_facts(stage, logs[stage.name]) for stage in stages},
        "loss": (
            "cross entropy at every second row and column, classes weighted by 1/sqrt(share of pixels) within "
            "class_weight_range; the sum over the networks learned at once; AdamW, bfloat16"
        ),
        "left_out": (
            "one run with one seed; no search over architectures, no frames of other renderers or "
            "cameras; classes of a few pixels (riders, motorcycles, bicycles) are hardly learned"
        ),
    }


def _stage_facts(stage: Stage, lines: list[dict[str, Any]]) -> dict[str, object]:
    tenth = max(1, len(lines) // 10)
    return {
        "learned": list(stage.learned),
        "started_from": f"{' and '.join(stage.frozen)}, frozen" if stage.frozen else "random weights",
        "schedule": asdict(stage.schedule) | {"steps": stage.schedule.steps},
        "hours": round(lines[-1]["seconds"] / 3600, 2),
        "losses": {
            f"step {line['step']}": {name: line[name] for name in stage.learned}
            for line in lines[tenth - 1 :: tenth]
        },
        "iou_on_validation_frames": {f"step {line['step']}": line["iou"] for line in lines if "iou" in line},
    }
