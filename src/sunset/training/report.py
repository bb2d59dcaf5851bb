"""What a training run writes on the model's card about itself."""

import json
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sunset.classes import CLASSES
from sunset.perception import Modality
from sunset.training.config import Stage, TrainingConfig
from sunset.training.evaluate import Measured
from sunset.training.frames import FrameSets

if TYPE_CHECKING:
    from sunset.training.loop import Start


def held_out_results(held_out: Mapping[str, Mapping[Modality, Measured]]) -> dict[str, object]:
    """Return the IoU of every network on random views of held-out towns, and by class on the one for the test.

    `held_out` is by town, "validation" and "test", and network.
    """
    classes: dict[str, dict[str, float]] = {}
    for modality, measured in held_out["test"].items():
        for index, iou in measured.class_iou().items():
            classes.setdefault(CLASSES[index], {})[modality.key] = round(iou, 4)
    return {
        "iou_per_image": {
            f"{name} town": {m.key: round(float(r.iou.mean()), 4) for m, r in measured.items()}
            for name, measured in held_out.items()
        },
        "iou_per_class_on_the_test_town": classes,
    }


def training_facts(
    config: TrainingConfig, sets: FrameSets, logs: dict[str, Path], device: str, start: "Start | None" = None
) -> dict[str, object]:
    """Return how a model was trained, from the logs of its stages: the card's `training`.

    How the model was trained that it started from is told, too.
    """
    origin = None if start is None else start.origin
    lines = {
        name: [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]
        for name, log in logs.items()
    }
    return {
        "data": (
            "rendered towns 2 to 6; town 7 for temperatures and thresholds, town 8 for the test; the default "
            "flight's town, 1, was never seen. Colour frames mirrored, enlarged up to 1.3 times and up to 10 % "
            "brighter or darker; nothing that resembles a fault"
        ),
        "frames": {field.name: {"frames": len(getattr(sets, field.name))} for field in fields(sets)},
        "seed": config.seed,
        "device": device,
        "network": asdict(config.shape),
        "stages": {stage.name: _stage_facts(stage, lines[stage.name], origin) for stage in config.stages()},
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
        **({"remark": config.remark} if config.remark else {}),
        **({"before": dict(start.training)} if start is not None else {}),
    }


def _stage_facts(stage: Stage, lines: list[dict[str, Any]], origin: str | None) -> dict[str, object]:
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
