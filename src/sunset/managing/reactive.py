"""A managing system that looks for causes: a readable example, which is better than the baseline."""

from collections import Counter
from collections.abc import Callable
from typing import Final

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Thresholds, Waits, Wiring
from sunset.system.vocabulary import current_system, full_name

_RESTART_S: Final = 0.5
"""Time until a restarted node sends again."""
_MARGIN_S: Final = 0.3
"""Time from a node's boot to its first message."""
_ENTROPY_S: Final = 0.7
"""Time until the entropy, a mean over 5 frames, is of new frames only."""
_FOCUS_S: Final = 0.9
"""Time until the sharpness is of new frames only."""


class Reactive(ManagingSystem):
    """Repairs the first node that stopped, focuses the camera, and tries the cures of an unsure segmentation in turn.

    - *Outage*: several topics are silent at once if the failure ripples. It repairs the node of the silent topic
      furthest upstream, and nodes downstream recover. It restarts that node, and redeploys it if it stays silent, since
      a restart takes less time and cures half of the faults.
    - *Blurred images*: the camera focuses.
    - *Unsure segmentation*: four causes look the same. It tries their cures in turn, the cheapest first. It keeps a
      cure that lowers the entropy, and undoes any other.

    Its diagnosis names the faults of each failure that shows, with equal probabilities.
    """

    def on_start(self) -> None:
        """Begin without a trial."""
        self.wiring, self.waits, self.thresholds = Wiring(), Waits(self), Thresholds(self)
        self.restarted = ""
        self.trial = 0
        self.undo: Callable[[], object] | None = None
        self.entropy_before = 0.0

    def adapt(self, symptoms: Symptoms) -> None:
        """React to each of the three kinds of symptoms, unless the effect of the last reaction is still unknown."""
        silent = self.wiring.first_silent(symptoms)
        self.diagnose(self.suspects(silent, symptoms))
        if silent:
            self.waits.start("trial", _ENTROPY_S)  # the entropy is of old frames
        if self.waits.over("repair"):
            self.repair(silent)
        if symptoms.autofocus_needed and not symptoms.stopped("rgb_camera") and self.waits.over("focus"):
            self.set_parameter("camera", "perform_autofocus", value=True)
            self.waits.start("focus", _FOCUS_S)
            self.waits.start("trial", _FOCUS_S)
        if self.waits.over("trial"):
            self.judge(symptoms)

    def suspects(self, silent: str, symptoms: Symptoms) -> dict[str, float]:
        """Return the faults of the failures that show, with their probabilities."""
        faults = list(current_system().faults.values())
        showing = [
            failure.name
            for failure in current_system().failures.values()
            if (
                silent == self.wiring.publisher[full_name(failure.topic)]
                if failure.topic
                else self.thresholds.is_beyond(failure.signal, symptoms)
            )
        ]
        counts = Counter(fault.failure for fault in faults)
        return {fault.name: 1 / counts[fault.failure] for fault in faults if fault.failure in showing}

    def repair(self, node: str) -> None:
        """Restart the silent node, or redeploy it if a restart has not helped."""
        if node and node != self.restarted:
            self.restart(node)
            self.waits.start("repair", _RESTART_S)
            self.restarted = node
            return
        if node:
            self.redeploy(node)
            self.waits.start("repair", self.wiring.boot_s[node] + _MARGIN_S)
        self.restarted = ""

    def judge(self, symptoms: Symptoms) -> None:
        """While the segmentation is unsure, undo the last cure if it has not helped, and try the next."""
        if not symptoms.unsure:
            self.trial, self.undo = 0, None
            return
        if self.undo is not None and symptoms.entropy >= self.entropy_before:
            self.undo()
        else:
            self.entropy_before = symptoms.entropy
        cures = (self.recalibrate, self.switch_enhancement, self.ignore_depth)
        self.undo = cures[self.trial % len(cures)](symptoms)
        self.trial += 1
        self.waits.start("trial", _ENTROPY_S)

    def recalibrate(self, symptoms: Symptoms) -> None:
        """Make colour and depth images match; this does no harm and is never undone."""
        del symptoms
        self.set_parameter("sensor_fusion", "do_recalibration", value=True)

    def switch_enhancement(self, symptoms: Symptoms) -> Callable[[], object]:
        """Brighten the colour images, or stop brightening them; return a function that undoes this."""
        active = symptoms.state("image_enhancement") == "active"
        self.enhance(not active)
        return lambda: self.enhance(active)

    def enhance(self, wanted: bool) -> None:
        """Let the fusion take the enhanced colour images, or the camera's."""
        if wanted:
            self.activate("image_enhancement")
        self.change_topic("sensor_fusion", "topic_camera_input", "rgb_enhanced" if wanted else "rgb_camera")
        if not wanted:
            self.deactivate("image_enhancement")

    def ignore_depth(self, symptoms: Symptoms) -> Callable[[], object]:
        """Segment from the colour image alone; return a function that undoes this."""
        del symptoms
        self.set_parameter("sensor_fusion", "modality", 1)
        return lambda: self.set_parameter("sensor_fusion", "modality", 0)
