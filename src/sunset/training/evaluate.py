"""Measuring an exported model, through the same inference that runs use."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASSES
from sunset.metrics import ClassCounts, class_iou, count_classes, image_iou
from sunset.perception import Modality, Segmenter
from sunset.training.batches import FrameSet

__all__ = ["Measured", "measure", "roc_auc"]


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What a network made of a set of frames.

    Attributes:
        iou: (N,) per image, the mean over classes present.
        entropy: (N,) per image.
        counts: of all images added up.
    """

    iou: npt.NDArray[np.float64]
    entropy: npt.NDArray[np.float64]
    counts: ClassCounts

    def class_iou(self) -> dict[int, float]:
        """Return the IoU of every class present, over all images, by class index."""
        iou, present = class_iou(self.counts)
        return {int(index): float(iou[index]) for index in np.flatnonzero(present)}


def measure(segmenter: Segmenter, modality: Modality, frames: FrameSet) -> Measured:
    """Segment frames and compare with the truth.

    Args:
        segmenter: runs the model.
        modality: which network.
        frames: with their truth.
    """
    ious, entropies, totals = [], [], np.zeros((3, len(CLASSES)), dtype=np.int64)
    for index in range(len(frames)):
        result = segmenter.segment(modality, np.asarray(frames.bgr[index]), np.asarray(frames.depth[index]))
        counts = count_classes(result.labels, np.asarray(frames.labels[index]))
        ious.append(image_iou(counts))
        entropies.append(result.entropy)
        totals += np.stack([counts.intersection, counts.predicted, counts.truth])
    return Measured(np.array(ious), np.array(entropies), ClassCounts(totals[0], totals[1], totals[2]))


def roc_auc(negative: npt.NDArray[np.float64], positive: npt.NDArray[np.float64]) -> float:
    """Return the chance that a positive exceeds a negative, ties counting half.

    >>> roc_auc(np.array([1.0, 2.0]), np.array([2.0, 3.0]))
    0.875
    """
    difference = positive[:, None] - negative[None, :]
    return float((difference > 0).mean() + 0.5 * (difference == 0).mean())
