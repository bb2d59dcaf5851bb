"""The training loop: the networks of a stage at once, resumable, with a log that curves are drawn from."""

import hashlib
import json
import math
import pickle
import struct
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
import torch
from torch import nn
from torch.nn import functional

from sunset.classes import CLASSES, IGNORED
from sunset.errors import DataError, InvalidInputError, OutputError, SunsetError
from sunset.metrics import count_classes, image_iou
from sunset.seeding import generator
from sunset.training.architecture import Layer
from sunset.training.archives import check_archive
from sunset.training.batches import Batch, FrameSet, batches, class_weights
from sunset.training.config import Schedule, Stage, TrainingConfig
from sunset.training.inputs import HEIGHT, WIDTH
from sunset.training.network import (
    build,
    depth_input,
    forward,
    frame_inputs,
    rgb_input,
    shift_logits,
    unfold,
    upsample,
)
from sunset.training.onnx_layers import Weights as FoldedWeights

__all__ = ["CHECKPOINT", "LOG", "Progress", "Start", "Weights", "check_work", "learn", "start_from_the_sum"]

CHECKPOINT = "checkpoint.pt"
LOG = "log.jsonl"

Weights = Mapping[str, Any]
"""Tensors by name: a torch state dict."""

_UNREADABLE = (
    EOFError,
    KeyError,
    OSError,
    RuntimeError,
    TypeError,
    ValueError,
    pickle.UnpicklingError,
    struct.error,
)
"""What reading a damaged checkpoint raises."""
_UNFOLDED = 12
"""Training frames that normalisation's statistics are found on again."""
_VALIDATED = 48
"""Held-out frames that the log's IoU is measured on."""
_SHIFT_PX = ((2, 20), (0, 6))
"""How far the colour camera's picture is moved in a misaligned pair, least and most: across, down."""


@dataclass(frozen=True, slots=True)
class Start:
    """What a training starts from.

    Attributes:
        origin: says which model it is, and of which version.
        weights: of the training's convolutions.
        training: how they were learned, as the model's card tells.
    """

    origin: str
    weights: FoldedWeights
    training: Mapping[str, object]

    @property
    def logit_adjustment(self) -> float:
        """Of the training that learned the weights; it is taken back before they are learned further."""
        share = self.training.get("logit_adjustment")
        return float(share) if isinstance(share, int | float) else 0.0


class Progress(Protocol):
    """Called now and then while something is being done."""

    def __call__(self, what: str, done: int, total: int, note: str = "", /) -> None:
        """Take what is being done, how much of it is done, how much there is, and a remark."""


def learn(
    config: TrainingConfig,
    frames: FrameSet,
    validation: FrameSet,
    work: Path,
    *,
    start: Start | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Any:
    """Learn the weights of all networks of a model, stage by stage.

    Args:
        config: what to train.
        frames: the training frames.
        validation: held-out frames, which the log's IoU is measured on.
        work: a folder a stage is kept there, with `checkpoint.pt` and `log.jsonl` (a line per `log_every`
            steps: step, learning rate, loss per network, seconds, and now and then the IoU).
        start: what the networks begin with; None for random weights.
        resume: go on at the folders' checkpoints where there are some; stages that are done are not repeated.
        progress: called after every step.

    Returns:
        A torch module with the weights of all networks, their logits adjusted, in evaluation mode, on the CPU.

    Raises:
        InvalidInputError: a checkpoint to resume at is another training's or of other frames, or there is one without
            `resume`.
        DataError: it or its log cannot be used.
        OutputError: none can be written.
        SunsetError: the training diverged.
    """
    check_work(config, work, resume=resume)
    networks = {name: config.plan((name,)) for name in config.modalities}
    log_weights = np.log(_class_weights(frames, config.schedule))
    digest = _digest_of(frames)
    begun: Weights = {}
    if start is not None:
        started = _unfolded(networks, start.weights, frames)
        shift_logits(networks, started, np.float32(start.logit_adjustment) * log_weights)
        begun = started.state_dict()
    weights: dict[str, Any] = {}
    for stage in config.stages():
        origin = start.origin if start else ""
        run = _Run(config, stage, work / stage.name, digest, weights, begun, origin)
        run.fit(frames, validation, resume=resume, progress=progress)
        weights |= {name: value.cpu() for name, value in run.modules.state_dict().items()}
    modules = build(config.plan(config.modalities))
    modules.load_state_dict(weights)
    shift_logits(networks, modules, np.float32(-config.logit_adjustment) * log_weights)
    return modules.eval()


def _unfolded(networks: Mapping[str, Sequence[Layer]], weights: FoldedWeights, frames: FrameSet) -> Any:
    """Return torch modules with folded weights; what normalisation undoes is found on evenly chosen frames."""
    chosen = np.linspace(0, len(frames) - 1, min(_UNFOLDED, len(frames))).astype(int)
    modules = build([layer for layers in networks.values() for layer in layers]).eval()
    logits: dict[str, Any] = {}
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


class _Run:
    """A stage's modules, its optimiser, and how far it has come.

    Args:
        config: the training.
        stage: the stage.
        folder: keeps its checkpoint and log.
        frames: checksum of the training frames.
        known: the weights of the stages before.
        begun: those that the training starts from; empty for random ones.
        origin: says which they are.
    """

    def __init__(  # noqa: PLR0917
        self,
        config: TrainingConfig,
        stage: Stage,
        folder: Path,
        frames: str,
        known: Weights,
        begun: Weights,
        origin: str,
    ) -> None:
        torch.manual_seed(config.seed)
        self._config, self._stage, self._folder = config, stage, folder
        self._device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        self.modules = build(config.plan(stage.learned))
        own = self.modules.state_dict()
        if begun:
            self.modules.load_state_dict({name: begun[name] for name in own})
        elif stage.begun_with is not None:
            names = zip(own, build(config.plan((stage.begun_with,))).state_dict(), strict=True)
            self.modules.load_state_dict({name: known[other] for name, other in names})
        elif stage.frozen:
            start_from_the_sum(self.modules)
        self.modules.to(self._device)
        self._frozen = build(config.plan(stage.frozen)).to(self._device).eval()
        self._frozen.load_state_dict({name: known[name] for name in self._frozen.state_dict()})
        self._optimiser = torch.optim.AdamW(
            _parameters(self.modules, stage.schedule.weight_decay), fused=True
        )
        self._description = f"{stage!r}, {config.shape!r}, seed {config.seed}, frames {frames}"
        if known:
            self._description += f", on weights {_digest(known)}"
        if origin:
            self._description += f", from {origin}"
        self._step, self._seconds = 0, 0.0
        self._losses: list[dict[str, float]] = []
        self._kept: dict[int, dict[str, Any]] = {}

    def fit(self, frames: FrameSet, validation: FrameSet, *, resume: bool, progress: Progress | None) -> None:
        """Take all steps that are left."""
        self._folder.mkdir(parents=True, exist_ok=True)
        if resume and (self._folder / CHECKPOINT).exists():
            self._load()
        _truncate_log(self._folder / LOG, self._step, self._stage.learned)
        stage, schedule = self._stage, self._stage.schedule
        self._weights = torch.from_numpy(_class_weights(frames, schedule)).to(self._device)
        note = ""
        since = time.perf_counter()
        for batch in self._batches(frames):
            self._losses.append(self._learn(batch))
            last = self._step == schedule.steps
            if self._step % schedule.log_every == 0 or last:
                self._seconds += time.perf_counter() - since
                since = time.perf_counter()
                note = self._log(validation)
            if self._step % schedule.checkpoint_every == 0 or last:
                self._save()
            if progress is not None:
                progress(stage.name, self._step, schedule.steps, note)

    def _batches(self, frames: FrameSet) -> Iterator[Batch]:
        """Yield the batches of the steps that are left, phase by phase."""
        begin = 0
        for phase in self._stage.schedule.phases:
            end = begin + phase.steps
            numbers = map(self._number, range(max(begin, self._step), end))
            yield from batches(frames, phase.batch, self._config.seed, numbers)
            begin = end

    def _number(self, step: int) -> int:
        """Return the number of a step's batch."""
        distinct = self._stage.schedule.distinct
        return step if distinct is None else step % distinct

    def _learn(self, batch: Batch) -> dict[str, float]:
        """Take one step; returns the losses before it."""
        phase = self._stage.schedule.phase(self._step)
        self.modules.train()
        for module in self.modules.modules():
            if isinstance(module, nn.BatchNorm2d):
                module.momentum = phase.momentum
        for group in self._optimiser.param_groups:
            group["lr"] = self._stage.schedule.learning_rate_at(self._step)
        frozen = self._frozen_logits(batch)
        results = self._logits(batch.bgr, batch.depth, phase.output_stride, frozen)
        row, column = batch.phase
        labels = torch.from_numpy(np.ascontiguousarray(batch.labels[:, row::2, column::2])).to(self._device)
        losses = {}
        for name in self._stage.learned:
            logits = _full_size(results[f"{name}.logits"], batch.phase, 2)
            losses[name] = functional.cross_entropy(logits, labels, self._weights, ignore_index=IGNORED)
        if "fusion" in losses and self._stage.schedule.misaligned_weight:
            logits = _full_size(self._misaligned(results), batch.phase, 2)
            losses["misaligned"] = self._stage.schedule.misaligned_weight * functional.cross_entropy(
                logits,
                labels,
                self._weights,
                ignore_index=IGNORED,
                label_smoothing=self._stage.schedule.misaligned_smoothing,
            )
        self._optimiser.zero_grad()
        torch.stack(list(losses.values())).sum().backward()
        self._optimiser.step()
        self._step += 1
        found = {name: float(loss.detach()) for name, loss in losses.items()}
        if not all(map(math.isfinite, found.values())):
            raise SunsetError(
                f"The training of {self._stage.name} diverged at step {self._step}: its losses are {found}; what it "
                "had learned at its last checkpoint is kept."
            )
        return found

    def _frozen_logits(self, batch: Batch) -> dict[str, Any]:
        """Return the frozen branches' logits of the step's batch, and `moved`, those of its moved colour pictures.

        They are kept for when the batch comes again.
        """
        if not self._stage.frozen:
            return {}
        number = self._number(self._step)
        if number not in self._kept:
            seed = generator(self._config.seed, "training", "movement", number).integers(2**31)
            across, down = _movement(torch.Generator().manual_seed(int(seed)))
            moved = self._run_frozen(("rgb",), np.roll(batch.bgr, (down, across), (1, 2)), batch.depth)
            kept = self._run_frozen(self._stage.frozen, batch.bgr, batch.depth)
            kept["moved"] = moved["rgb.logits"]
            if self._stage.schedule.distinct is None:
                return kept
            self._kept[number] = kept
        return self._kept[number]

    def _run_frozen(
        self, names: tuple[str, ...], bgr: npt.NDArray[np.uint8], depth: npt.NDArray[np.generic]
    ) -> dict[str, Any]:
        """Return frozen branches' logits of frames."""
        results = self._inputs(names, bgr, depth)
        with torch.autocast(self._device.type, torch.bfloat16), torch.no_grad():
            forward(self._config.plan(names), self._frozen, results)
        return {f"{name}.logits": results[f"{name}.logits"] for name in names}

    def _misaligned(self, results: Mapping[str, Any]) -> Any:
        """Return the merged logits of a colour picture that is moved against the depth picture.

        Only the merging layers learn from it. Frozen branches have seen the moved picture; of others the
        logits are moved by whole cells, which is their picture's movement but for the borders.
        """
        moved = results.get("moved")
        if moved is None:
            stride = WIDTH // results["rgb.logits"].shape[3]
            across, down = _movement()
            cells = (_cells(down, stride), _cells(across, stride))
            moved = results["rgb.logits"].detach().roll(cells, (2, 3))
        merged = {"rgb.logits": moved, "depth.logits": results["depth.logits"].detach()}
        with torch.autocast(self._device.type, torch.bfloat16):
            forward(self._config.plan(("fusion",)), self.modules, merged)
        return merged["fusion.logits"]

    def _inputs(
        self, names: tuple[str, ...], bgr: npt.NDArray[np.uint8], depth: npt.NDArray[np.generic]
    ) -> dict[str, Any]:
        """Return the inputs of branches."""
        frames: dict[str, Any] = {}
        if "rgb" in names:
            frames["rgb.input"] = rgb_input(torch.from_numpy(bgr).to(self._device))
        if "depth" in names:
            frames["depth.input"] = depth_input(torch.from_numpy(depth.astype(np.float32)).to(self._device))
        return {name: value.contiguous(memory_format=torch.channels_last) for name, value in frames.items()}

    def _logits(
        self,
        bgr: npt.NDArray[np.uint8],
        depth: npt.NDArray[np.generic],
        output_stride: int | None,
        frozen: Mapping[str, Any],
    ) -> dict[str, Any]:
        """Run the networks that are learned on frames; `frozen` are the frozen branches' logits of them."""
        learned = self._stage.learned
        results = {**frozen, **self._inputs(learned, bgr, depth)}
        with torch.autocast(self._device.type, torch.bfloat16):
            forward(self._config.plan(learned, output_stride), self.modules, results)
        return results

    def _iou(self, frames: FrameSet) -> dict[str, float]:
        """Return the mean over held-out frames of each network's IoU, at the present phase's stride."""
        self.modules.eval()
        stride = self._stage.schedule.phase(self._step - 1).output_stride
        known = np.linspace(0, len(frames) - 1, min(_VALIDATED, len(frames))).astype(int)
        ious: dict[str, list[float]] = {name: [] for name in self._stage.learned}
        for indices in np.array_split(known, math.ceil(len(known) / 8)):
            with torch.no_grad():
                chosen = frames.bgr[indices], frames.depth[indices]
                results = self._logits(*chosen, stride, self._run_frozen(self._stage.frozen, *chosen))
            for name, values in ious.items():
                labels = _full_size(results[f"{name}.logits"]).argmax(1).to(torch.uint8).cpu().numpy()
                pairs = zip(labels, frames.labels[indices], strict=True)
                values.extend(image_iou(count_classes(*pair)) for pair in pairs)
        return {name: round(float(np.mean(values)), 4) for name, values in ious.items()}

    def _log(self, validation: FrameSet) -> str:
        """Add a line to the log, with the mean losses since the one before; returns it in words."""
        schedule = self._stage.schedule
        rate = schedule.learning_rate_at(self._step - 1)
        losses = {
            name: round(sum(each[name] for each in self._losses) / len(self._losses), 5)
            for name in self._losses[0]
        }
        self._losses = []
        line: dict[str, object] = {"step": self._step, "learning_rate": round(rate, 8), **losses}
        line["seconds"] = round(self._seconds, 1)
        note = "loss " + ", ".join(f"{name} {value:.3f}" for name, value in losses.items())
        if self._step % schedule.validate_every < schedule.log_every or self._step == schedule.steps:
            line["iou"] = self._iou(validation)
        with (self._folder / LOG).open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        return note

    def _save(self) -> None:
        path = self._folder / CHECKPOINT
        temporary = path.with_suffix(".tmp")
        state = {"modules": self.modules.state_dict(), "optimiser": self._optimiser.state_dict()}
        state |= {"step": self._step, "seconds": self._seconds, "config": self._description}
        state |= {"losses": self._losses, "random": torch.get_rng_state()}
        if self._device.type == "cuda":
            state["cuda_random"] = torch.cuda.get_rng_state()
        try:
            torch.save(state, temporary)
        except RuntimeError as error:  # whatever is wrong with the disk
            temporary.unlink(missing_ok=True)
            raise OutputError(
                f"The training cannot write {temporary}; is the disk full? ({error})"
            ) from error
        temporary.replace(path)

    def _load(self) -> None:
        path = self._folder / CHECKPOINT
        check_archive(path, DataError(f"The checkpoint {path} is damaged: delete it, and train anew."))
        try:
            state = torch.load(path, weights_only=True, map_location=self._device)
            if state["config"] != self._description:
                raise InvalidInputError(
                    f"The checkpoint {path} is of another training ({state['config']}), this one is "
                    f"{self._description}: choose another folder, or do not resume."
                )
            self.modules.load_state_dict(state["modules"])
            self._optimiser.load_state_dict(state["optimiser"])
            self._step, self._seconds = int(state["step"]), float(state["seconds"])
            self._losses = list(state["losses"])
            torch.set_rng_state(state["random"].cpu())
            if "cuda_random" in state and self._device.type == "cuda":
                torch.cuda.set_rng_state(state["cuda_random"].cpu())
        except _UNREADABLE as error:
            raise DataError(
                f"The checkpoint {path} cannot be used ({type(error).__name__}: {error})."
            ) from error


def start_from_the_sum(modules: Any) -> None:
    """Let the merging layers begin as about the sum of both branches' logits, which is a fusion already.

    The logits are raised for the layers with a ReLU, and lowered again by the last.
    """
    raised, weight = 10.0, 0.6
    layers = [modules.get_submodule(f"merge.{index}") for index in (0, 2, 4)]
    both = torch.eye(2 * len(CLASSES))
    means = [both, both, weight * (both[: len(CLASSES)] + both[len(CLASSES) :])]
    with torch.no_grad():
        for layer, mean, bias in zip(layers, means, (raised, 0.0, -2 * weight * raised), strict=True):
            layer.weight.normal_(std=0.002).add_(mean[:, :, None, None].to(layer.weight.device))
            layer.bias.fill_(bias)


def _movement(random: Any = None) -> tuple[int, int]:
    """Draw how far the colour camera's picture is moved, across and down, from torch's numbers or given ones."""
    across, down = (
        int(torch.randint(least, most + 1, (), generator=random))
        * (1 - 2 * int(torch.randint(2, (), generator=random)))
        for least, most in _SHIFT_PX
    )
    return across, down


def _cells(distance: int, stride: int) -> int:
    """Return a distance in cells, at least one unless it is none."""
    return int(np.sign(distance)) * max(round(abs(distance) / stride), 1)


def _full_size(maps: Any, phase: tuple[int, int] = (0, 0), step: int = 1) -> Any:
    """Return logits (N, 28, h, w) of any stride at the frames' size, or of every so-manieth pixel of it."""
    return upsample(maps.float(), WIDTH // maps.shape[3], phase, step, (HEIGHT, WIDTH))


def _parameters(modules: Any, decay: float) -> list[dict[str, Any]]:
    kernels = [p for p in modules.parameters() if p.ndim > 1]
    others = [p for p in modules.parameters() if p.ndim <= 1]
    return [{"params": kernels, "weight_decay": decay}, {"params": others, "weight_decay": 0.0}]


def _class_weights(frames: FrameSet, schedule: Schedule) -> npt.NDArray[np.float32]:
    every = max(1, len(frames) // 500)
    return class_weights(np.asarray(frames.labels[::every]), schedule.class_weight_range)


def _truncate_log(path: Path, step: int, learned: Sequence[str]) -> None:
    """Drop lines after a step, which a resumed run writes again, and what was being written at the end.

    What is drawn and told of a training, the losses of what is learned too, must be in every line.
    """
    try:
        text = path.read_text(encoding="utf-8") if step and path.exists() else ""
        lines = [line for line in text.splitlines(keepends=True) if line.endswith("\n")]
        read = [json.loads(line) for line in lines]
        names = {"step", "seconds", *learned}.union(*read[:1]) - {"iou"}
        for found in read:
            values = [*(found[name] for name in names), *{**found.get("iou", {})}.values()]
            if not all(map(math.isfinite, values)):
                raise ValueError(f"a number at step {found['step']} is not finite")  # noqa: TRY301
        kept = [line for line, found in zip(lines, read, strict=True) if found["step"] <= step]
    except (KeyError, OverflowError, RecursionError, TypeError, ValueError) as error:
        raise DataError(
            f"The training log {path} is damaged ({type(error).__name__}: {error}): delete its damaged lines."
        ) from error
    path.write_text("".join(kept), encoding="utf-8")


def _digest(weights: Weights) -> str:
    """Return a short checksum of tensors."""
    digest = hashlib.sha256()
    for name, value in weights.items():
        digest.update(name.encode())
        digest.update(value.contiguous().numpy().tobytes())
    return digest.hexdigest()[:12]


def _digest_of(frames: FrameSet) -> str:
    """Return a short checksum of frames."""
    digest = hashlib.sha256()
    for array in (frames.bgr, frames.depth, frames.labels):
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()[:12]
