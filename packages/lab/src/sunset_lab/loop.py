"""Learning the weights of all networks of a model, stage by stage."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn

from sunset.errors import InvalidInputError, MissingExtraError
from sunset.perception import DEVICES
from sunset_lab.architecture import Layer
from sunset_lab.augment import DeviceFrames
from sunset_lab.batches import FrameSet, class_weights
from sunset_lab.config import Schedule, TrainingConfig
from sunset_lab.network import build, frame_inputs, shift_logits, unfold
from sunset_lab.onnx_layers import Weights as FoldedWeights
from sunset_lab.stage import CHECKPOINT, Progress, StageRun, Training, Weights


@dataclass(frozen=True, slots=True)
class Start:
    """The model that a training starts from: its name and version, its weights, and its card's `training`."""

    origin: str
    weights: FoldedWeights
    training: Mapping[str, object]

    @property
    def logit_adjustment(self) -> float:
        """The adjustment of these weights' training, which is undone before they are trained further."""
        share = self.training.get("logit_adjustment")
        return float(share) if isinstance(share, int | float) else 0.0


def learn(
    config: TrainingConfig,
    frames: FrameSet,
    validation: FrameSet,
    work: Path,
    *,
    start: Start | None = None,
    resume: bool = False,
    device: str = "cpu",
    compiled: bool = False,
    progress: Progress | None = None,
) -> nn.Module:
    """Learn the weights of all networks of a model, and return them in a torch module on the CPU.

    `validation` are the frames of the log's IoU. Every stage has a folder in `work`; finished stages are not repeated.
    The other arguments are as in `train`.
    """
    check_work(config, work, resume=resume)
    networks = {name: config.plan((name,)) for name in config.modalities}
    log_weights = np.log(_class_weights(frames, config.schedule))
    place = find_torch_device(device)
    training = Training(
        config=config,
        frames=DeviceFrames(frames, place),
        digest=frames.digest(),
        validation=DeviceFrames(validation, place),
        class_weights={stage.name: _class_weights(frames, stage.schedule) for stage in config.stages()},
        begun={} if start is None else _begun(networks, start, frames, log_weights),
        origin=start.origin if start else "",
        device=place,
        compiled=compiled,
    )
    weights: dict[str, Tensor] = {}
    for stage in config.stages():
        weights |= StageRun(training, stage, work / stage.name, weights).fit(resume=resume, progress=progress)
    modules = build(config.plan(config.modalities))
    modules.load_state_dict(weights)
    shift_logits(networks, modules, np.float32(-config.logit_adjustment) * log_weights)
    return modules.eval()


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


def _begun(
    networks: Mapping[str, Sequence[Layer]],
    start: Start,
    frames: FrameSet,
    log_weights: npt.NDArray[np.float32],
) -> Weights:
    """Return the weights that a training begins with, whose normalisation is estimated on 12 frames."""
    chosen = np.linspace(0, len(frames) - 1, min(12, len(frames))).astype(int)
    modules = build([layer for layers in networks.values() for layer in layers]).eval()
    logits: dict[str, Tensor] = {}
    for name, layers in networks.items():
        results = frame_inputs(frames.bgr[chosen], frames.depth[chosen]) | logits
        unfold(layers, modules, start.weights, results)
        logits[f"{name}.logits"] = results[f"{name}.logits"]
    shift_logits(networks, modules, np.float32(start.logit_adjustment) * log_weights)
    weights: Weights = modules.state_dict()
    return weights


def check_work(config: TrainingConfig, work: Path, *, resume: bool) -> None:
    """Refuse to begin a training in a folder with a checkpoint, unless `resume` is true."""
    if not resume and any((work / stage.name / CHECKPOINT).exists() for stage in config.stages()):
        raise InvalidInputError(
            f"The work folder {work} holds a training already: go on with it (--resume), or name another folder."
        )


def _class_weights(frames: FrameSet, schedule: Schedule) -> npt.NDArray[np.float32]:
    every = max(1, len(frames) // 500)
    return class_weights(np.asarray(frames.labels[::every]), schedule.class_weight_range)
