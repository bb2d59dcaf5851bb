"""The sensor fusion: matches colour and depth images by their stamps."""

from typing import Final

from sunset.errors import DataError
from sunset.faults import REFERENCE_WIDTH, misalign_image
from sunset.nodes.base import AdaptiveNode
from sunset.nodes.images import array_of_bgr, image_of_bgr, stamp_ns
from sunset.nodes.pairing import SET_BACK_NS, PairMatcher
from sunset.nodes.parameters import FaultParameter, NodeParameter, TopicParameter, action
from sunset.system_interfaces.msg import FusionType, SensorFusion
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header
from sunset_ros.lifecycle import LifecycleState, TransitionCallbackReturn

_WAITING: Final = 10
"""Images of one sensor that wait for the other's; one second at 10 Hz."""


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
        self._pairs: PairMatcher[Image, Image] = PairMatcher(_WAITING)
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
            array_of_bgr(message)
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
        return image_of_bgr(rgb.header, misalign_image(array_of_bgr(rgb), self.image_shift))
