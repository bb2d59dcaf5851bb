"""The training loop: all networks of a model at once, resumable, with a log that curves are drawn from."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch.nn import functional

from sunset.errors import InvalidInputError
from sunset.training.architecture import Layer
from sunset.training.batches import Batch, FrameSet, batches, class_weights
from sunset.training.config import TrainingConfig
from sunset.training.network import Weights, build, depth_input, folded_weights, forward, rgb_input, upsample

__all__ = ["CHECKPOINT", "LOG", "Progress", "fit"]

Progress = Callable[[int, int], None]
"""Called with steps done and steps in all."""

CHECKPOINT = "checkpoint.pt"
LOG = "log.jsonl"

_STRIDE = 2
_IGNORED = 255


def _learning_rate(config: TrainingConfig, step: int) -> float:
    schedule = config.schedule
    warm = min(1.0, (step + 1) / schedule.warm_up)
    return warm * schedule.learning_rate * 0.5 * (1 + math.cos(math.pi * step / schedule.steps))


def _losses(
    config: TrainingConfig, layers: tuple[Layer, ...], modules: Any, batch: Batch, weights: Any
) -> dict[str, Any]:
    """Return the cross entropy of each network, on every second row and column of the full resolution."""
    results: dict[str, Any] = {}
    if "rgb" in config.branches:
        results["rgb.input"] = rgb_input(torch.from_numpy(batch.bgr))
    if "depth" in config.branches:
        results["depth.input"] = depth_input(torch.from_numpy(batch.depth))
    for name, value in results.items():
        results[name] = value.contiguous(memory_format=torch.channels_last)
    with torch.autocast("cpu", torch.bfloat16):
        forward(layers, modules, results)
    row, column = batch.phase
    labels = torch.from_numpy(np.ascontiguousarray(batch.labels[:, row::2, column::2]))
    losses = {}
    for name in config.modalities:
        logits = upsample(results[f"{name}.logits"].float(), _STRIDE, batch.phase, 2)
        losses[name] = functional.cross_entropy(logits, labels, weights, ignore_index=_IGNORED)
    return losses


def _save(path: Path, state: dict[str, Any]) -> None:
    temporary = path.with_suffix(".tmp")
    torch.save(state, temporary)
    temporary.replace(path)


def _resume(path: Path, description: str, modules: Any, optimiser: Any) -> int:
    state = torch.load(path, weights_only=True)
    if state["config"] != description:
        raise InvalidInputError(
            f"The checkpoint {path} is of another training ({state['config']}), this one is {description}: "
            f"choose another folder, or do not resume."
        )
    modules.load_state_dict(state["modules"])
    optimiser.load_state_dict(state["optimiser"])
    return int(state["step"])


def _parameters(modules: Any, decay: float) -> list[dict[str, Any]]:
    kernels = [p for p in modules.parameters() if p.ndim > 1]
    others = [p for p in modules.parameters() if p.ndim <= 1]
    return [{"params": kernels, "weight_decay": decay}, {"params": others, "weight_decay": 0.0}]


def _truncate_log(path: Path, step: int) -> None:
    """Drop lines at or after a step, which a resumed run writes again."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    kept = [line for line in lines if json.loads(line)["step"] < step]
    path.write_text("".join(f"{line}\n" for line in kept), encoding="utf-8")


def fit(
    config: TrainingConfig,
    frames: FrameSet,
    folder: Path,
    *,
    resume: bool = False,
    progress: Progress | None = None,
) -> Weights:
    """Learn the weights of all networks of a model.

    The branches learn from their own loss and, through it, from the fusion's. Every so many steps a
    checkpoint is written; with `resume`, training goes on at the last one as if it had never stopped.

    Args:
        config: what to train.
        frames: the training frames.
        folder: where `checkpoint.pt` and `log.jsonl` (a line per `log_every` steps: step, learning rate,
            loss per network) are kept.
        resume: go on at the folder's checkpoint if there is one.
        progress: called after every step.

    Returns:
        Kernels and biases by layer, normalisation folded in.

    Raises:
        InvalidInputError: the checkpoint to resume at is another training's.
    """
    folder.mkdir(parents=True, exist_ok=True)
    torch.manual_seed(config.seed)
    layers = config.all_layers()
    modules = build(layers, config.schedule.momentum)
    optimiser = torch.optim.AdamW(_parameters(modules, config.schedule.weight_decay))
    checkpoint, description = folder / CHECKPOINT, repr(config)
    first = _resume(checkpoint, description, modules, optimiser) if resume and checkpoint.exists() else 0
    _truncate_log(folder / LOG, first)
    weights = torch.from_numpy(_weights_of(frames, config))
    schedule, sums = config.schedule, dict.fromkeys(config.modalities, 0.0)
    coming = batches(frames, schedule.batch, config.seed, first, schedule.steps)
    modules.train()
    for done, batch in enumerate(coming, start=first + 1):
        losses = _step(
            config, layers, modules, optimiser=optimiser, batch=batch, weights=weights, step=done - 1
        )
        for name, loss in losses.items():
            sums[name] += loss
        last = done == schedule.steps
        if done % schedule.log_every == 0 or last:
            _log(folder / LOG, done, config, sums)
            sums = dict.fromkeys(config.modalities, 0.0)
        if done % schedule.checkpoint_every == 0 or last:
            state = {"modules": modules.state_dict(), "optimiser": optimiser.state_dict()}
            _save(checkpoint, {**state, "step": done, "config": description})
        if progress is not None:
            progress(done, schedule.steps)
    modules.eval()
    return folded_weights(layers, modules)


def _step(
    config: TrainingConfig,
    layers: tuple[Layer, ...],
    modules: Any,
    *,
    optimiser: Any,
    batch: Batch,
    weights: Any,
    step: int,
) -> dict[str, float]:
    """Take one step; returns the losses before it."""
    for group in optimiser.param_groups:
        group["lr"] = _learning_rate(config, step)
    losses = _losses(config, layers, modules, batch, weights)
    optimiser.zero_grad()
    torch.stack(list(losses.values())).sum().backward()
    optimiser.step()
    return {name: float(loss.detach()) for name, loss in losses.items()}


def _weights_of(frames: FrameSet, config: TrainingConfig) -> npt.NDArray[np.float32]:
    every = max(1, len(frames) // 500)
    return class_weights(np.asarray(frames.labels[::every]), config.schedule.class_weight_range)


def _log(path: Path, step: int, config: TrainingConfig, sums: dict[str, float]) -> None:
    count = step % config.schedule.log_every or config.schedule.log_every
    line = {"step": step, "learning_rate": round(_learning_rate(config, step - 1), 8)}
    line |= {name: round(value / count, 5) for name, value in sums.items()}
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(line) + "\n")
