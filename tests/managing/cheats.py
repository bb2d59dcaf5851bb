"""Managing systems that want figures, not a segmentation: they mask, prevent blindly, silence, toggle or boast."""

from sunset.managing import ManagingSystem, Symptoms
from sunset.system.vocabulary import described_faults

COLOUR, DEPTH, BOTH = 1, 2, 0
SECOND = 5
"""Calls of `adapt` a second."""

PIPELINE = ("camera", "depth", "sensor_fusion", "segmentation")
TOPIC_OF = dict(zip(PIPELINE, ("rgb_camera", "depth_camera", "sensors_fused", "segmentation"), strict=True))


class Cheat(ManagingSystem):
    """Counts its calls."""

    def on_start(self) -> None:
        """Begin to count."""
        self.calls = -1

    def adapt(self, symptoms: Symptoms) -> None:
        """Count, and act."""
        self.calls += 1
        self.symptoms = symptoms
        self.act()

    def act(self) -> None:
        """Do what it does."""


class RedeployAllAlways(Cheat):
    """Redeploys the whole pipeline each second, so that nothing stays broken."""

    def act(self) -> None:
        if self.calls % SECOND == 0:
            for node in PIPELINE:
                self.redeploy(node)


class RedeployAtOnce(Cheat):
    """Redeploys three nodes as soon as it runs, before it could know anything."""

    def act(self) -> None:
        if self.calls == 0:
            for node in ("camera", "sensor_fusion", "segmentation"):
                self.redeploy(node)


class ColourAlways(Cheat):
    """Segments the colour image alone, whose entropy stays calm whatever is wrong."""

    def act(self) -> None:
        if self.calls == 0:
            self.set_parameter("sensor_fusion", "modality", COLOUR)


class DepthWhenUnsure(Cheat):
    """Segments the depth image alone as soon as the segmentation is unsure."""

    def act(self) -> None:
        if self.symptoms.unsure:
            self.set_parameter("sensor_fusion", "modality", DEPTH)


class SilenceWhenUnsure(Cheat):
    """Stops the segmentation for a second whenever it is unsure, so that nobody sees that it is."""

    def act(self) -> None:
        if self.calls % (2 * SECOND) == 0 and self.symptoms.unsure:
            self.deactivate("segmentation")
        elif self.calls % (2 * SECOND) == SECOND:
            self.activate("segmentation")


class SilenceAlways(Cheat):
    """Stops the segmentation for good, so that no frame is bad."""

    def act(self) -> None:
        if self.calls == 0:
            self.deactivate("segmentation")


class OnlyTheCamera(Cheat):
    """Redeploys the camera when it is silent, focuses it when it is blurred, and never does anything in vain."""

    def act(self) -> None:
        if self.calls % (5 * SECOND) == 0 and self.symptoms.stopped("rgb_camera"):
            self.redeploy("camera")
        if self.calls % SECOND == 0 and self.symptoms.autofocus_needed:
            self.set_parameter("camera", "perform_autofocus", True)


class Flicker(Cheat):
    """Changes the modality twice a second, so that no symptom lasts."""

    def act(self) -> None:
        if self.calls % 2 == 0:
            self.set_parameter("sensor_fusion", "modality", COLOUR if self.calls % 4 else BOTH)


class RestartInTurn(Cheat):
    """Restarts one node after the other, each second another one."""

    def act(self) -> None:
        if self.calls % SECOND == 0:
            self.restart(PIPELINE[self.calls // SECOND % len(PIPELINE)])


class TuneAlways(Cheat):
    """Focuses and recalibrates in every call, which costs no output."""

    def act(self) -> None:
        self.set_parameter("camera", "perform_autofocus", True)
        self.set_parameter("sensor_fusion", "do_recalibration", True)


class EveryCureAtOnce(Cheat):
    """Does all at once that cures any fault, and never looks again."""

    def act(self) -> None:
        if self.calls == 0:
            self.activate("image_enhancement")
            self.change_topic("sensor_fusion", "topic_camera_input", "rgb_enhanced")
            self.set_parameter("sensor_fusion", "modality", COLOUR)
            self.set_parameter("sensor_fusion", "do_recalibration", True)
            self.set_parameter("camera", "perform_autofocus", True)
            self.restart("camera")
            self.restart("segmentation")


class RestartAndResetAlways(Cheat):
    """Restarts, focuses, recalibrates and sets all parameters back in every call, so that most faults end at once."""

    def act(self) -> None:
        for node in PIPELINE:
            self.restart(node)
        self.set_parameter("camera", "perform_autofocus", True)
        self.set_parameter("sensor_fusion", "do_recalibration", True)
        self.set_parameter("sensor_fusion", "modality", BOTH)
        self.change_topic("sensor_fusion", "topic_camera_input", "rgb_camera")


class TreatEverything(Cheat):
    """Treats all that it can treat as soon as anything shows, whatever that is, and redeploys what stays silent."""

    def on_start(self) -> None:
        """Begin to count, and remember what has been redeployed."""
        super().on_start()
        self.redeployed = dict.fromkeys(TOPIC_OF, -5 * SECOND)

    def act(self) -> None:
        silent = [node for node, topic in TOPIC_OF.items() if self.symptoms.stopped(topic)]
        if self.calls % (3 * SECOND) == 0 and (
            silent or self.symptoms.unsure or self.symptoms.autofocus_needed
        ):
            for node in PIPELINE:
                self.restart(node)
            self.set_parameter("camera", "perform_autofocus", True)
            self.set_parameter("sensor_fusion", "do_recalibration", True)
            self.change_topic("sensor_fusion", "topic_camera_input", "rgb_camera")
        elif silent and self.calls - self.redeployed[silent[0]] >= 5 * SECOND:
            self.redeployed[silent[0]] = self.calls
            self.redeploy(silent[0])


class NameEveryFault(Cheat):
    """Repairs nothing, and is sure that every fault of the catalogue is there."""

    def act(self) -> None:
        self.diagnose(dict.fromkeys(described_faults(), 1.0))


CHEATS: tuple[type[Cheat], ...] = tuple(Cheat.__subclasses__())
