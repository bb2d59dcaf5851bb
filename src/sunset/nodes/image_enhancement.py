"""The image enhancement: undoes a degradation of colour images."""

from sunset.faults import enhance_image
from sunset.image_messages import bgr_of, image_of_bgr
from sunset.nodes.base import AdaptiveNode
from sunset.nodes.parameters import NodeParameter
from sunset.system import IMAGE_DEGRADATION_RANGE, get_fault
from sunset_ros.interfaces.sensor_msgs.msg import Image


class ImageEnhancement(AdaptiveNode):
    """Publishes `rgb_enhanced` from `rgb_camera`; inactive until it is activated.

    It does not check whether an image is degraded, and makes a good image worse.
    """

    node_name = "image_enhancement"

    image_degradation = NodeParameter(
        float(get_fault("image_degradation").value),
        "the strength of the degradation that is undone",
        minimum=IMAGE_DEGRADATION_RANGE[0],
        maximum=IMAGE_DEGRADATION_RANGE[1],
    )

    def set_up(self) -> None:
        """Declare the input and the output."""
        self._images = self.create_lifecycle_publisher(Image, "rgb_enhanced", 10)
        self.create_active_subscription(Image, "rgb_camera", self._on_image)

    def _on_image(self, message: Image) -> None:
        bgr = bgr_of(message)
        if self.image_degradation:
            bgr = bgr.then(enhance_image, self.image_degradation)
        self._images.publish(image_of_bgr(message.header, bgr))
