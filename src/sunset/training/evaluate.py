"""Measuring an exported model, through the same inference that runs use."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from sunset.metrics import ClassCounts, class_iou, count_classes, image_iou
from sunset.perception import Modality, Model, Segmenter
from sunset.processes.workers import Progress
from sunset.training.batches import FrameSet
from sunset.training.over_frames import Images, over_frames
from sunset.training.spread import Arrays


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What a network made of a set of frames: (N,) per image the IoU, the mean over classes present, and the entropy.

    Counts are of all images added up.
    """

    iou: npt.NDArray[np.float64]
    entropy: npt.NDArray[np.float64]
    counts: ClassCounts

    def class_iou(self) -> dict[int, float]:
        """Return the IoU of every class present, over all images, by class index."""
        iou, present = class_iou(self.counts)
        return {int(index): float(iou[index]) for index in np.flatnonzero(present)}


def measure(
    model: Model,
    frames: FrameSet,
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
    kept: Path | None = None,
) -> dict[Modality, Measured]:
    """Segment frames with all networks of a model, and compare with the truth.

    `jobs`, `progress` and `kept` are as `over_frames` takes them.
    """
    modalities = tuple(model.card.networks)
    iou, entropy, counts = over_frames(
        _look, (modalities,), model, frames, jobs=jobs, progress=progress, kept=kept
    )
    totals = counts.sum(axis=0)
    return {
        modality: Measured(iou[:, place], entropy[:, place], ClassCounts(*totals[place]))
        for place, modality in enumerate(modalities)
    }


def _look(segmenter: Segmenter, _: int, images: Images, modalities: tuple[Modality, ...]) -> Arrays:
    """Return by network the image's IoU (M,), its entropy (M,), and the counts (M, 3, 28)."""
    bgr, depth, truth = images
    results = [segmenter.segment(modality, bgr, depth) for modality in modalities]
    counts = [count_classes(result.labels, truth) for result in results]
    return (
        np.array([image_iou(each) for each in counts]),
        np.array([result.entropy for result in results]),
        np.array([(each.intersection, each.predicted, each.truth) for each in counts]),
    )
