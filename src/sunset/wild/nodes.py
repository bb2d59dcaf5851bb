"""The managed nodes with the faults that no catalogue lists.

They replace the ordinary nodes in runs with such a fault only. Before its onset, they behave the same, and list the
same parameters.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from types import MappingProxyType
from typing import Final, TypeAlias, cast

import cv2
import numpy as np
import numpy.typing as npt

from sunset.faults import blur
from sunset.image_messages import bgr_of, depth_of, image_of_bgr, image_of_depth, stamp_ns
from sunset.images import LazyImage
from sunset.nodes import AdaptiveNode, Camera, Depth, FaultParameter, Fusion, NodeParameter, SegmentationNode
from sunset.system_interfaces.msg import FusionType, SensorFusion
from sunset_ros.interfaces.rcl_interfaces.msg import ListParametersResult
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.stamps import NS_PER_S, stamp_of
from sunset_ros.interfaces.std_msgs.msg import Header

_ARRIVING: Final = 20
"""One of 20 images arrives on a lossy link."""
_SLOW_S: Final = 2.5
"""Time that a segmentation of both images takes on a hot processor [s]."""
_SCATTER: Final = 6 / 256
"""Standard deviation of scattered light, as a share of the image's width."""

Colours: TypeAlias = npt.NDArray[np.uint8]
Depths: TypeAlias = npt.NDArray[np.uint16]


def overexpose(bgr: Colours, strength: float) -> Colours:
    """Multiply the light by 1 + `strength`, up to white."""
    return cast("Colours", cv2.convertScaleAbs(bgr, alpha=1 + strength))


def tint(bgr: Colours, strength: float) -> Colours:
    """Multiply blue by 1 + `strength`, and red by 1 - `strength`."""
    return cast("Colours", cv2.transform(bgr, np.diag([1 + strength, 1.0, 1 - strength])))


def scatter(bgr: Colours, strength: float) -> Colours:
    """Replace a share of the light by light from the surroundings."""
    return cast(
        "Colours", cv2.addWeighted(bgr, 1 - strength, blur(bgr, _SCATTER * bgr.shape[1]), strength, 0)
    )


def turn(bgr: Colours, strength: float) -> Colours:
    """Turn an image by half, at any strength."""
    del strength
    return cast("Colours", cv2.rotate(bgr, cv2.ROTATE_180))


def scale(depth: Depths, strength: float) -> Depths:
    """Multiply a depth image by 1 + `strength`."""
    scaled: Depths = np.clip(np.rint(depth * (1 + strength)), 0, 65535).astype(np.uint16)
    return scaled


class _Unlisted(AdaptiveNode):
    """A node that does not list the parameters of its own class."""

    def list_parameters(self, prefixes: Sequence[str], depth: int) -> ListParametersResult:
        """Return the names of the other parameters."""
        listed = super().list_parameters(prefixes, depth)
        listed.names = [name for name in listed.names if name not in vars(type(self))]
        return listed


class WildCamera(_Unlisted, Camera):
    """A camera whose images may be old, too bright, of the wrong colours, seen through a film, or upside down."""

    _last: LazyImage | None = None
    frozen_image = FaultParameter(False, "internal fault: the last image is repeated", cured_by_restart=True)
    overexposure = FaultParameter(
        0.0, "internal fault: share of excess light, until a redeploy", minimum=0.0, maximum=20.0
    )
    lens_film = FaultParameter(
        0.0,
        "internal fault: share of light that a film on the lens scatters, until a restart",
        minimum=0.0,
        maximum=1.0,
        cured_by_restart=True,
    )
    cold_light = NodeParameter(
        0.0, "external fault: shift of the light towards blue", minimum=0.0, maximum=1.0
    )
    upside_down = FaultParameter(False, "internal fault: the images are turned by half, until a redeploy")

    def _on_image(self, message: Image) -> None:
        seen = bgr_of(message)
        if self._last is None or not self.frozen_image:
            self._last = seen
        bgr = self._last
        for degrade, strength in (
            (overexpose, self.overexposure),
            (tint, self.cold_light),
            (scatter, self.lens_film),
            (turn, self.upside_down),
        ):
            bgr = bgr.then(degrade, strength) if strength else bgr
        super()._on_image(message if bgr is seen else image_of_bgr(message.header, bgr))


class WildDepth(_Unlisted, Depth):
    """A depth camera whose scale may be off, whose link may lose images, and whose clock may step."""

    _lost = 0
    scale_error = FaultParameter(
        0.0, "internal fault: share of excess distance, until a redeploy", minimum=0.0, maximum=10.0
    )
    lossy_link = FaultParameter(False, "internal fault: few images arrive", cured_by_restart=True)
    stepped_clock = FaultParameter(
        0.0, "internal fault: delay of the stamps [s], until a redeploy", minimum=0.0, maximum=60.0
    )

    def _on_image(self, message: Image) -> None:
        if self.lossy_link:
            self._lost += 1
            if self._lost % _ARRIVING:
                return
        if self.scale_error:
            message = image_of_depth(message.header, depth_of(message).then(scale, self.scale_error))
        if self.stepped_clock:
            message = _restamped(message, stamp_ns(message.header) + round(self.stepped_clock * NS_PER_S))
        super()._on_image(message)


class WildFusion(_Unlisted, Fusion):
    """A fusion that may send half of each image only."""

    short_buffer = FaultParameter(False, "internal fault: images are cut in half", cured_by_restart=True)

    def _publish(self, header: Header, *, rgb: Image | None = None, depth: Image | None = None) -> None:
        super()._publish(header, rgb=rgb, depth=_cut(depth) if depth and self.short_buffer else depth)

    def _shifted(self, rgb: Image) -> Image:
        shifted = super()._shifted(rgb)
        return _cut(shifted) if self.short_buffer else shifted


class WildSegmentation(_Unlisted, SegmentationNode):
    """A segmentation whose processor may be too hot for the network of both images."""

    _is_busy = False
    hot_processor = NodeParameter(False, "external fault: the network of both images takes seconds")

    def _on_fused(self, message: SensorFusion) -> None:
        if not self.hot_processor or message.modality.fusion_type != FusionType.FUSION:
            super()._on_fused(message)
        elif not self._is_busy:
            self._is_busy = True
            self.call_later(_SLOW_S, partial(self._finish, message))

    def _finish(self, message: SensorFusion) -> None:
        self._is_busy = False
        super()._on_fused(message)


NODE_CLASSES: Final[Mapping[str, type[AdaptiveNode]]] = MappingProxyType(
    {
        "camera": WildCamera,
        "depth": WildDepth,
        "sensor_fusion": WildFusion,
        "segmentation": WildSegmentation,
    }
)
"""Managed node → the class that runs in its place."""


def _restamped(image: Image, time_ns: int) -> Image:
    restamped = image.copy()
    restamped.header = Header(stamp=stamp_of(time_ns), frame_id=image.header.frame_id)
    return restamped


def _cut(image: Image) -> Image:
    cut = image.copy()
    cut.data = image.data[: image.data.size // 2]
    return cut
