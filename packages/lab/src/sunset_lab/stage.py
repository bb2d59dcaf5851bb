"""A stage of a training: networks that are learned together, with checkpoints and a log."""

import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
import torch
from torch import Tensor, nn
from torch.nn import functional

from sunset.classes import IGNORED
from sunset.errors import DataError, InvalidInputError, OutputError, SunsetError
from sunset.metrics import count_classes, image_iou
from sunset.perception import Model
from sunset_lab.architecture import HEIGHT, WIDTH
from sunset_lab.augment import Batch, DeviceFrames, cells_of, class_weights, draw, movement
from sunset_lab.config import Stage, TrainingConfig
from sunset_lab.network import (
    build,
    check_archive,
    depth_input,
    digest_of_weights,
    forward,
    rgb_input,
    start_from_the_sum,
    upsample,
)
from sunset_ros.interruption import held_signals
from sunset_ros.seeding import drawn_seed

LOG: Final = "log.jsonl"
CHECKPOINT: Final = "checkpoint.pt"
CHECKPOINT_EVERY_S: Final = 120.0
"""Seconds between checkpoints, which are large: 1 GB for both branches of `reference`."""

Weights = Mapping[str, Tensor]
"""Tensors by name: a torch state dict."""

Progress = Callable[..., None]
"""Called with a title, the work done, the work in all, and a remark; its exceptions end the training in order."""


@dataclass(frozen=True, slots=True)
class Training:
    """A training and how it is run."""

    config: TrainingConfig
    work: Path  # the folder of frames, checkpoints and logs
    start: Model | None = None  # to train further; None for random weights
    # Whether to continue at the last checkpoint in the work folder, which must hold none otherwise.
    resume: bool = False
    jobs: int = 1  # processes that render and measure
    device: str = "cpu"  # where networks learn: "cpu", "cuda", or "auto" for "cuda" where torch offers it
    compiled: bool = False  # whether torch compiles the networks
    progress: Progress | None = None  # its exceptions end the training in order, so that it can be resumed

    @property
    def origin(self) -> str:
        """The name and version of the model that it starts from; empty for random weights."""
        return "" if self.start is None else f"{self.start.card.name}, version {self.start.card.version}"


@dataclass(frozen=True, slots=True)
class Material:
    """The frames and weights that the stages of a training share, on torch's `device`."""

    frames: DeviceFrames
    digest: str  # the checksum of the frames
    labels: npt.NDArray[np.uint8]  # of some frames, for the weights of classes
    validation: DeviceFrames  # the frames of the log's IoU
    begun: Weights  # the weights that the training starts from; empty for random weights
    device: torch.device


class StageRun:
    """A stage, whose progress a folder keeps; `known` are the weights of earlier stages."""

    def __init__(self, training: Training, material: Material, stage: Stage, known: Weights) -> None:
        config = training.config
        torch.manual_seed(config.seed)
        self._training, self._config, self._material, self._stage = training, config, material, stage
        self._folder, self._device = training.work / stage.name, material.device
        self._modules = build(config.plan(stage.learned))
        own = self._modules.state_dict()
        if material.begun:
            self._modules.load_state_dict({name: material.begun[name] for name in own})
        elif stage.begun_with is not None:
            names = zip(own, build(config.plan((stage.begun_with,))).state_dict(), strict=True)
            self._modules.load_state_dict({name: known[other] for name, other in names})
        elif stage.frozen:
            start_from_the_sum(self._modules)
        self._modules.to(self._device)
        self._frozen = build(config.plan(stage.frozen)).to(self._device).eval()
        self._frozen.load_state_dict({name: known[name] for name in self._frozen.state_dict()})
        self._optimiser = torch.optim.AdamW(
            _parameters(self._modules, stage.schedule.weight_decay), fused=True
        )
        self._learned_forward = torch.compile(forward) if training.compiled else forward
        weights = class_weights(material.labels, stage.schedule.class_weight_range)
        self._weights = torch.from_numpy(weights).to(self._device)
        misaligned = "fusion" in stage.learned and stage.schedule.misaligned_weight > 0
        self._names = (*stage.learned, "misaligned") if misaligned else stage.learned  # of the losses
        self._identity = _identity(training, material, stage, known)
        self._step, self._since = 0, time.perf_counter()  # when it would have begun without an interruption
        self._losses: list[Tensor] = []  # of each step since the last line of the log
        self._kept: dict[int, dict[str, Tensor]] = {}

    def fit(self) -> Weights:
        """Take all remaining steps, and return the weights; write checkpoints regularly, and on an interruption."""
        self._folder.mkdir(parents=True, exist_ok=True)
        if self._training.resume and (self._folder / CHECKPOINT).exists():
            self._load()
        _truncate(self._folder / LOG, self._step)
        schedule, progress, note = self._stage.schedule, self._training.progress, ""
        saved = time.perf_counter()
        with held_signals("Ending after this step.") as raise_signal:
            while self._step < schedule.steps:
                self._learn()
                last = self._step == schedule.steps
                if self._step % schedule.log_every == 0 or last:
                    note = self._log()
                try:
                    raise_signal()
                    if progress is not None:
                        progress(self._stage.name, self._step, schedule.steps, note)
                except BaseException:
                    self._save()
                    raise
                if last or time.perf_counter() - saved >= CHECKPOINT_EVERY_S:
                    self._save()
                    saved = time.perf_counter()
        return {name: value.cpu() for name, value in self._modules.state_dict().items()}

    def _number(self) -> int:
        """Return the number of the next step's batch."""
        distinct = self._stage.schedule.distinct
        return self._step if distinct is None else self._step % distinct

    def _learn(self) -> None:
        """Take one step, without waiting for the device."""
        schedule, frames = self._stage.schedule, self._material.frames
        phase = schedule.phase(self._step)
        batch = frames.batch(draw(len(frames), phase.batch, self._config.seed, self._number()))
        self._modules.train()
        for module in self._modules.modules():
            if isinstance(module, nn.BatchNorm2d):
                module.momentum = phase.momentum
        for group in self._optimiser.param_groups:
            group["lr"] = schedule.learning_rate_at(self._step)
        frozen = self._frozen_logits(batch)
        results = self._logits(self._learned_forward, batch, phase.output_stride, frozen)
        row, column = batch.phase
        labels = batch.labels[:, row::2, column::2].contiguous()

        def loss(maps: Tensor, smoothing: float = 0.0) -> Tensor:
            logits = _full_size(maps, batch.phase, 2)
            return functional.cross_entropy(
                logits, labels, self._weights, ignore_index=IGNORED, label_smoothing=smoothing
            )

        losses = [loss(results[f"{name}.logits"]) for name in self._stage.learned]
        if "misaligned" in self._names:
            misaligned = loss(self._misaligned(results), schedule.misaligned_smoothing)
            losses.append(schedule.misaligned_weight * misaligned)
        stacked = torch.stack(losses)
        self._optimiser.zero_grad()
        stacked.sum().backward()
        self._optimiser.step()
        self._step += 1
        self._losses.append(stacked.detach())

    def _frozen_logits(self, batch: Batch) -> dict[str, Tensor]:
        """Return the frozen branches' logits of a batch, and `moved`, the logits of its moved colour pictures.

        They are kept if batches repeat.
        """
        if not self._stage.frozen:
            return {}
        number = self._number()
        if number not in self._kept:
            seed = drawn_seed(self._config.seed, "training", "movement", number)
            across, down = movement(torch.Generator().manual_seed(seed))
            moved = self._run_frozen(("rgb",), batch.bgr.roll((down, across), (1, 2)), batch.depth)
            kept = self._run_frozen(self._stage.frozen, batch.bgr, batch.depth)
            kept["moved"] = moved["rgb.logits"]
            if self._stage.schedule.distinct is None:
                return kept
            self._kept[number] = kept
        return self._kept[number]

    def _run_frozen(self, names: tuple[str, ...], bgr: Tensor, depth: Tensor) -> dict[str, Tensor]:
        results = _inputs(names, bgr, depth)
        with self._autocast(), torch.no_grad():
            forward(self._config.plan(names), self._frozen, results)
        return {f"{name}.logits": results[f"{name}.logits"] for name in names}

    def _misaligned(self, results: Mapping[str, Tensor]) -> Tensor:
        """Return the merged logits of a colour picture that is moved against the depth picture.

        Only the merging layers learn from it. Frozen branches have seen the moved picture; the logits of other branches
        are moved by whole cells, which is the same except at the borders.
        """
        moved = results.get("moved")
        if moved is None:
            stride = WIDTH // results["rgb.logits"].shape[3]
            across, down = movement()
            cells = (cells_of(down, stride), cells_of(across, stride))
            moved = results["rgb.logits"].detach().roll(cells, (2, 3))
        merged = {"rgb.logits": moved, "depth.logits": results["depth.logits"].detach()}
        with self._autocast():
            forward(self._config.plan(("fusion",)), self._modules, merged)
        return merged["fusion.logits"]

    def _autocast(self) -> torch.autocast:
        """Return a context of bfloat16, or of float32 on a processor without bfloat16."""
        slow = self._device.type == "cpu" and torch.backends.cpu.get_cpu_capability() in {"DEFAULT", "AVX2"}
        return torch.autocast(self._device.type, torch.bfloat16, enabled=not slow)

    def _logits(
        self, run: Callable[..., None], frames: Batch, output_stride: int | None, frozen: Mapping[str, Tensor]
    ) -> dict[str, Tensor]:
        """Run the learned networks on frames; `frozen` are the frozen branches' logits."""
        learned = self._stage.learned
        results = {**frozen, **_inputs(learned, frames.bgr, frames.depth)}
        with self._autocast():
            run(self._config.plan(learned, output_stride), self._modules, results)
        return results

    def _iou(self) -> dict[str, float]:
        """Return each network's mean IoU on the held-out frames, at the stride of the phase."""
        self._modules.eval()
        frames = self._material.validation
        stride = self._stage.schedule.phase(self._step - 1).output_stride
        ious: dict[str, list[float]] = {name: [] for name in self._stage.learned}
        for indices in np.array_split(np.arange(len(frames)), math.ceil(len(frames) / 8)):
            batch = frames.plain(indices)
            truth = batch.labels.cpu().numpy()
            with torch.no_grad():
                frozen = self._run_frozen(self._stage.frozen, batch.bgr, batch.depth)
                results = self._logits(forward, batch, stride, frozen)
            for name, values in ious.items():
                labels = _full_size(results[f"{name}.logits"]).argmax(1).to(torch.uint8).cpu().numpy()
                values.extend(image_iou(count_classes(*pair)) for pair in zip(labels, truth, strict=True))
        return {name: round(float(np.mean(values)), 4) for name, values in ious.items()}

    def _recent_losses(self) -> Tensor:
        """Return the losses (steps, losses) since the last line of the log, which must be finite."""
        losses = torch.stack(self._losses).cpu() if self._losses else torch.empty(0, len(self._names))
        for step, values in enumerate(losses.tolist(), self._step - len(losses) + 1):
            if not all(map(math.isfinite, values)):
                raise SunsetError(
                    f"The training of {self._stage.name} diverged at step {step}: its losses are "
                    f"{dict(zip(self._names, values, strict=True))}; what it had learned at its last checkpoint is "
                    "kept."
                )
        return losses

    def _log(self) -> str:
        """Add a line to the log with the mean losses since the line before, and return it in words."""
        schedule = self._stage.schedule
        rate = schedule.learning_rate_at(self._step - 1)
        means = self._recent_losses().double().mean(0).tolist()
        losses = {name: round(mean, 5) for name, mean in zip(self._names, means, strict=True)}
        self._losses = []
        line: dict[str, object] = {"step": self._step, "learning_rate": round(rate, 8), **losses}
        line["seconds"] = round(time.perf_counter() - self._since, 1)
        if self._step % schedule.validate_every < schedule.log_every or self._step == schedule.steps:
            line["iou"] = self._iou()
        with (self._folder / LOG).open("a", encoding="utf-8") as file:
            file.write(json.dumps(line) + "\n")
        return "loss " + ", ".join(f"{name} {value:.3f}" for name, value in losses.items())

    def _save(self) -> None:
        """Write a checkpoint; without the optimiser, two thirds of it, when the stage is finished."""
        path = self._folder / CHECKPOINT
        temporary = path.with_suffix(".tmp")
        state = {
            "modules": self._modules.state_dict(),
            "step": self._step,
            "seconds": time.perf_counter() - self._since,
            "identity": self._identity,
            "losses": self._recent_losses(),
            "random": torch.get_rng_state(),
        }
        if self._step < self._stage.schedule.steps:
            state["optimiser"] = self._optimiser.state_dict()
        try:
            torch.save(state, temporary)
        except RuntimeError as error:  # an error of the disk
            temporary.unlink(missing_ok=True)
            raise OutputError(
                f"The training cannot write {temporary}; is the disk full? ({error})"
            ) from error
        temporary.replace(path)

    def _load(self) -> None:
        path = self._folder / CHECKPOINT
        check_archive(path, DataError(f"The checkpoint {path} is damaged: delete it, and train again."))
        state = torch.load(path, weights_only=True, map_location=self._device)
        if (begun := state["identity"]) != self._identity:
            differing = [
                f"{option} (begun with {begun[option]}, asked for {value})"
                for option, value in self._identity.items()
                if option.startswith("--") and begun[option] != value
            ]
            raise InvalidInputError(
                f"The checkpoint {path} is of another training: they differ in "
                f"{' and '.join(differing) or 'the version of SUNSET'}; choose another folder."
            )
        self._modules.load_state_dict(state["modules"])
        self._step, self._since = state["step"], time.perf_counter() - state["seconds"]
        if self._step < self._stage.schedule.steps:
            self._optimiser.load_state_dict(state["optimiser"])
        self._losses = list(state["losses"])
        torch.set_rng_state(state["random"].cpu())


def _identity(training: Training, material: Material, stage: Stage, known: Weights) -> dict[str, str]:
    """Return everything that a stage's weights depend on, as far as possible by the options of `sunset train`."""
    config = training.config
    return {
        "--model": type(config.shape).__name__,
        "--modality": ", ".join(stage.learned),
        "--steps": str(stage.schedule.steps),
        "--batch": ", ".join(dict.fromkeys(str(phase.batch) for phase in stage.schedule.phases)),
        "--seed": str(config.seed),
        "--frames": f"checksum {material.digest[:8]}",
        "--start-from": training.origin or "random weights",
        "others": repr((stage, config.shape, digest_of_weights(known))),
    }


def _inputs(names: tuple[str, ...], bgr: Tensor, depth: Tensor) -> dict[str, Tensor]:
    frames: dict[str, Tensor] = {}
    if "rgb" in names:
        frames["rgb.input"] = rgb_input(bgr)
    if "depth" in names:
        frames["depth.input"] = depth_input(depth)
    return {name: value.contiguous(memory_format=torch.channels_last) for name, value in frames.items()}


def _full_size(maps: Tensor, phase: tuple[int, int] = (0, 0), step: int = 1) -> Tensor:
    """Return logits (N, 28, h, w) interpolated to the frames' size, or to every `step`-th pixel of it."""
    return upsample(maps.float(), WIDTH // maps.shape[3], phase, step, (HEIGHT, WIDTH))


def _parameters(modules: nn.Module, decay: float) -> list[dict[str, object]]:
    kernels = [p for p in modules.parameters() if p.ndim > 1]
    others = [p for p in modules.parameters() if p.ndim <= 1]
    return [{"params": kernels, "weight_decay": decay}, {"params": others, "weight_decay": 0.0}]


def _truncate(log: Path, step: int) -> None:
    """Drop an incomplete last line of a log, and the lines after a step, which a resumed training writes again."""
    lines = log.read_text(encoding="utf-8").splitlines(keepends=True) if step and log.exists() else []
    kept = [line for line in lines if line.endswith("\n") and json.loads(line)["step"] <= step]
    log.write_text("".join(kept), encoding="utf-8")
