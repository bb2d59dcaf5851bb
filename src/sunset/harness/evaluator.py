"""The evaluator: compares the pipeline's results with the recorded labels."""

from typing import Final, Unpack

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASS_OF_CARLA_ID, IGNORED
from sunset.errors import DataError
from sunset.image_messages import labels_of, stamp_ns
from sunset.metrics import count_classes, image_iou
from sunset.system import EVALUATION_TOPIC, RESULT_TOPIC, TRUTH_TOPIC
from sunset.system_interfaces.msg import FrameEvaluation
from sunset_ros.interfaces import deserialize, serialize
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header
from sunset_ros.node import Node, NodeOptions

Labels = npt.NDArray[np.uint8]

_WAITING: Final = 100
"""How many frames without a partner are kept: ten seconds at 10 Hz."""
_NOTHING: Final[Labels] = np.empty((0, 0), np.uint8)


class Evaluator(Node):
    """Publishes `/seg_metrics`: the pipeline's `segmentation` against the truth of the same stamp.

    A truth without a known class is published at once, with the IoU NaN.
    """

    def __init__(self, **options: Unpack[NodeOptions]) -> None:
        super().__init__("evaluator", **options)
        self._truths: dict[int, Image] = {}
        self._results: dict[int, Image] = {}
        self._metrics = self.create_publisher(FrameEvaluation, EVALUATION_TOPIC, 10)
        self.create_subscription(Image, RESULT_TOPIC, self._on_result, 10)
        self.create_subscription(Image, TRUTH_TOPIC, self._on_truth, 10)

    def _on_result(self, message: Image) -> None:
        truth = self._truths.pop(stamp_ns(message.header), None)
        if truth is None:
            _keep(self._results, message)
        else:
            self._evaluate(message, truth)

    def _on_truth(self, message: Image) -> None:
        result = self._results.pop(stamp_ns(message.header), None)
        if _is_unknown(message):
            self._publish(message.header, _compared(_NOTHING, _NOTHING))
        elif result is None:
            _keep(self._truths, message)
        else:
            self._evaluate(result, message)

    def _evaluate(self, result: Image, truth: Image) -> None:
        try:
            labels, expected = labels_of(result), labels_of(truth)
        except DataError as error:
            self.get_logger().error(f"Dropped a segmentation: {error}", throttle_duration_sec=10.0)
            return
        if labels.size != expected.size:
            self.get_logger().error(
                f"Dropped a segmentation of {labels.size[1]}x{labels.size[0]} pixels, where the truth has "
                f"{expected.size[1]}x{expected.size[0]}.",
                throttle_duration_sec=10.0,
            )
            return
        self._publish(result.header, labels.measure(_compared, expected))

    def _publish(self, header: Header, evaluation: bytes) -> None:
        message = deserialize(evaluation, FrameEvaluation)
        message.header = header
        self._metrics.publish(message)


def _compared(labels: Labels, truth: Labels) -> bytes:
    """Return the evaluation of labels, as a serialized message without a header."""
    counts = count_classes(labels, CLASS_OF_CARLA_ID.take(truth))
    return serialize(
        FrameEvaluation(
            iou=image_iou(counts),
            intersection=counts.intersection.astype(np.uint32),
            predicted=counts.predicted.astype(np.uint32),
            truth=counts.truth.astype(np.uint32),
        )
    )


def _is_unknown(truth: Image) -> bool:
    """Return whether no pixel of a truth has a known class."""
    try:
        return not labels_of(truth).measure(_has_class)
    except DataError:
        return False  # the comparison logs the error


def _has_class(truth: Labels) -> bool:
    return bool((CLASS_OF_CARLA_ID.take(truth) != IGNORED).any())


def _keep(waiting: dict[int, Image], message: Image) -> None:
    waiting[stamp_ns(message.header)] = message
    if len(waiting) > _WAITING:
        del waiting[next(iter(waiting))]  # not the smallest stamp: a wrong stamp may lie far in the future
