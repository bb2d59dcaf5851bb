"""The published code's timing: baselines that notice a silence late, and an extension whose nodes boot fast."""

from typing import Any

from sunset.managing import Symptoms
from sunset.managing.baseline import Baseline
from sunset.nodes import AdaptiveNode, Camera, Fusion, SegmentationNode
from sunset.system import SILENCE_S, Extension
from sunset_ros.parameter import Parameter


class Patient(Baseline):
    """The baseline, but a topic has stopped only when it has sent nothing for 3.7 s.

    The published code has, as a topic's frequency, the greatest k / (now − the k-th last message), with k up to 4 in
    its first version and up to 10 in its later one. Below 1 / s it redeploys the node. At 10 messages a second, that is
    3.7 s after the last message: 4 / (3.7 s + 0.3 s). With 10 it is 9.1 s.
    """

    silence_s = 3.7

    def on_start(self) -> None:
        """Start with no topic silent."""
        super().on_start()
        self._since: dict[str, float] = {}

    def adapt(self, symptoms: Symptoms) -> None:
        """Answer the symptoms, without the silences that are too short."""
        silent = [key for key, value in symptoms.items() if key.endswith("_freq") and value == 0]
        self._since = {key: self._since.get(key, self.now_s) for key in silent}
        short = {key for key in silent if self.now_s - self._since[key] < self.silence_s - SILENCE_S}
        known = {key: value for key, value in symptoms.items() if key not in short}
        super().adapt(Symptoms(known, entropy_threshold=self.entropy_threshold))


class MorePatient(Patient):
    """The same with 9.1 s."""

    silence_s = 9.1


class Quick(AdaptiveNode):
    """A node that boots in 1 s.

    The first version of the published code waits 1 s when a node boots, and a process takes its time to start, while
    the experiment's clock runs at a fifth of real time. So 1 s stands for 5 s of real time.
    """

    def __init__(self, *, parameter_overrides: list[Parameter] | None = None, **options: Any) -> None:
        boot = Parameter("lifecycle_activation_delay", value=1.0)
        super().__init__(parameter_overrides=[*(parameter_overrides or ()), boot], **options)


class QuickCamera(Quick, Camera):
    """A camera that boots in 1 s."""


class QuickFusion(Quick, Fusion):
    """A sensor fusion that boots in 1 s."""


class QuickSegmentation(Quick, SegmentationNode):
    """A segmentation that boots in 1 s."""


EXTENSION = Extension(
    node_classes={"camera": QuickCamera, "sensor_fusion": QuickFusion, "segmentation": QuickSegmentation}
)
