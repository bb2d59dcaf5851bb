"""Managing systems that decide as the programs of the documentation do."""

from sunset.managing import ManagingSystem, Symptoms

PIPELINE = {
    "rgb_camera": "camera",
    "depth_camera": "depth",
    "sensors_fused": "sensor_fusion",
    "segmentation": "segmentation",
}


class Focus(ManagingSystem):
    """Focuses the camera when its images are blurred."""

    def adapt(self, symptoms: Symptoms) -> None:
        if symptoms.autofocus_needed:
            self.set_parameter("camera", "perform_autofocus", value=True)


class Upstream(ManagingSystem):
    """Redeploys the node furthest upstream that has stopped sending, and gives it five seconds to be back."""

    def on_start(self) -> None:
        self.wait = 0

    def adapt(self, symptoms: Symptoms) -> None:
        stopped = [node for topic, node in PIPELINE.items() if symptoms.stopped(topic)]
        if self.wait:
            self.wait -= 1
        elif stopped:
            self.redeploy(stopped[0])
            self.wait = 25


class Late(ManagingSystem):
    """Redeploys the segmentation once, when it has thought about it, and says what it thinks."""

    def on_start(self) -> None:
        self.done = False

    def adapt(self, symptoms: Symptoms) -> None:
        if symptoms.stopped("segmentation") and not self.done:
            self.done = True
            self.think(0.25)
            self.diagnose({"gpu_failure": 0.75})
            self.redeploy("segmentation")
