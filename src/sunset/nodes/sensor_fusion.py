"""The sensor fusion: matches colour and depth images by their stamps."""

from typing import Final, Generic, TypeVar

from sunset.errors import DataError
from sunset.faults import REFERENCE_WIDTH, misalign_image
from sunset.image_messages import bgr_of, image_of_bgr, stamp_ns
from sunset.nodes.base import AdaptiveNode
from sunset.nodes.parameters import FaultParameter, NodeParameter, TopicParameter, action
from sunset.system_interfaces.msg import FusionType, SensorFusion
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header
from sunset_ros.lifecycle import LifecycleState, TransitionCallbackReturn

SET_BACK_NS: Final = 10**9
"""An item older than the newest by more than this is not late: time was set back, or the newest had a false stamp."""

_WAITING: Final = 10
"""Images of one sensor that wait for the other's; one second at 10 Hz."""

T = TypeVar("T")


class PairMatcher(Generic[T]):
    """Finds pairs of items whose stamps differ by at most a tolerance.

    Both items of a pair are newer than both items of the pair before. Items may arrive late and out of order. An item
    more than a second older than the last pair means that time was set back: all other items are forgotten.

    Args:
        size: the number of items of each stream that wait for their partner; the first items are forgotten first.

    >>> pairs = PairMatcher()
    >>> pairs.add_left(0, "rgb", tolerance=10) is None
    True
    >>> pairs.add_right(4, "depth", tolerance=10)
    ('rgb', 'depth')
    """

    def __init__(self, size: int = 10) -> None:
        self._size = size
        self._left: _Stream[T] = _Stream()
        self._right: _Stream[T] = _Stream()

    def add_left(self, stamp: int, item: T, *, tolerance: int) -> tuple[T, T] | None:
        """Take an item of the first stream, and return the pair that it completes, or None.

        Its stamp and the tolerance are in nanoseconds.
        """
        partner = self._find_partner(stamp, item, tolerance, self._left, self._right)
        return None if partner is None else (item, partner)

    def add_right(self, stamp: int, item: T, *, tolerance: int) -> tuple[T, T] | None:
        """Take an item of the second stream, as `add_left`."""
        partner = self._find_partner(stamp, item, tolerance, self._right, self._left)
        return None if partner is None else (partner, item)

    def clear_left(self) -> None:
        """Forget the waiting items of the first stream."""
        self._left.waiting.clear()

    def reset(self) -> None:
        """Forget everything."""
        self._left.forget()
        self._right.forget()

    def _find_partner(
        self, stamp: int, item: T, tolerance: int, own: "_Stream[T]", others: "_Stream[T]"
    ) -> T | None:
        if own.last is not None and stamp <= own.last:
            if own.last - stamp <= SET_BACK_NS:
                return None  # it is late
            self.reset()
        near = [other for other in others.waiting if abs(other - stamp) <= tolerance]
        if not near:
            own.waiting[stamp] = item
            if len(own.waiting) > self._size:
                del own.waiting[next(iter(own.waiting))]
            return None
        closest = min(near, key=lambda other: (abs(other - stamp), -other))  # of two as close, the newer
        partner = others.waiting[closest]
        own.forget_until(stamp)
        others.forget_until(closest)
        return partner


class _Stream(Generic[T]):
    """Items of a stream that wait for their partner, by stamp, and the stamp of the last matched item."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        self.waiting: dict[int, T] = {}
        self.last: int | None = None

    def forget_until(self, last: int) -> None:
        self.last = last
        self.waiting = {stamp: item for stamp, item in self.waiting.items() if stamp > last}


class Fusion(AdaptiveNode):
    """Publishes `sensors_fused` from the colour images that `topic_camera_input` names and `depth_camera`.

    It publishes a message for each matched pair, in the order of their stamps unless time was set back. With the
    modality rgb or depth it publishes that sensor's images only. Messages on `topic_camera_input` that are not colour
    images are dropped, and logged.
    """

    node_name = "sensor_fusion"

    topic_camera_input = TopicParameter("rgb_camera", "topic of the colour images")
    modality = NodeParameter(
        int(FusionType.FUSION),
        "what is published: 0 both images, 1 the colour image, 2 the depth image",
        minimum=0,
        maximum=2,
    )
    delta_t_threshold = NodeParameter(
        0.01, "greatest difference in seconds of the stamps of a pair", minimum=0.0, maximum=10.0
    )
    image_shift = FaultParameter(
        0,
        f"internal fault: pixels (of {REFERENCE_WIDTH} in a row) by which the colour image is misaligned",
        minimum=0,
        maximum=1920,
        ends_with="do_recalibration",
    )
    sync_issue = FaultParameter(
        False, "internal fault: no pairs come out, until a restart", cured_by_restart=True
    )
    memory_leakage = FaultParameter(False, "internal fault: no pairs come out, until a redeploy")

    def set_up(self) -> None:
        """Declare the inputs and the output."""
        self._pairs: PairMatcher[Image] = PairMatcher(_WAITING)
        self._newest = -1
        self._topic = ""
        self._fused = self.create_lifecycle_publisher(SensorFusion, "sensors_fused", 10)
        self.create_switchable_subscription(Image, "topic_camera_input", self._on_rgb)
        self.create_active_subscription(Image, "depth_camera", self._on_depth)

    @action
    def do_recalibration(self) -> None:
        """Adaptation: align the cameras again, which ends image_shift."""
        self.write_parameter("image_shift", 0)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget earlier images."""
        self._pairs.reset()
        self._newest = -1
        return super().on_activate(state)

    def _on_rgb(self, message: Image) -> None:
        self._forget_other_topic()
        try:
            bgr_of(message)
        except DataError as error:
            self.get_logger().error(f"Dropped an image on {self._topic}: {error}", throttle_duration_sec=10.0)
            return
        if self.modality == FusionType.RGB:
            self._publish(message.header, rgb=message)
        elif self.modality == FusionType.FUSION:
            pair = self._pairs.add_left(stamp_ns(message.header), message, tolerance=self._tolerance)
            if pair:
                self._publish(pair[0].header, rgb=pair[0], depth=pair[1])

    def _on_depth(self, message: Image) -> None:
        self._forget_other_topic()
        if self.modality == FusionType.DEPTH:
            self._publish(message.header, depth=message)
        elif self.modality == FusionType.FUSION:
            pair = self._pairs.add_right(stamp_ns(message.header), message, tolerance=self._tolerance)
            if pair:
                self._publish(pair[0].header, rgb=pair[0], depth=pair[1])

    @property
    def _tolerance(self) -> int:
        return round(self.delta_t_threshold * 1e9)

    def _forget_other_topic(self) -> None:
        """Drop waiting colour images of the topic before."""
        if self._topic != self.topic_camera_input:
            self._topic = self.topic_camera_input
            self._pairs.clear_left()

    def _publish(self, header: Header, *, rgb: Image | None = None, depth: Image | None = None) -> None:
        """Publish the given images, unless they are late."""
        stamp = stamp_ns(header)
        # a pair has the colour image's stamp, which may be the tolerance older than the depth image's
        is_late = 0 <= self._newest - stamp <= SET_BACK_NS + self._tolerance
        if self.sync_issue or self.memory_leakage or is_late:
            return
        self._newest = stamp
        self._fused.publish(
            SensorFusion(
                header=header,
                rgb=Image() if rgb is None else self._shifted(rgb),
                depth=Image() if depth is None else depth,
                modality=FusionType(fusion_type=self.modality),
            )
        )

    def _shifted(self, rgb: Image) -> Image:
        if not self.image_shift:
            return rgb
        return image_of_bgr(rgb.header, bgr_of(rgb).then(misalign_image, self.image_shift))
