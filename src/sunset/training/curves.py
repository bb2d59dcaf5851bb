"""Curves: what faults that degrade images do to the segmentation, by strength, and what their cures bring back."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.calibration import (
    AUC,
    SAMPLES,
    SHARPNESS,
    Condition,
    CurvesPlan,
    chosen_frames,
    plan_curves,
    roc_auc,
    signal_of,
    window_means,
)
from sunset.data import read_bag
from sunset.errors import DataError
from sunset.metrics import count_classes, image_iou
from sunset.perception import Modality, Model, ModelCard, Segmenter, find_device
from sunset.processes.workers import Progress
from sunset.seeding import generator
from sunset.system import LoadedExtension, load_extension, loaded_extensions
from sunset.training.over_frames import Images, over_frames
from sunset.training.spread import Arrays

BAND: Final = (0.5, 0.75)
"""A fault at suite strength should leave this share of the nominal IoU."""

DROP: Final = 0.03
"""The least that the IoU should fall by."""

SHARPNESS_AUC: Final = 0.99
"""The least AUC of the sharpness, of a fault that blurs."""

CURED: Final = 0.02
"""How far the IoU after the cure may be below that without a fault."""

Values = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Figures:
    """What was measured in one condition.

    Attributes:
        iou: mean over frames of the image's mean IoU over the classes in it.
        entropy: mean over frames.
        auc: chance that the mean entropy of five frames exceeds one without a fault.
        over: share of such means over the model's threshold.
        sharpness: mean over frames of the camera image's.
        sharpness_auc: chance that the mean sharpness of five frames is below one without a fault.
        under: share of such means under the model's threshold.
    """

    iou: float
    entropy: float
    auc: float
    over: float
    sharpness: float
    sharpness_auc: float
    under: float


@dataclass(frozen=True, slots=True)
class Case:
    """One fault at one strength, or several at once, before and after the cure.

    Attributes:
        strengths: by fault.
        suite: whether these are the strengths of the suites.
        before: with the faults.
        after: after the cheapest cure; None where the model cannot, or where there are several faults.
        goal: the IoU without a fault of the network that segments after the cure.
    """

    strengths: Mapping[str, float]
    suite: bool
    before: Figures
    after: Figures | None
    goal: float

    @property
    def name(self) -> str:
        """The faults."""
        return " + ".join(self.strengths)

    def shortfalls(self, nominal: float) -> tuple[str, ...]:
        """Return what is missing for one fault to be of a strength for suites, in words; nothing if it fits.

        Args:
            nominal: the IoU without a fault.
        """
        low, high = BAND
        blurred = SHARPNESS in map(signal_of, self.strengths)
        auc, least = (self.before.sharpness_auc, SHARPNESS_AUC) if blurred else (self.before.auc, AUC)
        share = self.before.iou / nominal if nominal else 0.0
        found = (
            (share < low and not blurred, f"IoU only {share:.0%} of nominal"),
            (share > high and not blurred, f"IoU still {share:.0%} of nominal"),
            (nominal - self.before.iou < DROP, f"IoU falls by less than {DROP}"),
            (auc < least, f"{'sharpness' if blurred else 'entropy'} AUC {auc:.3f}, less than {least}"),
            (
                self.after is not None and self.goal - self.after.iou > CURED,
                f"IoU after the cure more than {CURED} below {self.goal:.3f}",
            ),
        )
        return tuple(text for missing, text in found if missing)


@dataclass(frozen=True, slots=True)
class Curves:
    """Everything that `measure_curves` found.

    Attributes:
        model: its name and version.
        frames: how many were looked at.
        entropy_threshold: the model's.
        sharpness_threshold: the model's.
        nominal: without a fault, by network; the first is the one that flies.
        points: single faults by strength.
        pairs: two faults at once at suite strength.
    """

    model: tuple[str, str]
    frames: int
    entropy_threshold: float
    sharpness_threshold: float
    nominal: Mapping[Modality, Figures]
    points: tuple[Case, ...]
    pairs: tuple[Case, ...]

    @property
    def main(self) -> Figures:
        """The figures without a fault of the network that flies."""
        return next(iter(self.nominal.values()))

    def of(self, fault: str) -> tuple[Case, ...]:
        """Return the points of one fault, by strength."""
        return tuple(case for case in self.points if fault in case.strengths)

    def share(self, figures: Figures) -> float:
        """Return an IoU over the nominal one."""
        return figures.iou / self.main.iou if self.main.iou else 0.0


def look(
    segmenter: Segmenter,
    index: int,
    images: Images,
    conditions: Sequence[Condition],
    extensions: Sequence[LoadedExtension],
) -> Arrays:
    """Segment one frame in every condition; the noise depends on the frame's number only.

    Args:
        segmenter: runs the model.
        index: the frame's number.
        images: of the frame.
        conditions: of which each is one look.
        extensions: that the conditions' faults are of; this process may have to load them.

    Returns:
        (conditions, 3): IoU, entropy and sharpness.
    """
    for extension in extensions:
        load_extension(extension.where, checksum=extension.checksum)
    bgr, depth, truth = images
    rows = []
    for condition in conditions:
        seen = condition.seen(bgr, depth, generator(0, "conditions", index))
        found = segmenter.segment(condition.modality, seen.bgr, seen.depth)
        rows.append((image_iou(count_classes(found.labels, truth)), found.entropy, seen.sharpness))
    return (np.array(rows),)


def measure_curves(
    model: Model,
    bag: Path,
    *,
    every: int = 1,
    strengths: Mapping[str, float] | None = None,
    grid: Mapping[str, Sequence[float]] | None = None,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
) -> Curves:
    """Measure a model on the frames of a bag, in every condition.

    Args:
        model: what segments.
        bag: of at least five frames; those of another size are resampled to the model's.
        every: look at the first five of every 5 · `every` frames only.
        strengths: to take for the suites' instead, by fault.
        grid: further strengths, by fault; those of the catalogue if None.
        jobs: processes; as many as there are processors if None. It has no influence on the result.
        device: what the networks run on, as a `Segmenter` takes it.
        progress: called with frames done and frames in all.

    Raises:
        DataError: the bag is unusable or too short.
        InvalidInputError: a strength or number is out of range, or there is no such device.
        MissingExtraError: the device needs a package that is not installed.
    """
    plan = plan_curves(model.card, strengths, grid)
    size = (model.card.height, model.card.width)
    with read_bag(bag, size=size) as reader:
        count, unlabelled = len(reader), reader.unlabelled
    if unlabelled:
        raise DataError(
            f"The bag {bag} must have labels in every frame here, got none in {unlabelled} of {count}; choose another."
        )
    if count < SAMPLES:
        raise DataError(f"The bag {bag} must have at least {SAMPLES} frames, got {count}.")
    (values,) = over_frames(
        look,
        (plan.conditions(), loaded_extensions()),
        model,
        bag,
        chosen=chosen_frames(count, every),
        device=find_device(device),
        jobs=jobs,
        progress=progress,
    )
    return curves_of(plan, model.card, values, partial(window_means, every=every))


def curves_of(plan: CurvesPlan, card: ModelCard, values: Values, means: Callable[[Values], Values]) -> Curves:
    """Return the figures of what was measured.

    Args:
        plan: whose `conditions` were measured.
        card: of the model.
        values: (frames, conditions, 3) as `look` returns them.
        means: the means over five consecutive frames.
    """
    places = {condition: place for place, condition in enumerate(plan.conditions())}
    nominal = values[:, places[Condition(plan.networks[0])]]
    quiet, sharp = means(nominal[:, 1]), means(nominal[:, 2])

    def figures(condition: Condition) -> Figures:
        iou, entropy, sharpness = values[:, places[condition]].T
        unsure, focus = means(entropy), means(sharpness)
        return Figures(
            iou=float(iou.mean()),
            entropy=float(entropy.mean()),
            auc=roc_auc(quiet, unsure),
            over=float((unsure > card.entropy_threshold).mean()),
            sharpness=float(sharpness.mean()),
            sharpness_auc=roc_auc(focus, sharp),
            under=float((focus < card.sharpness_threshold).mean()),
        )

    def point(fault: str, strength: float) -> Case:
        after = plan.after(fault, strength)
        return Case(
            strengths={fault: strength},
            suite=strength == plan.strengths[fault],
            before=figures(plan.before(fault, strength=strength)),
            after=None if after is None else figures(after),
            goal=networks[after.modality if after else plan.networks[0]].iou,
        )

    networks = {network: figures(Condition(network)) for network in plan.networks}
    main = networks[plan.networks[0]].iou
    return Curves(
        model=(card.name, card.version),
        frames=len(values),
        entropy_threshold=card.entropy_threshold,
        sharpness_threshold=card.sharpness_threshold,
        nominal=networks,
        points=tuple(point(fault, strength) for fault, strength in plan.points),
        pairs=tuple(
            Case(
                {fault: plan.strengths[fault] for fault in pair},
                True,
                figures(plan.before(*pair)),
                None,
                main,
            )
            for pair in plan.pairs
        ),
    )
