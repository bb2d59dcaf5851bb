"""The configuration of a training: networks, schedule and seed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from sunset.perception.card import check_name
from sunset_lab.architecture import Layer
from sunset_lab.shapes import LiteShape, ReferenceShape
from sunset_ros.seeding import check_seed

MODALITIES: Final = ("rgb", "depth", "fusion")
"""The networks of a model; the fusion needs both others."""


@dataclass(frozen=True, slots=True)
class Phase:
    """Consecutive steps with the same settings."""

    steps: int  # optimiser steps
    batch: int  # frames a step
    # Of the branches' logits; None for the networks' own. Weights run several times faster at a coarser stride.
    output_stride: int | None = None
    momentum: float = 0.1  # of batch normalisation's running statistics
    learning_rate: float | None = None  # the greatest, from which it falls again; None to continue


@dataclass(frozen=True, slots=True)
class Schedule:
    """How weights are learned."""

    phases: tuple[Phase, ...] = (Phase(steps=4200, batch=16),)  # in order
    # The greatest, of AdamW; falls to 0 along a cosine, until a phase has its own.
    learning_rate: float = 2e-3
    weight_decay: float = 0.01  # of AdamW
    warm_up: int = 100  # steps during which the learning rate rises, whenever it begins to fall
    # Least and greatest weight of a class; the inverse square root of the class's share of pixels,
    # so that small classes count, but are not predicted everywhere.
    class_weight_range: tuple[float, float] = (0.5, 3.0)
    # Of the fusion's loss on misaligned pairs of pictures; the merging layers learn to be unsure where
    # colour and depth contradict each other.
    misaligned_weight: float = 0.4
    misaligned_smoothing: float = 0.3  # share of a target there that is spread over all classes, in [0, 1]
    # Steps after which the batches repeat, so that the frozen branches' logits are kept; None for never.
    distinct: int | None = None
    log_every: int = 20  # steps between lines of the log
    validate_every: int = 400  # steps between lines of the log with the IoU on held-out frames

    @property
    def steps(self) -> int:
        """Steps of all phases."""
        return sum(phase.steps for phase in self.phases)

    def phase(self, step: int) -> Phase:
        """Return the phase of a step."""
        for phase in self.phases:
            if step < phase.steps:
                return phase
            step -= phase.steps
        raise IndexError(step)

    def learning_rate_at(self, step: int) -> float:
        """Return the learning rate of a step."""
        begin, end, greatest = 0, 0, self.learning_rate
        for phase in self.phases:
            if phase.learning_rate is not None:
                if step < end:
                    break
                begin, greatest = end, phase.learning_rate
            end += phase.steps
        risen = min(1.0, (step - begin + 1) / self.warm_up)
        return risen * greatest * 0.5 * (1 + math.cos(math.pi * (step - begin) / (end - begin)))

    def with_steps(self, steps: int) -> "Schedule":
        """Return the schedule with `steps` in all; a phase without steps is dropped."""
        phases, old, new = [], 0, 0
        for phase in self.phases:
            old += phase.steps
            end = round(steps * old / self.steps)
            if end > new:
                phases.append(replace(phase, steps=end - new))
            new = end
        return replace(self, phases=tuple(phases))

    def with_batch(self, frames: int) -> "Schedule":
        """Return the schedule with `frames` in every step."""
        return replace(self, phases=tuple(replace(phase, batch=frames) for phase in self.phases))


@dataclass(frozen=True, slots=True)
class Stage:
    """Networks that are learned together."""

    name: str  # of the folder with its checkpoint and log
    learned: tuple[str, ...]  # the networks with a loss: "rgb", "depth", "fusion"
    schedule: Schedule
    frozen: tuple[str, ...] = ()  # branches learned before, which only run
    begun_with: str | None = None  # the branch whose weights are the start; None for random weights


@dataclass(frozen=True, slots=True)
class TrainingConfig:
    """A training."""

    name: str = "lite"  # the model's
    modalities: tuple[str, ...] = MODALITIES  # the networks: "rgb", "depth" and, with both, "fusion"
    seed: int = 1  # of all random numbers
    shape: LiteShape | ReferenceShape = field(default_factory=LiteShape)
    schedule: Schedule = field(default_factory=Schedule)
    merging: Schedule | None = None  # of the late fusion on finished branches; None to learn all together
    further: Schedule | None = None  # of all networks of a trained model together; None for `schedule`
    # Share of the logarithm of the class weights that is subtracted from the final logits (Menon et al.,
    # Long-tail learning via logit adjustment, ICLR 2021). A loss weighted by w adds log w to the logits, so a
    # rare class would be predicted too often.
    logit_adjustment: float = 0.4

    def __post_init__(self) -> None:
        check_name(self.name)
        check_seed(self.seed)

    @property
    def branches(self) -> tuple[str, ...]:
        """The modalities that are branches."""
        return tuple(name for name in MODALITIES if name in self.modalities and name != "fusion")

    def stages(self) -> tuple[Stage, ...]:
        """Return the stages in order.

        A second branch begins with the weights of the first: edges and surfaces look alike in colour and depth.
        """
        if self.merging is None:
            return (Stage("networks", self.modalities, self.schedule),)
        first, *others = self.branches
        stages = [Stage(first, (first,), self.schedule)]
        stages += [Stage(name, (name,), self.schedule, begun_with=first) for name in others]
        if "fusion" in self.modalities:
            stages.append(Stage("fusion", ("fusion",), self.merging, frozen=self.branches))
        return tuple(stages)

    def started(self) -> "TrainingConfig":
        """Return the configuration for training a model further."""
        return self if self.further is None else replace(self, schedule=self.further, merging=None)

    def plan(self, networks: tuple[str, ...], output_stride: int | None = None) -> tuple[Layer, ...]:
        """Return the layers of networks; for the fusion, its merging layers only."""
        plans = [self.shape.branch(name, output_stride) for name in networks if name != "fusion"]
        if "fusion" in networks:
            plans.append(self.shape.merge())
        return tuple(layer for plan in plans for layer in plan)

    def layers(self, modality: str) -> tuple[Layer, ...]:
        """Return all layers of a network."""
        return self.plan(MODALITIES if modality == "fusion" else (modality,))

    def with_steps(self, steps: int) -> "TrainingConfig":
        """Return the configuration with another number of steps; the merging of finished branches keeps its own."""
        return replace(self, schedule=self.schedule.with_steps(steps))

    def with_batch(self, frames: int) -> "TrainingConfig":
        """Return the configuration with `frames` in every step."""
        merging = self.merging and self.merging.with_batch(frames)
        return replace(self, schedule=self.schedule.with_batch(frames), merging=merging)


CONFIGS: Final[Mapping[str, TrainingConfig]] = {
    "lite": TrainingConfig(),
    "reference": TrainingConfig(
        name="reference",
        shape=ReferenceShape(),
        schedule=Schedule(
            phases=(
                Phase(6600, 8, output_stride=16),
                Phase(800, 8, momentum=0.05, learning_rate=2e-4),  # with other dilations
                Phase(100, 8, momentum=0.02),
            ),
            learning_rate=1e-3,
            weight_decay=0.02,
            warm_up=200,
            validate_every=250,
        ),
        merging=Schedule(
            phases=(Phase(1400, 8),), learning_rate=2e-3, warm_up=20, distinct=140, validate_every=350
        ),
        further=Schedule(
            phases=(Phase(2400, 8, momentum=0.05), Phase(100, 8, momentum=0.02)),
            learning_rate=3e-4,
            weight_decay=0.02,
            validate_every=250,
        ),
    ),
}
"""The configurations of the models of the package, by name."""
