"""The depth camera: publishes the recorded depth images, with noise if it is degraded."""

import numpy as np
import numpy.typing as npt

from sunset.faults import degrade_depth
from sunset.image_messages import depth_of, image_of_depth, stamp_ns
from sunset.nodes.base import AdaptiveNode
from sunset.nodes.parameters import NodeParameter
from sunset.system import DEPTH_DEGRADATION_RANGE
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.seeding import MAX_SEED, generator


class Depth(AdaptiveNode):
    """Publishes `depth_camera` from `/depth_raw`.

    The noise of a frame depends on `seed` and the frame's stamp only.
    """

    node_name = "depth"

    seed = NodeParameter(0, "seed of the noise", minimum=0, maximum=MAX_SEED, read_only=True)
    depth_degradation = NodeParameter(
        DEPTH_DEGRADATION_RANGE[0],
        "external fault: standard deviation of the depth's noise in metres",
        minimum=DEPTH_DEGRADATION_RANGE[0],
        maximum=DEPTH_DEGRADATION_RANGE[1],
    )

    def set_up(self) -> None:
        """Declare the input and the output."""
        self._images = self.create_lifecycle_publisher(Image, "depth_camera", 10)
        self.create_active_subscription(Image, "/depth_raw", self._on_image)

    def _on_image(self, message: Image) -> None:
        depth = depth_of(message)
        if self.depth_degradation > 0:
            depth = depth.then(_with_noise, self.depth_degradation, self.seed, stamp_ns(message.header))
        self._images.publish(image_of_depth(message.header, depth))


def _with_noise(
    depth: npt.NDArray[np.uint16], strength: float, seed: int, stamp_ns: int
) -> npt.NDArray[np.uint16]:
    return degrade_depth(depth, strength, generator(seed, "depth", stamp_ns))
