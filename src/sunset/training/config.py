"""What a training run is asked to do."""

from dataclasses import dataclass, field, replace
from typing import Final

from sunset.errors import InvalidInputError
from sunset.training.architecture import Layer, NetworkShape, branch, merge

__all__ = ["MODALITIES", "Schedule", "TrainingConfig"]

MODALITIES: Final = ("rgb", "depth", "fusion")
"""The networks of a model; the fusion needs the other two."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """How weights are learned.

    Attributes:
        steps: optimiser steps.
        batch: frames a step.
        learning_rate: greatest, of AdamW; falls to 0 along a cosine after `warm_up` steps.
        weight_decay: of AdamW.
        momentum: of batch normalisation's running statistics.
        class_weight_range: least and greatest weight of a class; weights are the inverse square root of the
            class's share of pixels, so that small classes count, but are not seen where there are none.
        checkpoint_every: steps between checkpoints.
        log_every: steps between lines of the log.
    """

    steps: int = 4200
    batch: int = 16
    learning_rate: float = 2e-3
    weight_decay: float = 0.01
    warm_up: int = 100
    momentum: float = 0.1
    class_weight_range: tuple[float, float] = (0.5, 3.0)
    checkpoint_every: int = 200
    log_every: int = 20


@dataclass(frozen=True, slots=True)
class TrainingConfig:
    """A training run.

    Attributes:
        name: the model's.
        modalities: the networks that are trained: "rgb", "depth" and, with both, "fusion".
        seed: of everything that is drawn.
        shape: the widths of each branch.
        schedule: how weights are learned.
    """

    name: str = "lite"
    modalities: tuple[str, ...] = MODALITIES
    seed: int = 1
    shape: NetworkShape = field(default_factory=NetworkShape)
    schedule: Schedule = field(default_factory=Schedule)

    def __post_init__(self) -> None:
        """Refuse what cannot be trained."""
        unknown = sorted(set(self.modalities) - set(MODALITIES))
        if unknown or not self.modalities:
            raise InvalidInputError(
                f"The modalities to train must be some of {', '.join(MODALITIES)}, got "
                f"{', '.join(self.modalities) or 'none'}."
            )
        if "fusion" in self.modalities and len(set(self.modalities)) < len(MODALITIES):
            raise InvalidInputError(
                "The fusion is trained together with both branches: ask for all modalities."
            )
        if self.schedule.steps < 1 or self.schedule.batch < 1:
            raise InvalidInputError(
                f"A training needs at least one step and one frame a step, got {self.schedule.steps} "
                f"and {self.schedule.batch}."
            )

    @property
    def branches(self) -> tuple[str, ...]:
        """The modalities that are branches."""
        return tuple(name for name in MODALITIES if name in self.modalities and name != "fusion")

    def layers(self, modality: str) -> tuple[Layer, ...]:
        """Return the plan of one network."""
        if modality == "fusion":
            plans = tuple(layer for name in self.branches for layer in branch(name, self.shape))
            return plans + merge(self.branches)
        return branch(modality, self.shape)

    def all_layers(self) -> tuple[Layer, ...]:
        """Return the plan of all networks at once: the fusion contains the branches."""
        if "fusion" in self.modalities:
            return self.layers("fusion")
        return tuple(layer for name in self.branches for layer in branch(name, self.shape))

    def with_steps(self, steps: int) -> "TrainingConfig":
        """Return the same run with another number of steps."""
        return replace(self, schedule=replace(self.schedule, steps=steps))
