"""The managing systems to compare with: the paper's baseline, and none."""

from types import MappingProxyType
from typing import Final

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms

_NODE_OF_TOPIC: Final = MappingProxyType(
    {
        "rgb_camera": "camera",
        "depth_camera": "depth",
        "sensors_fused": "sensor_fusion",
        "segmentation": "segmentation",
    }
)


class NoAdaptation(ManagingSystem):
    """Watches and does nothing: the reference that every managing system must beat."""

    def adapt(self, symptoms: Symptoms) -> None:
        """Do nothing."""


class Baseline(ManagingSystem):
    """Redeploys nodes that stop sending, and recalibrates the fusion when the segmentation is unsure.

    As in the paper (section 4), it redeploys every node whose topic has frequency 0, and recalibrates the fusion once
    the entropy exceeds the threshold. It reacts once to each episode of a symptom. It does not look for causes: when
    the camera dies, it redeploys the fusion and the segmentation, too.
    """

    def on_start(self) -> None:
        """Begin without symptoms."""
        self._answered: set[str] = set()

    def adapt(self, symptoms: Symptoms) -> None:
        """React to every symptom that began since the last call."""
        for topic, node in _NODE_OF_TOPIC.items():
            if self._begins(topic, present=symptoms.stopped(topic)):
                self.redeploy(node)
        if self._begins("entropy", present=symptoms.unsure):
            self.set_parameter("sensor_fusion", "do_recalibration", value=True)

    def _begins(self, symptom: str, *, present: bool) -> bool:
        """Return whether an episode of the symptom begins now."""
        if not present:
            self._answered.discard(symptom)
            return False
        begins = symptom not in self._answered
        self._answered.add(symptom)
        return begins
