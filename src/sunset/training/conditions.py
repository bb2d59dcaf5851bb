"""Conditions: what faults and adaptations make of a frame before it is segmented, and which are measured."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from sunset.errors import InvalidInputError
from sunset.faults import (
    BLUR_SIGMA,
    REFERENCE_WIDTH,
    blur,
    degrade_depth,
    degrade_image,
    enhance_image,
    sharpness,
    shift_image,
)
from sunset.perception import Modality, ModelCard
from sunset.system import Adaptation, current_system, get_fault

UNSURE: Final = ("image_degradation", "unneeded_enhancement", "image_shift", "depth_degradation")
"""The faults of F4: the segmentation is unsure."""

BLURRED: Final = "autofocus_needed"
"""The fault of F5."""

_FIELDS: Final = MappingProxyType(
    {
        "image_degradation": "image_degradation",
        "unneeded_enhancement": "enhancement",
        "image_shift": "image_shift",
        "depth_degradation": "depth_degradation",
        BLURRED: "blur_sigma",
    }
)
GRID: Final[Mapping[str, tuple[float, ...]]] = MappingProxyType(
    {
        "image_degradation": (0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.5),
        "unneeded_enhancement": (0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.5),
        "image_shift": (1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 30, 40),
        "depth_degradation": (0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0),
        BLURRED: (0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0),
    }
)
"""The strengths that are measured, by fault; those of the suites are added."""

_LARGEST_BLUR: Final = 64.0


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What is left of a frame when it reaches the segmentation.

    Attributes:
        bgr: (H, W, 3) uint8, as the fusion passes it on.
        depth: (H, W) uint16.
        sharpness: of the camera's image, where the camera measures it: before enhancement and fusion.
    """

    bgr: npt.NDArray[np.uint8]
    depth: npt.NDArray[np.uint16]
    sharpness: float


@dataclass(frozen=True, slots=True)
class Condition:
    """The network that segments, and what happens to its images before; lengths are on images 256 wide.

    Attributes:
        modality: the network.
        image_degradation: strength, of the camera's images.
        blur_sigma: standard deviation of the camera's blur in pixels.
        enhancement: the strength that the enhancement undoes; 0 where its images are not used.
        image_shift: of the colour image against the depth image, in pixels.
        depth_degradation: standard deviation of the depth's noise in metres.
    """

    modality: Modality
    image_degradation: float = 0.0
    blur_sigma: float = 0.0
    enhancement: float = 0.0
    image_shift: float = 0.0
    depth_degradation: float = 0.0

    def with_faults(self, strengths: Mapping[str, float]) -> "Condition":
        """Return the condition with faults of F4 and F5 added, each at a strength."""
        fields: dict[str, Any] = {_FIELDS[fault]: strength for fault, strength in strengths.items()}
        return replace(self, **fields)

    def cured_of(self, fault: str) -> "Condition":
        """Return the condition after the cheapest cure that the catalogue has for a fault."""
        cured = self
        for adaptation in cure_of(fault):
            cured = cured._after(adaptation)
        return cured

    def _after(self, adaptation: Adaptation) -> "Condition":
        match adaptation.parameter, adaptation.value:
            case "topic_camera_input", "rgb_enhanced":
                return replace(self, enhancement=self.image_degradation)
            case "topic_camera_input", "rgb_camera":
                return replace(self, enhancement=0.0)
            case "do_recalibration", _:
                return replace(self, image_shift=0.0)
            case "perform_autofocus", _:
                return replace(self, blur_sigma=0.0)
            case "modality", int(value):
                seen = Modality(value)
                noise = self.depth_degradation if seen.needs_depth else 0.0  # or nobody looks at it
                return replace(self, modality=seen, depth_degradation=noise)
        return self  # activating the enhancement changes nothing before its images are used

    def seen(
        self, bgr: npt.NDArray[np.uint8], depth: npt.NDArray[np.uint16], rng: np.random.Generator
    ) -> Seen:
        """Take a frame through the pipeline, as the nodes do.

        Args:
            bgr: (H, W, 3).
            depth: (H, W).
            rng: draws the depth's noise.
        """
        scale = bgr.shape[1] / REFERENCE_WIDTH
        camera = blur(degrade_image(bgr, self.image_degradation), self.blur_sigma * scale)
        fused = shift_image(enhance_image(camera, self.enhancement), round(self.image_shift * scale))
        noisy = degrade_depth(depth, self.depth_degradation, rng) if self.modality.needs_depth else depth
        return Seen(fused, noisy, sharpness(camera))


def cure_of(fault: str) -> tuple[Adaptation, ...]:
    """Return the adaptations of the cheapest cure of a fault."""
    return get_fault(fault).cures[0]


def possible_pairs() -> tuple[tuple[str, str], ...]:
    """Return the pairs of F4 and F5 faults that can be there together.

    >>> len(possible_pairs())
    9
    """
    names = (*UNSURE, BLURRED)
    exclusive = set(current_system().exclusive)
    pairs = [(one, other) for place, one in enumerate(names) for other in names[place + 1 :]]
    return tuple(pair for pair in pairs if not {pair, pair[::-1]} & exclusive)


def suite_strengths(other: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return the strength of every F4 and F5 fault in the suites.

    Args:
        other: strengths to take instead, by fault. That of the enhancement is the image degradation's.

    Raises:
        InvalidInputError: a name is no such fault, or its strength is out of range.

    >>> suite_strengths({"image_degradation": 0.5})["unneeded_enhancement"]
    0.5
    """
    strengths = {name: float(get_fault(name).value) for name in UNSURE if get_fault(name).limits is not None}
    strengths[BLURRED] = BLUR_SIGMA
    for name, strength in (other or {}).items():
        if name not in strengths:
            raise InvalidInputError(
                f"A strength can be given to {', '.join(strengths)}, not to {name!r}; the enhancement's is that "
                "of image_degradation."
            )
        strengths[name] = _checked(name, strength)
    strengths["unneeded_enhancement"] = strengths["image_degradation"]
    return {name: strengths[name] for name in _FIELDS}


def _checked(fault: str, strength: float) -> float:
    low, high = get_fault(fault).limits or (0.0, _LARGEST_BLUR)
    whole = isinstance(get_fault(fault).value, int) and fault != BLURRED
    if not low < strength <= high or (whole and strength != round(strength)):
        kind = "a whole number" if whole else "a number"
        raise InvalidInputError(
            f"The strength of {fault} must be {kind} greater than {low:g} and at most {high:g}, got {strength:g}."
        )
    return strength


@dataclass(frozen=True, slots=True)
class CurvesPlan:
    """Which conditions are measured.

    Attributes:
        networks: of the model; the first flies.
        points: (fault, strength), by fault and strength.
        pairs: of faults.
        strengths: of the suites, by fault.
    """

    networks: tuple[Modality, ...]
    points: tuple[tuple[str, float], ...]
    pairs: tuple[tuple[str, str], ...]
    strengths: Mapping[str, float]

    def before(self, *faults: str, strength: float | None = None) -> Condition:
        """Return the condition with faults, at suite strength unless a strength is given."""
        return Condition(self.networks[0]).with_faults(
            {fault: self.strengths[fault] if strength is None else strength for fault in faults}
        )

    def after(self, fault: str, strength: float) -> Condition | None:
        """Return the condition after the cure, or None if the model lacks the network that it needs."""
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
    grid: Mapping[str, Sequence[float]] = GRID,
) -> CurvesPlan:
    """Plan what is measured of a model: the faults that its main network can see.

    Args:
        card: the model's.
        strengths: to take for the suites' instead, by fault.
        grid: further strengths, by fault.

    Raises:
        InvalidInputError: a strength is out of range.
    """
    networks = tuple(sorted(card.networks))
    suite = suite_strengths(strengths)
    main = networks[0]
    seen = [
        fault
        for fault in (*UNSURE, BLURRED)
        if (main.needs_depth if fault == "depth_degradation" else main.needs_rgb)
    ]
    points = [
        (fault, strength)
        for fault in seen
        for strength in sorted({float(strength) for strength in grid.get(fault, ())} | {suite[fault]})
    ]
    pairs = tuple(pair for pair in possible_pairs() if set(pair) <= set(seen))
    return CurvesPlan(networks, tuple(points), pairs, suite)
