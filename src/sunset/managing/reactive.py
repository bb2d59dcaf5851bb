"""A managing system that looks for causes: a readable example, and better than the baseline."""

from collections.abc import Callable
from typing import Final

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms

_PIPELINE: Final = (
    ("rgb_camera", "camera", 22),
    ("depth_camera", "depth", 22),
    ("sensors_fused", "sensor_fusion", 12),
    ("segmentation", "segmentation", 12),
)
"""Topics from upstream to downstream, the node that sends each, and in how many calls it is back after a redeploy."""

_RESTART_CALLS: Final = 3
"""Calls of `adapt`, one every 0.2 s, until a restarted node would send again."""

_ENTROPY_CALLS: Final = 4
"""Calls until the entropy, a mean over 5 frames, is one of new frames only."""


class Reactive(ManagingSystem):
    """Repairs what stopped first, focuses the camera, and tries the cures of an unsure segmentation in turn.

    - *Outage*: several topics are silent at once if the failure ripples. It repairs the node of the silent topic that
      is furthest upstream, and those downstream recover by themselves. It restarts that node, and redeploys it if it
      stays silent, since a restart takes less time and cures half of the faults.
    - *Blurred images*: the camera focuses.
    - *Unsure segmentation*: four causes look the same. It tries one cure after the other, the cheapest first. One that
      lowers the entropy is kept, another is undone.
    """

    def on_start(self) -> None:
        """Start with nothing done and nothing to wait for."""
        self.restarted = ""
        self.repair_wait = self.focus_wait = self.trial_wait = 0
        self.trial = 0
        self.undo: Callable[[], object] | None = None
        self.entropy_before = 0.0

    def adapt(self, symptoms: Symptoms) -> None:
        """Answer each of the three kinds of symptoms, unless the last answer to it has still to show."""
        self.repair_wait, self.focus_wait, self.trial_wait = (
            max(0, calls - 1) for calls in (self.repair_wait, self.focus_wait, self.trial_wait)
        )
        silent = [stage for stage in _PIPELINE if symptoms.stopped(stage[0])]
        if silent:
            self.trial_wait = _ENTROPY_CALLS  # the entropy is that of old frames
            if not self.repair_wait:
                self.repair(silent[0][1], silent[0][2])
        elif not self.repair_wait:
            self.restarted = ""
        if symptoms.autofocus_needed and not symptoms.stopped("rgb_camera") and not self.focus_wait:
            self.set_parameter("camera", "perform_autofocus", value=True)
            self.focus_wait = self.trial_wait = 5
        if not self.trial_wait:
            self.judge(symptoms)

    def repair(self, node: str, calls: int) -> None:
        """Restart a node that is silent, or redeploy it if that was no help."""
        if self.restarted != node:
            self.restart(node)
            self.restarted, self.repair_wait = node, _RESTART_CALLS
        else:
            self.redeploy(node)
            self.restarted, self.repair_wait = "", calls

    def judge(self, symptoms: Symptoms) -> None:
        """While the segmentation is unsure, undo the last cure if it was no help, and try the next."""
        if not symptoms.unsure:
            self.trial, self.undo = 0, None
            return
        if self.undo is not None and symptoms.entropy >= self.entropy_before:
            self.undo()
        else:
            self.entropy_before = symptoms.entropy
        cures = (self.recalibrate, self.switch_enhancement, self.ignore_depth)
        self.undo = cures[self.trial % len(cures)](symptoms)
        self.trial, self.trial_wait = self.trial + 1, _ENTROPY_CALLS

    def recalibrate(self, symptoms: Symptoms) -> None:
        """Fit colour and depth images together again; this harms nothing, so that it needs no undoing."""
        del symptoms
        self.set_parameter("sensor_fusion", "do_recalibration", value=True)

    def switch_enhancement(self, symptoms: Symptoms) -> Callable[[], object]:
        """Brighten the colour images, or no longer if they are brightened; return what undoes this."""
        active = symptoms.state("image_enhancement") == "active"
        self.enhance(not active)
        return lambda: self.enhance(active)

    def enhance(self, wanted: bool) -> None:
        """Let the fusion take the enhanced colour images, or those of the camera."""
        if wanted:
            self.activate("image_enhancement")
        self.change_topic("sensor_fusion", "topic_camera_input", "rgb_enhanced" if wanted else "rgb_camera")
        if not wanted:
            self.deactivate("image_enhancement")

    def ignore_depth(self, symptoms: Symptoms) -> Callable[[], object]:
        """Segment from the colour image alone; return what undoes this."""
        del symptoms
        self.set_parameter("sensor_fusion", "modality", 1)
        return lambda: self.set_parameter("sensor_fusion", "modality", 0)
