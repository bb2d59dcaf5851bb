"""Intersection over union, from counts of pixels, and the entropy of a network.

`image_iou` is the paper's figure (section 4): the mean over the classes in an image. Its mean over images is not the
mIoU of a data set, which `accumulated_iou` returns from summed counts.
"""

from dataclasses import dataclass
from math import nan
from typing import Final

import numpy as np
import numpy.typing as npt

from sunset.metrics.timeline import NUMBER_OF_CLASSES, Counts

_EXACT: Final = 1 << 24  # pixels that can be counted exactly with `float32`


@dataclass(frozen=True, slots=True, eq=False)
class ClassCounts:
    """Pixels of each class (28,) in an image, or in several images together.

    Attributes:
        intersection: in the prediction and in the truth.
        predicted: in the prediction, where the truth is a class.
    """

    intersection: Counts
    predicted: Counts
    truth: Counts


def count_classes(prediction: npt.NDArray[np.uint8], truth: npt.NDArray[np.uint8]) -> ClassCounts:
    """Count the pixels of each class in a prediction and its truth.

    Args:
        prediction: (H, W) class indices 0…27; any other value is wrong and counts for no class.
        truth: (H, W) class indices 0…27; pixels with any other value are left out.

    Raises:
        ValueError: the shapes differ.

    >>> counts = count_classes(np.array([[0, 1]], np.uint8), np.array([[0, 255]], np.uint8))
    >>> counts.intersection[:2].tolist(), counts.predicted[:2].tolist(), counts.truth[:2].tolist()
    ([1, 0], [1, 0], [1, 0])
    """
    if prediction.shape != truth.shape:
        raise ValueError(f"The prediction must have the truth's shape {truth.shape}, got {prediction.shape}.")
    import cv2  # noqa: PLC0415  a slow import, which reading counts does not need

    side = NUMBER_OF_CLASSES + 1  # the last is for pixels without a class
    pairs = np.minimum(truth, NUMBER_OF_CLASSES).astype(np.uint16)
    pairs *= side
    pairs += np.minimum(prediction, NUMBER_OF_CLASSES)
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


def class_iou(counts: ClassCounts) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
    """Return each class's IoU (28,) in [0, 1], 0 where it is absent, and whether it is present in either (28,)."""
    union = counts.predicted + counts.truth - counts.intersection
    present = union > 0
    return counts.intersection / np.maximum(union, 1), present


def image_iou(counts: ClassCounts) -> float:
    """Return the mean IoU over the classes in the prediction or the truth; NaN for an image without truth.

    >>> image_iou(count_classes(np.array([[0, 0, 1]], np.uint8), np.array([[0, 2, 1]], np.uint8)))
    0.5
    """
    iou, present = class_iou(counts)
    return float(iou[present].mean()) if present.any() else nan


def accumulated_iou(intersection: Counts, predicted: Counts, truth: Counts) -> float | None:
    """Return the mIoU of a data set, in [0, 1], from the counts (N, 28) of N images; None without a class."""
    total = ClassCounts(intersection.sum(axis=0), predicted.sum(axis=0), truth.sum(axis=0))
    iou, present = class_iou(total)
    return float(iou[present].mean()) if present.any() else None


def normalised_entropy(logits: npt.NDArray[np.floating], *, temperature: float = 1.0) -> float:
    """Return the mean over pixels of the Shannon entropy of the softmax, divided by its maximum.

    The paper (section 3.3) uses the mean entropy of the logits. Divided by the logarithm of the number of classes, it
    is 0 if the network is sure everywhere, and 1 if all classes are equally likely.

    Args:
        logits: (C, H, W), finite, at least two classes C and one pixel.
        temperature: the logits are divided by it; greater than 0.

    Raises:
        ValueError: the shape or the temperature is invalid.

    >>> normalised_entropy(np.zeros((28, 2, 3)))
    1.0
    """
    if logits.ndim != 3 or logits.shape[0] < 2 or logits.size == 0:  # noqa: PLR2004  shape (C >= 2, H, W)
        raise ValueError(f"Logits must have shape (C, H, W) with C of 2 or more, got {logits.shape}.")
    if not temperature > 0:
        raise ValueError(f"The temperature must be greater than 0, got {temperature!r}.")
    scaled = logits.astype(np.float64) / temperature
    scaled -= scaled.max(axis=0)
    weights = np.exp(scaled)
    total = weights.sum(axis=0)
    entropy = np.log(total) - (weights * scaled).sum(axis=0) / total
    return float(np.clip(entropy.mean() / np.log(len(logits)), 0.0, 1.0))
