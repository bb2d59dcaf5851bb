"""A managing system that adapts at random, as a measure of luck."""

from typing import Final, cast

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Thresholds, request
from sunset.system.vocabulary import Adaptation, Failure, current_system
from sunset_ros.seeding import generator

_SHARE: Final = 0.1
"""Share of calls of `adapt` during a failure in which it adapts: once in two seconds, on average."""


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
        possible = [cure for cure in cures if is_possible(cure, symptoms)]
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


def is_possible(cure: tuple[Adaptation, ...], symptoms: Symptoms) -> bool:
    """Return whether the first node of a cure can answer: a node that boots cannot."""
    return symptoms.state(cure[0].node) in {"active", "inactive"}
