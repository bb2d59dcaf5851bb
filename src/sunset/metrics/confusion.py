"""Intersection over union: counts first, one division at the end.

`image_iou` is the paper's figure (section 4): of one image, the mean over the classes that are in it.
Averaged over images it is not the data set's mIoU, which `accumulated_iou` makes of the summed counts.
"""

from dataclasses import dataclass
from math import nan
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.metrics.timeline import NUMBER_OF_CLASSES, Counts

_EXACT: Final = 1 << 24
"""So many pixels are counted exactly, for the counts are of `float32`."""


@dataclass(frozen=True, slots=True, eq=False)
class ClassCounts:
    """Pixels of each class in one image, or in several that were added up.

    Attributes:
        intersection: (28,) in the prediction and in the truth.
        predicted: (28,) in the prediction, where the truth is a class.
        truth: (28,) in the truth.
    """

    intersection: Counts
    predicted: Counts
    truth: Counts


def count_classes(prediction: npt.NDArray[np.uint8], truth: npt.NDArray[np.uint8]) -> ClassCounts:
    """Count the pixels of each class in a prediction and its truth.

    Args:
        prediction: (H, W) class indices 0…27; anything else is right nowhere and counts for no class.
        truth: (H, W) class indices 0…27; where it is anything else, the pixel is left out.

    Raises:
        ValueError: the shapes differ.

    >>> counts = count_classes(np.array([[0, 1]], np.uint8), np.array([[0, 255]], np.uint8))
    >>> counts.intersection[:2].tolist(), counts.predicted[:2].tolist(), counts.truth[:2].tolist()
    ([1, 0], [1, 0], [1, 0])
    """
    if prediction.shape != truth.shape:
        raise ValueError(f"The prediction must have the truth's shape {truth.shape}, got {prediction.shape}.")
    import cv2  # noqa: PLC0415  whoever reads counts only is spared its import

    side = NUMBER_OF_CLASSES + 1  # one more for what is not a class
    pairs = _classes(truth).astype(np.uint16)
    pairs *= side
    pairs += _classes(prediction).astype(np.uint8, copy=False)
    pairs = pairs.reshape(1, -1)
    confusion = np.zeros(side * side, np.int64)
    for start in range(0, pairs.size, _EXACT):
        part = pairs[:, start : start + _EXACT]
        counts = cv2.calcHist([part], [0], None, [side * side], [0, side * side])
        confusion += counts.ravel().astype(np.int64)
    known = confusion.reshape(side, side)[:NUMBER_OF_CLASSES, :]
    return ClassCounts(
        intersection=np.diagonal(known).copy(),
        predicted=known.sum(axis=0)[:NUMBER_OF_CLASSES],
        truth=known.sum(axis=1),
    )


def _classes(indices: npt.NDArray[np.integer]) -> npt.NDArray[np.integer]:
    """Return class indices, where what is not one is one more than the last."""
    known = np.minimum(indices, NUMBER_OF_CLASSES)
    return known if known.dtype.kind == "u" else np.where(known < 0, NUMBER_OF_CLASSES, known)


def class_iou(counts: ClassCounts) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Return each class's IoU, 0 where it is absent, and which classes are present.

    Returns:
        (28,) IoU in [0, 1], and (28,) whether the class is in the prediction or in the truth.
    """
    union = counts.predicted + counts.truth - counts.intersection
    present = union > 0
    return counts.intersection / np.maximum(union, 1), present


def image_iou(counts: ClassCounts) -> float:
    """Return the mean IoU over the classes that are in the prediction or in the truth.

    It is NaN where there is none at all, which is an image without truth.

    >>> image_iou(count_classes(np.array([[0, 0, 1]], np.uint8), np.array([[0, 2, 1]], np.uint8)))
    0.5
    """
    iou, present = class_iou(counts)
    return float(iou[present].mean()) if present.any() else nan


def accumulated_iou(intersection: Counts, predicted: Counts, truth: Counts) -> float | None:
    """Return the data set's mIoU: the counts of all images added up, then the mean over classes present.

    Args:
        intersection: (N, 28), one row an image.
        predicted: (N, 28).
        truth: (N, 28).

    Returns:
        The mIoU in [0, 1], or None where no class is present at all.
    """
    total = ClassCounts(intersection.sum(axis=0), predicted.sum(axis=0), truth.sum(axis=0))
    iou, present = class_iou(total)
    return float(iou[present].mean()) if present.any() else None
