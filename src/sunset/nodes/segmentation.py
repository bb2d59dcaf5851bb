"""The segmentation: runs the network of the fused images' modality."""

from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from sunset.errors import DataError
from sunset.image_messages import bgr_of, depth_of, image_of_labels
from sunset.images import LazyImage, open_cache
from sunset.nodes.base import AdaptiveNode
from sunset.nodes.parameters import FaultParameter, NodeParameter
from sunset.system import get_fault
from sunset.system_interfaces.msg import SensorFusion
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.lifecycle import LifecycleState, TransitionCallbackReturn

if TYPE_CHECKING:
    # imported where it is used: it takes time and starts a thread, and other nodes do without it
    from sunset.perception import Modality, Segmenter

_WARM_UP_S: Final = 0.15
"""Time before the first run of each network, so that heartbeats, every 0.1 s, are not late."""


class SegmentationNode(AdaptiveNode):
    """Publishes `segmentation` from `sensors_fused`: the class index of every pixel.

    It reports the entropy of every frame. While it works on a frame, it keeps only the newest frame that arrives.

    While the node boots, it runs each network on an empty image, so that the first frames are not slower than others.

    Args:
        segmenter: the segmenter, which is not warmed up; None for the segmenter that the parameters describe.
        options: as in `AdaptiveNode`.
    """

    node_name = "segmentation"

    model = NodeParameter("lite", "name of a shipped model, or the folder of one's own", read_only=True)
    inference_cache = NodeParameter(
        "", "file that results of inference are looked up and kept in; empty for none", read_only=True
    )
    device = NodeParameter("cpu", "what networks run on: cpu, cuda or auto", read_only=True)
    cuda_out_of_memory = FaultParameter(
        False, get_fault("cuda_out_of_memory").description, cured_by_restart=True
    )
    gpu_failure = FaultParameter(False, get_fault("gpu_failure").description)

    def __init__(self, *, segmenter: "Segmenter | None" = None, **options: Any) -> None:
        self._given = segmenter
        super().__init__(**options)

    def set_up(self) -> None:
        """Declare the input and the output."""
        self._labels = self.create_lifecycle_publisher(Image, "segmentation", 10)
        self.create_active_subscription(SensorFusion, "sensors_fused", self._on_fused, depth=1)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Load the model."""
        if self._given is None:
            self._segmenter = self._described()
            self._warm_up(sorted(self._segmenter.model.card.networks))
        else:
            self._segmenter = self._given
        return super().on_configure(state)

    def _described(self) -> "Segmenter":
        from sunset.perception import Segmenter, load_model  # noqa: PLC0415  see above

        cache = open_cache(Path(self.inference_cache)) if self.inference_cache else None
        return Segmenter(load_model(self.model), device=self.device, cache=cache)

    def _warm_up(self, modalities: "list[Modality]") -> None:
        """Run the networks, with time for heartbeats before and between them."""
        if not modalities:
            return

        def run() -> None:
            self._segmenter.warm_up(modalities[0])
            self._warm_up(modalities[1:])

        self.call_later(_WARM_UP_S, run)

    def _on_fused(self, message: SensorFusion) -> None:
        if self.cuda_out_of_memory or self.gpu_failure:
            return
        try:
            inputs = self._inputs(message)
        except DataError as error:
            self.get_logger().error(f"Dropped images: {error}", throttle_duration_sec=10.0)
            return
        labels, entropy = self._segmenter.look_up(*inputs)
        self.report("entropy", entropy)
        self._labels.publish(image_of_labels(message.header, labels))

    def _inputs(self, message: SensorFusion) -> "tuple[Modality, LazyImage | None, LazyImage | None]":
        """Return the segmenter's inputs.

        Raises:
            DataError: the message has an unknown modality, or other images than the model takes.
        """
        from sunset.perception import Modality  # noqa: PLC0415  see above

        card = self._segmenter.model.card
        try:
            modality = Modality(message.modality.fusion_type)
        except ValueError as error:
            raise DataError(f"There is no modality {message.modality.fusion_type}.") from error
        bgr = bgr_of(message.rgb) if modality.needs_rgb else None
        depth = depth_of(message.depth) if modality.needs_depth else None
        for image in (bgr, depth):
            if image is not None and image.size != (card.height, card.width):
                height, width = image.size
                raise DataError(
                    f"The model {card.name} takes images of {card.width}x{card.height} pixels, got {width}x{height}."
                )
        return modality, bgr, depth
