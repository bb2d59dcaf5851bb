"""The evaluator: compares what the pipeline says with what was recorded.

It is an observer from outside: it subscribes to the result and to the truth, and knows nothing of the nodes
between them.
"""

from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASS_OF_CARLA_ID, CLASSES
from sunset.errors import DataError
from sunset.interfaces.sensor_msgs.msg import Image
from sunset.interfaces.system_interfaces.msg import FrameEvaluation
from sunset.nodes.images import array_of_labels, stamp_ns
from sunset.ros.context import Context
from sunset.ros.node import Node
from sunset.ros.parameter import Parameter

__all__ = ["Counts", "Evaluator", "compare"]

_COUNT: Final = len(CLASSES)
_SIDE: Final = _COUNT + 1
"""Classes, and one more for what is none."""
_TRUE_CLASS: Final = np.minimum(CLASS_OF_CARLA_ID, _COUNT).astype(np.uint16)
"""Array (256,): recorded id → class index, the last one for an id that is no class."""
_WAITING: Final = 100
"""Frames whose partner has not come that are kept; ten seconds at 10 Hz."""

Vector = npt.NDArray[np.uint32]


class Counts(NamedTuple):
    """Pixels by class index, each (28,) uint32, over the pixels that have a true class."""

    intersection: Vector
    predicted: Vector
    truth: Vector

    @property
    def iou(self) -> float:
        """Mean intersection over union of the classes in prediction or truth (paper, section 4)."""
        union = self.predicted + self.truth - self.intersection
        present = union > 0
        return float((self.intersection[present] / union[present]).mean()) if present.any() else 0.0


def compare(prediction: npt.NDArray[np.uint8], carla_ids: npt.NDArray[np.uint8]) -> Counts:
    """Count the pixels of each class.

    Args:
        prediction: (H, W), class indices from 0 to 27.
        carla_ids: (H, W), the ids as recorded; pixels with an id that is no class are left out.

    >>> counts = compare(np.array([[5, 5]], dtype=np.uint8), np.array([[7, 8]], dtype=np.uint8))
    >>> counts.iou
    0.25
    """
    classes = _TRUE_CLASS[carla_ids] * _SIDE + np.minimum(prediction, _COUNT)
    joint = np.bincount(classes.ravel(), minlength=_SIDE * _SIDE).reshape(_SIDE, _SIDE)[:_COUNT]
    return Counts(
        joint.diagonal().astype(np.uint32),
        joint[:, :_COUNT].sum(axis=0).astype(np.uint32),
        joint.sum(axis=1).astype(np.uint32),
    )


class Evaluator(Node):
    """Publishes `/seg_metrics`: the pipeline's `segmentation` against the truth of the same stamp."""

    def __init__(
        self,
        *,
        context: Context | None = None,
        cli_args: list[str] | None = None,
        parameter_overrides: list[Parameter] | None = None,
    ) -> None:
        super().__init__(
            "evaluator", context=context, cli_args=cli_args, parameter_overrides=parameter_overrides
        )
        self._truths: dict[int, Image] = {}
        self._results: dict[int, Image] = {}
        self._metrics = self.create_publisher(FrameEvaluation, "/seg_metrics", 10)
        self.create_subscription(Image, "/managed_subsystem/segmentation", self._on_result, 10)
        self.create_subscription(Image, "/gt_segmentation", self._on_truth, 10)

    def _on_result(self, message: Image) -> None:
        truth = self._truths.pop(stamp_ns(message.header), None)
        if truth is None:
            _keep(self._results, message)
        else:
            self._evaluate(message, truth)

    def _on_truth(self, message: Image) -> None:
        result = self._results.pop(stamp_ns(message.header), None)
        if result is None:
            _keep(self._truths, message)
        else:
            self._evaluate(result, message)

    def _evaluate(self, result: Image, truth: Image) -> None:
        try:
            labels, expected = array_of_labels(result), array_of_labels(truth)
        except DataError as error:
            self.get_logger().error(f"Dropped a segmentation: {error}", throttle_duration_sec=10.0)
            return
        if labels.shape != expected.shape:
            self.get_logger().error(
                f"Dropped a segmentation of {labels.shape[1]}x{labels.shape[0]} pixels, where the truth has "
                f"{expected.shape[1]}x{expected.shape[0]}.",
                throttle_duration_sec=10.0,
            )
            return
        counts = compare(labels, expected)
        self._metrics.publish(
            FrameEvaluation(
                header=result.header,
                iou=counts.iou,
                intersection=counts.intersection,
                predicted=counts.predicted,
                truth=counts.truth,
            )
        )


def _keep(waiting: dict[int, Image], message: Image) -> None:
    waiting[stamp_ns(message.header)] = message
    if len(waiting) > _WAITING:
        del waiting[next(iter(waiting))]  # not the least stamp: others may be of a far future
