"""Curves: IoU, entropy and sharpness with each fault that degrades images, by strength, and after its cure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Unpack

import numpy as np

from sunset.calibration import (
    AUC,
    SAMPLES,
    SHARPNESS,
    Condition,
    CurvesPlan,
    Values,
    chosen_frames,
    plan_curves,
    roc_auc,
    signal_of,
    window_means,
)
from sunset.data import read_bag
from sunset.errors import DataError
from sunset.metrics import count_classes, image_iou
from sunset.perception import Modality, Model, ModelCard, Segmenter
from sunset.system import LoadedExtension, load_extension, loaded_extensions
from sunset_lab.frames import Images
from sunset_lab.measuring import Arrays, LookOptions, over_frames
from sunset_ros.seeding import generator

BAND: Final = (0.5, 0.75)
"""A fault at suite strength should leave this share of the nominal IoU."""

DROP: Final = 0.03
"""The least decrease of the IoU."""

SHARPNESS_AUC: Final = 0.99
"""The least AUC of the sharpness, for a fault that blurs."""

CURED: Final = 0.02
"""The most that the IoU after the cure may be below the IoU without a fault."""


@dataclass(frozen=True, slots=True)
class Figures:
    """The measurements in one condition. A window is five consecutive frames."""

    iou: float  # mean over frames of the image's mean IoU over the classes in it
    entropy: float  # mean over frames
    auc: float  # chance that a window's mean entropy exceeds the entropy of a window without a fault
    over: float  # share of windows over the model's threshold
    sharpness: float  # of the camera's image, mean over frames
    # Chance that a window's mean sharpness is below the sharpness of a window without a fault.
    sharpness_auc: float
    under: float  # share of windows under the model's threshold


@dataclass(frozen=True, slots=True)
class Case:
    """A fault at a strength, or several faults at once, before and after the cure."""

    strengths: Mapping[str, float]  # by fault
    suite: bool  # whether these are the strengths of the suites
    before: Figures  # with the faults
    # After the cheapest cure; None where the model lacks its network, and for several faults.
    after: Figures | None
    goal: float  # the IoU without a fault of the network that segments after the cure

    @property
    def name(self) -> str:
        """The names of the faults."""
        return " + ".join(self.strengths)

    def shortfalls(self, nominal: float) -> tuple[str, ...]:
        """Return the reasons why the strength does not fit the suites; `nominal` is the IoU without a fault."""
        low, high = BAND
        blurred = SHARPNESS in map(signal_of, self.strengths)
        auc, least = (self.before.sharpness_auc, SHARPNESS_AUC) if blurred else (self.before.auc, AUC)
        share = self.before.iou / nominal if nominal else 0.0
        checks = (
            (share < low and not blurred, f"IoU only {share:.0%} of nominal"),
            (share > high and not blurred, f"IoU still {share:.0%} of nominal"),
            (nominal - self.before.iou < DROP, f"IoU falls by less than {DROP}"),
            (auc < least, f"{'sharpness' if blurred else 'entropy'} AUC {auc:.3f}, less than {least}"),
            (
                self.after is not None and self.goal - self.after.iou > CURED,
                f"IoU after the cure more than {CURED} below {self.goal:.3f}",
            ),
        )
        return tuple(text for missing, text in checks if missing)


@dataclass(frozen=True, slots=True)
class Curves:
    """The results of `measure_curves`."""

    model: tuple[str, str]  # its name and version
    frames: int  # their number
    entropy_threshold: float
    sharpness_threshold: float
    nominal: Mapping[Modality, Figures]  # without a fault, by network; runs begin with the first
    points: tuple[Case, ...]  # single faults by strength
    pairs: tuple[Case, ...]  # two faults at once at suite strength

    @property
    def main(self) -> Figures:
        """The figures of the first network without a fault."""
        return next(iter(self.nominal.values()))

    def of(self, fault: str) -> tuple[Case, ...]:
        """Return the points of a fault, by strength."""
        return tuple(case for case in self.points if fault in case.strengths)

    def share(self, figures: Figures) -> float:
        """Return an IoU over the nominal IoU."""
        return figures.iou / self.main.iou if self.main.iou else 0.0


def look(
    segmenter: Segmenter,
    index: int,
    images: Images,
    conditions: Sequence[Condition],
    extensions: Sequence[LoadedExtension],
) -> Arrays:
    """Return IoU, entropy and sharpness of a frame in every condition, (conditions, 3).

    The noise of faults depends on the frame's number only. The extensions are loaded if this process lacks them.
    """
    for extension in extensions:
        load_extension(extension.where, checksum=extension.checksum)
    bgr, depth, truth = images
    rows = []
    for condition in conditions:
        seen = condition.seen(bgr, depth, generator(0, "conditions", index))
        result = segmenter.segment(condition.modality, seen.bgr, seen.depth)
        rows.append((image_iou(count_classes(result.labels, truth)), result.entropy, seen.sharpness))
    return (np.array(rows),)


def measure_curves(
    model: Model,
    bag: Path,
    *,
    every: int = 1,
    strengths: Mapping[str, float] | None = None,
    grid: Mapping[str, Sequence[float]] | None = None,
    **options: Unpack[LookOptions],
) -> Curves:
    """Measure a model on the frames of a bag, at least five and all with labels, in every condition.

    The arguments are as in `sunset.measure_curves`; `grid` has further strengths by fault, or None for the catalogue's.
    """
    plan = plan_curves(model.card, strengths, grid)
    chosen = chosen_frames(_count(bag, model.card), every)
    (values,) = over_frames(look, (plan.conditions(), loaded_extensions()), model, bag, chosen, **options)
    return curves_of(plan, model.card, values, every)


def _count(bag: Path, card: ModelCard) -> int:
    """Return the number of frames in a bag that curves can be measured on."""
    with read_bag(bag, size=(card.height, card.width)) as reader:
        count, unlabelled = len(reader), reader.unlabelled
    if unlabelled:
        raise DataError(
            f"The bag {bag} must have labels in every frame here, got none in {unlabelled} of {count}; choose another."
        )
    if count < SAMPLES:
        raise DataError(f"The bag {bag} must have at least {SAMPLES} frames, got {count}.")
    return count


def curves_of(plan: CurvesPlan, card: ModelCard, values: Values, every: int = 1) -> Curves:
    """Return the curves of measured values (frames, conditions, 3), as `look` returns them for `plan.conditions()`."""
    places = {condition: place for place, condition in enumerate(plan.conditions())}
    nominal = Condition(plan.networks[0])

    def figures(condition: Condition) -> Figures:
        return _figures(card, values[:, places[condition]], values[:, places[nominal]], every)

    networks = {network: figures(Condition(network)) for network in plan.networks}

    def case(strengths: Mapping[str, float], after: Condition | None = None) -> Case:
        return Case(
            strengths,
            suite=all(plan.strengths[fault] == strength for fault, strength in strengths.items()),
            before=figures(nominal.with_faults(strengths)),
            after=None if after is None else figures(after),
            goal=networks[(after or nominal).modality].iou,
        )

    return Curves(
        model=(card.name, card.version),
        frames=len(values),
        entropy_threshold=card.entropy_threshold,
        sharpness_threshold=card.sharpness_threshold,
        nominal=networks,
        points=tuple(case({fault: strength}, plan.after(fault, strength)) for fault, strength in plan.points),
        pairs=tuple(case({fault: plan.strengths[fault] for fault in pair}) for pair in plan.pairs),
    )


def _figures(card: ModelCard, values: Values, nominal: Values, every: int) -> Figures:
    """Return the figures of the values (frames, 3) in a condition, and without a fault."""
    iou, entropy, sharpness = values.T
    quiet, sharp = window_means(nominal[:, 1], every), window_means(nominal[:, 2], every)
    unsure, focus = window_means(entropy, every), window_means(sharpness, every)
    return Figures(
        iou=float(iou.mean()),
        entropy=float(entropy.mean()),
        auc=roc_auc(quiet, unsure),
        over=float((unsure > card.entropy_threshold).mean()),
        sharpness=float(sharpness.mean()),
        sharpness_auc=roc_auc(focus, sharp),
        under=float((focus < card.sharpness_threshold).mean()),
    )
