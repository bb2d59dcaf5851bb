"""The camera: publishes the recorded colour images, and reports its faults."""

from collections import deque

from sunset.faults import defocus_image, degrade_image, sharpness
from sunset.image_messages import bgr_of, image_of_bgr
from sunset.nodes.base import AdaptiveNode
from sunset.nodes.parameters import FaultParameter, NodeParameter, action
from sunset.system import BLUR_SIGMA, IMAGE_DEGRADATION_RANGE, SAMPLES
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.lifecycle import LifecycleState, TransitionCallbackReturn


class Camera(AdaptiveNode):
    """Publishes `rgb_camera` from `/rgb_raw`.

    It reports the sharpness of every image and, from the fifth image on, as `autofocus_needed`, whether the mean of
    the last five is below `sharpness_threshold`. Both are measured on the image, never read off the fault.
    """

    node_name = "camera"

    sharpness_threshold = NodeParameter(
        0.0, "sharpness below which the camera reports that it is out of focus", minimum=0.0, maximum=64.0
    )
    image_degradation = NodeParameter(
        IMAGE_DEGRADATION_RANGE[0],
        "external fault: how much darker and colour-shifted the images are",
        minimum=IMAGE_DEGRADATION_RANGE[0],
        maximum=IMAGE_DEGRADATION_RANGE[1],
    )
    camera_driver_issue = FaultParameter(
        False, "internal fault: no images come out, until a restart", cured_by_restart=True
    )
    hardware_disconnect = FaultParameter(False, "internal fault: no images come out, until a redeploy")
    autofocus_needed = FaultParameter(
        False, "internal fault: the images are blurred", ends_with="perform_autofocus"
    )

    def set_up(self) -> None:
        """Declare the input and the output."""
        self._sharpness: deque[float] = deque(maxlen=SAMPLES)
        self._images = self.create_lifecycle_publisher(Image, "rgb_camera", 10)
        self.create_active_subscription(Image, "/rgb_raw", self._on_image)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Forget the sharpness of earlier images."""
        self._sharpness.clear()
        return super().on_activate(state)

    @action
    def perform_autofocus(self) -> None:
        """Adaptation: focus the lens, which ends autofocus_needed."""
        self.write_parameter("autofocus_needed", value=False)

    def _on_image(self, message: Image) -> None:
        if self.camera_driver_issue or self.hardware_disconnect:
            return
        bgr = bgr_of(message)
        if self.image_degradation:
            bgr = bgr.then(degrade_image, self.image_degradation)
        if self.autofocus_needed:
            bgr = bgr.then(defocus_image, BLUR_SIGMA)
        self._report_sharpness(bgr.measure(sharpness))
        self._images.publish(image_of_bgr(message.header, bgr))

    def _report_sharpness(self, value: float) -> None:
        self._sharpness.append(value)
        self.report("sharpness", value)
        if len(self._sharpness) == SAMPLES:
            self.report("autofocus_needed", sum(self._sharpness) / SAMPLES < self.sharpness_threshold)
