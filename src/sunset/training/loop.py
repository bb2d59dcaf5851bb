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
from sunset.training.architecture import Layer
from sunset.training.augment import DeviceFrames
from sunset.training.batches import FrameSet, class_weights
from sunset.training.config import Schedule, TrainingConfig
from sunset.training.network import build, frame_inputs, shift_logits, unfold
from sunset.training.onnx_layers import Weights as FoldedWeights
from sunset.training.stage import CHECKPOINT, Progress, StageRun, Training, Weights


@dataclass(frozen=True, slots=True)
class Start:
    """The model and version that a training starts from, its weights, and how they were learned, as its card tells."""

    origin: str
    weights: FoldedWeights
    training: Mapping[str, object]

    @property
    def logit_adjustment(self) -> float:
        """Of the training that learned the weights; it is taken back before they are learned further."""
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
    """Learn the weights of all networks of a model, stage by stage.

    Arguments are those of `train`. The IoU is measured on the `validation` frames. In `work` every stage has a folder
    with `checkpoint.pt` and `log.jsonl` (a line per `log_every` steps: step, learning rate, loss per network, seconds,
    and now and then the IoU); stages that are done are not repeated. `progress` is called after every step; what it
    raises is raised when a checkpoint is written.

    Returns:
        A torch module with the weights of all networks, their logits adjusted, in evaluation mode, on the CPU.

    Raises:
        InvalidInputError: a checkpoint to resume at is another training's or of other frames, or there is one without
            `resume`.
        DataError: it or its log cannot be used.
        OutputError: none can be written.
        MissingExtraError: torch cannot use the device.
        SunsetError: the training diverged.
    """
    check_work(config, work, resume=resume)
    place = find_torch_device(device)
    networks = {name: config.plan((name,)) for name in config.modalities}
    log_weights = np.log(_class_weights(frames, config.schedule))
    begun: Weights = {}
    if start is not None:
        started = _unfolded(networks, start.weights, frames)
        shift_logits(networks, started, np.float32(start.logit_adjustment) * log_weights)
        begun = started.state_dict()
    training = Training(
        config=config,
        frames=DeviceFrames(frames, place),
        digest=frames.digest(),
        validation=DeviceFrames(validation, place),
        class_weights={stage.name: _class_weights(frames, stage.schedule) for stage in config.stages()},
        begun=begun,
        origin=start.origin if start else "",
        device=place,
        compiled=compiled,
    )
    weights: dict[str, Tensor] = {}
    for stage in config.stages():
        run = StageRun(training, stage, work / stage.name, weights)
        run.fit(resume=resume, progress=progress)
        weights |= {name: value.cpu() for name, value in run.modules.state_dict().items()}
    modules = build(config.plan(config.modalities))
    modules.load_state_dict(weights)
    shift_logits(networks, modules, np.float32(-config.logit_adjustment) * log_weights)
    return modules.eval()


def find_torch_device(wanted: str) -> torch.device:
    """Return torch's device for what was asked for: "cpu", "cuda" or "auto".

    Raises:
        InvalidInputError: it is none of these.
        MissingExtraError: "cuda" is asked for, and torch cannot use it.
    """
    if wanted not in DEVICES:
        raise InvalidInputError(f"The device must be one of {', '.join(DEVICES)}, got {wanted!r}.")
    offered = torch.cuda.is_available()
    if wanted == "cuda" and not offered:
        raise MissingExtraError(
            f"Training with CUDA needs a graphics card and a torch that is made for it, and torch {torch.__version__} "
            "finds none: install another torch, or choose the device cpu."
        )
    return torch.device("cuda" if wanted != "cpu" and offered else "cpu")


def _unfolded(networks: Mapping[str, Sequence[Layer]], weights: FoldedWeights, frames: FrameSet) -> nn.Module:
    """Return torch modules with folded weights; what normalisation undoes is found on 12 frames."""
    chosen = np.linspace(0, len(frames) - 1, min(12, len(frames))).astype(int)
    modules = build([layer for layers in networks.values() for layer in layers]).eval()
    logits: dict[str, Tensor] = {}
    for name, layers in networks.items():
        results = frame_inputs(frames.bgr[chosen], frames.depth[chosen]) | logits
        unfold(layers, modules, weights, results)
        logits[f"{name}.logits"] = results[f"{name}.logits"]
    return modules


def check_work(config: TrainingConfig, work: Path, *, resume: bool) -> None:
    """Refuse to begin a training where there is one.

    Raises:
        InvalidInputError: the folder holds a checkpoint, and `resume` is not asked for.
    """
    if not resume and any((work / stage.name / CHECKPOINT).exists() for stage in config.stages()):
        raise InvalidInputError(
            f"The work folder {work} holds a training already: go on with it (--resume), or name another folder."
        )


def _class_weights(frames: FrameSet, schedule: Schedule) -> npt.NDArray[np.float32]:
    every = max(1, len(frames) // 500)
    return class_weights(np.asarray(frames.labels[::every]), schedule.class_weight_range)
