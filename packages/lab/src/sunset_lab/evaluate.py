"""Measuring the IoU of a model, by the inference that runs use."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Unpack

import numpy as np
import numpy.typing as npt

from sunset.metrics import ClassCounts, class_iou, count_classes
from sunset.metrics.timeline import Counts
from sunset.perception import Modality, Model, Segmenter
from sunset_lab.batches import FrameSet, Images
from sunset_lab.over_frames import Arrays, LookOptions, over_frames


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """Counts (N, networks, 3, 28) of each frame's pixels by class.

    The three are the pixels of the class in both prediction and truth, in the prediction, and in the truth.
    """

    counts: Counts

    def __len__(self) -> int:
        return len(self.counts)

    def per_image(self) -> npt.NDArray[np.float64]:
        """Return the mean over frames of the mean IoU over the classes in the frame, by network."""
        iou, present = class_iou(ClassCounts(*np.moveaxis(self.counts, -2, 0)))
        means = iou.sum(axis=2) / np.maximum(present.sum(axis=2), 1)  # the IoU of an absent class is 0
        result: npt.NDArray[np.float64] = means.mean(axis=0)
        return result

    def by_class(self) -> npt.NDArray[np.float64]:
        """Return the IoU of every class over all frames (networks, 28); NaN where the class is absent."""
        iou, present = class_iou(ClassCounts(*np.moveaxis(self.counts.sum(axis=0), -2, 0)))
        return np.where(present, iou, np.nan)

    def dataset(self) -> npt.NDArray[np.float64]:
        """Return the mIoU of all frames together, by network."""
        mean: npt.NDArray[np.float64] = np.nanmean(self.by_class(), axis=1)
        return mean

    def shares(self) -> npt.NDArray[np.float64]:
        """Return every class's share of the pixels (28,)."""
        truth = self.counts[:, 0, 2].sum(axis=0)
        shares: npt.NDArray[np.float64] = truth / max(int(truth.sum()), 1)
        return shares


def measure(
    model: Model, frames: FrameSet | Path, chosen: Sequence[int] | None = None, **options: Unpack[LookOptions]
) -> Measured:
    """Segment frames with all networks of a model, and compare the labels with the truth; as `over_frames`."""
    modalities = tuple(sorted(model.card.networks))
    (counts,) = over_frames(_count, (modalities,), model, frames, chosen, **options)
    return Measured(counts)


def _count(segmenter: Segmenter, _: int, images: Images, modalities: tuple[Modality, ...]) -> Arrays:
    """Return a frame's counts (networks, 3, 28)."""
    bgr, depth, truth = images
    counts = [count_classes(segmenter.segment(each, bgr, depth).labels, truth) for each in modalities]
    return (np.array([(each.intersection, each.predicted, each.truth) for each in counts]),)
