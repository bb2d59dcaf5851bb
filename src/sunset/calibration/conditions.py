"""Conditions: the faults and adaptations through which a frame passes before it is segmented."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.errors import ExtensionError, InvalidInputError
from sunset.faults import sharpness
from sunset.images import Pixels
from sunset.perception import Modality, ModelCard
from sunset.system import (
    ENTROPY_SIGNAL,
    SHARPNESS_SIGNAL,
    Adaptation,
    Effect,
    ImageFunction,
    current_system,
    get_fault,
)

ENTROPY: Final = ENTROPY_SIGNAL.name
"""The signal of faults that make the segmentation unsure."""

SHARPNESS: Final = SHARPNESS_SIGNAL.name
"""The signal of faults that blur the camera's images."""


def effects() -> Mapping[str, Effect]:
    """Return the known effects of faults on images, by fault."""
    faults = current_system().faults.values()
    return {fault.name: fault.effect for fault in faults if fault.effect is not None}


def signal_of(fault: str) -> str:
    """Return the name of a fault's signal."""
    return current_system().failures[get_fault(fault).failure].signal


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """A frame as the segmentation receives it.

    Attributes:
        bgr: (H, W, 3) uint8.
        depth: (H, W) uint16.
        sharpness: of the camera's image, before enhancement and fusion.
    """

    bgr: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16]
    sharpness: float


@dataclass(frozen=True, slots=True)
class Condition:
    """The network that segments, and the state of its images.

    Attributes:
        modality: the network.
        strengths: (fault, strength) of the faults, in the order of the catalogue.
        restored: faults whose cure restores the images while the fault persists.
    """

    modality: Modality
    strengths: tuple[tuple[str, float], ...] = ()
    restored: tuple[str, ...] = ()

    def with_faults(self, strengths: Mapping[str, float]) -> "Condition":
        """Return the condition with faults added, each at a strength."""
        merged = {**dict(self.strengths), **strengths}
        return replace(
            self, strengths=tuple((fault, merged[fault]) for fault in effects() if merged.get(fault))
        )

    def cured_of(self, fault: str) -> "Condition":
        """Return the condition after the cheapest cure of a fault."""
        modality, known = self.modality, effects()
        for step in cure_of(fault):
            if (step.node, step.parameter) == ("sensor_fusion", "modality") and isinstance(step.value, int):
                modality = Modality(step.value)
        restores = known[fault].restore is not None
        left = tuple(
            (name, strength)
            for name, strength in self.strengths
            if (name != fault or restores) and is_seen(known[name], modality)
        )
        restored = {*self.restored, fault} if restores else {*self.restored}
        return Condition(modality, left, tuple(name for name, _ in left if name in restored))

    def seen(
        self, bgr: npt.NDArray[np.uint8], depth: npt.NDArray[np.uint16], rng: np.random.Generator
    ) -> Seen:
        """Pass a frame, `bgr` (H, W, 3) and `depth` (H, W), through the pipeline; `rng` draws the noise of faults."""
        images: dict[str, Pixels] = {"camera": bgr, "depth": depth}
        system, known = current_system(), effects()
        camera = system.signals[SHARPNESS].node
        first = {camera, *system.upstream[camera]}
        seen = [pair for pair in self.strengths if is_seen(known[pair[0]], self.modality)]
        for fault, strength in seen:
            if get_fault(fault).node in first:
                _apply(fault, known[fault].degrade, strength, images, rng)
        measured = sharpness(images["camera"])
        for fault, strength in seen:
            if get_fault(fault).node not in first:
                _apply(fault, known[fault].degrade, strength, images, rng)
        for fault, strength in seen:
            restore = known[fault].restore
            if fault in self.restored and restore:
                _apply(fault, restore, strength, images, rng)
        return Seen(images["camera"], images["depth"], measured)


def is_seen(effect: Effect, modality: Modality) -> bool:
    """Return whether a network takes the images that a fault degrades."""
    return modality.needs_depth if effect.sensor == "depth" else modality.needs_rgb


def _apply(
    fault: str, function: ImageFunction, strength: float, images: dict[str, Pixels], rng: np.random.Generator
) -> None:
    effect = effects()[fault]
    image = images[effect.sensor].view()
    image.flags.writeable = False  # other conditions use it, too
    try:
        changed = current_system().image_function(function)(
            image, strength, *([rng] if effect.random else [])
        )
    except Exception as error:
        raise ExtensionError(
            f"The effect of the fault {fault} raised {type(error).__name__} at the strength {strength:g}: {error}."
        ) from error
    got = (getattr(changed, "shape", None), getattr(changed, "dtype", type(changed).__name__))
    if got != (image.shape, image.dtype):
        raise ExtensionError(
            f"The effect of the fault {fault} must return an image of shape {image.shape} and type {image.dtype}, got "
            f"{got[0]} and {got[1]}."
        )
    images[effect.sensor] = changed


def cure_of(fault: str) -> tuple[Adaptation, ...]:
    """Return the adaptations of the cheapest cure of a fault."""
    return get_fault(fault).cures[0]


def possible_pairs() -> tuple[tuple[str, str], ...]:
    """Return the pairs of faults that degrade images and do not exclude each other.

    >>> len(possible_pairs())
    9
    """
    exclusive = set(current_system().exclusive)
    return tuple(pair for pair in combinations(effects(), 2) if not {pair, pair[::-1]} & exclusive)


def suite_strengths(other: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return the strength in the suites of every fault that degrades images.

    Args:
        other: strengths in place of them, by fault. They also apply to faults that share a strength.

    >>> suite_strengths({"image_degradation": 0.5})["unneeded_enhancement"]
    0.5
    """
    own: dict[str, float | str] = {
        name: float(get_fault(name).value) if effect.suite is None else effect.suite
        for name, effect in effects().items()
    }
    strengths = {name: strength for name, strength in own.items() if not isinstance(strength, str)}
    for name, strength in (other or {}).items():
        if name not in strengths:
            shared = f"; its strength is that of {own[name]}" if name in own else ""
            raise InvalidInputError(
                f"A strength can be given to {', '.join(strengths)}, not to {name!r}{shared}."
            )
        strengths[name] = _checked(name, strength)
    return {
        name: strengths[strength] if isinstance(strength, str) else strengths[name]
        for name, strength in own.items()
    }


def _checked(fault: str, strength: float) -> float:
    described = get_fault(fault)
    low, high = described.limits or (0.0, effects()[fault].largest)
    whole = isinstance(described.value, int) and described.limits is not None
    if not low < strength <= high or (whole and strength != round(strength)):
        kind = "a whole number" if whole else "a number"
        raise InvalidInputError(
            f"The strength of {fault} must be {kind} greater than {low:g} and at most {high:g}, got {strength:g}."
        )
    return strength


@dataclass(frozen=True, slots=True)
class CurvesPlan:
    """The conditions to measure.

    Attributes:
        networks: of the model; runs begin with the first.
        points: (fault, strength), by fault and strength.
        pairs: of faults.
        strengths: of the suites, by fault.
    """

    networks: tuple[Modality, ...]
    points: tuple[tuple[str, float], ...]
    pairs: tuple[tuple[str, str], ...]
    strengths: Mapping[str, float]

    def before(self, *faults: str, strength: float | None = None) -> Condition:
        """Return the condition with faults, at suite strength by default."""
        return Condition(self.networks[0]).with_faults(
            {fault: self.strengths[fault] if strength is None else strength for fault in faults}
        )

    def after(self, fault: str, strength: float) -> Condition | None:
        """Return the condition after the cure; None if the model lacks the cure's network."""
        cured = self.before(fault, strength=strength).cured_of(fault)
        return cured if cured.modality in self.networks else None

    def conditions(self) -> tuple[Condition, ...]:
        """Return every condition, each once."""
        wanted: list[Condition | None] = [Condition(network) for network in self.networks]
        for fault, strength in self.points:
            wanted += [self.before(fault, strength=strength), self.after(fault, strength)]
        wanted += [self.before(*pair) for pair in self.pairs]
        return tuple(dict.fromkeys(condition for condition in wanted if condition is not None))


def plan_curves(
    card: ModelCard,
    strengths: Mapping[str, float] | None = None,
    grid: Mapping[str, Sequence[float]] | None = None,
) -> CurvesPlan:
    """Plan the measurement of a model with the faults that its first network can see.

    `strengths` replace the suites', by fault. `grid` has further strengths, by fault; None for the catalogue's.
    """
    networks = tuple(sorted(card.networks))
    suite = suite_strengths(strengths)
    seen = [fault for fault, effect in effects().items() if is_seen(effect, networks[0])]
    further = {fault: effects()[fault].strengths for fault in seen} if grid is None else grid
    points = [
        (fault, strength)
        for fault in seen
        for strength in sorted({float(strength) for strength in further.get(fault, ())} | {suite[fault]})
    ]
    pairs = tuple(pair for pair in possible_pairs() if set(pair) <= set(seen))
    return CurvesPlan(networks, tuple(points), pairs, suite)
