"""The managing systems to compare with: none, at random, and the paper's baseline."""

from collections.abc import Mapping
from typing import Final, cast

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Thresholds, request
from sunset.system.vocabulary import Failure, current_system
from sunset_ros.seeding import generator

_SHARE: Final = 0.1
"""Share of calls of `adapt` during a failure in which it adapts: once in two seconds, on average."""
_NODE_OF_TOPIC: Final[Mapping[str, str]] = {
    "rgb_camera": "camera",
    "depth_camera": "depth",
    "sensors_fused": "sensor_fusion",
    "segmentation": "segmentation",
}


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


class RandomAdaptation(ManagingSystem):
    """Chooses cures of the failures that show, at random moments, all with the same probability.

    It knows the cures of each failure, but distinguishes neither causes from ripples nor faults from each other, and
    ignores the effects of its adaptations. Each draw depends on the run's seed and on the symptoms: with the seed
    alone, the luck of a single sequence of draws would decide all scenarios and flights.

    Parameters:
        manager_seed: the seed of its draws.
    """

    def on_start(self) -> None:
        """Read the seed."""
        self.seed = cast("int", self.declare_parameter("manager_seed", 0).value)
        self.looks = 0
        self.thresholds = Thresholds(self)

    def adapt(self, symptoms: Symptoms) -> None:
        """Draw whether to adapt now, and a cure."""
        showing = {
            failure.name for failure in current_system().failures.values() if self.shows(failure, symptoms)
        }
        faults = (fault for fault in current_system().faults.values() if fault.failure in showing)
        cures = dict.fromkeys(cure for fault in faults for cure in fault.cures)
        # a node that boots cannot answer
        possible = [cure for cure in cures if symptoms.state(cure[0].node) in {"active", "inactive"}]
        self.looks += 1
        random = generator(self.seed, "random adaptation", self.looks, repr(symptoms))
        if possible and random.random() < _SHARE:
            for step in possible[int(random.integers(len(possible)))]:
                request(self, step)

    def shows(self, failure: Failure, symptoms: Symptoms) -> bool:
        """Return whether a failure shows."""
        if failure.topic:
            return symptoms.stopped(failure.topic)
        return self.thresholds.is_beyond(failure.signal, symptoms)
