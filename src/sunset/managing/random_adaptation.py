"""A managing system that adapts at random: what luck alone is worth."""

from typing import Final, cast

from sunset.managing.base import ManagingSystem
from sunset.managing.requesting import request
from sunset.managing.symptoms import Symptoms
from sunset.managing.thresholds import Thresholds
from sunset.seeding import generator
from sunset.system.vocabulary import Adaptation, Failure, described_failures, described_faults

_SHARE: Final = 0.1
"""Share of the calls of `adapt` with something wrong in which it adapts: one in two seconds, on average."""


class RandomAdaptation(ManagingSystem):
    """Does any cure of any fault that could show as it does, at random moments, each as often.

    It knows what cures which failure, but tells neither causes from ripples nor faults from each other, and sees not
    what its adaptations do. Moments and cures are drawn anew at each look, from the seed of the run and from what it
    sees: were it the seed alone, the luck of one sequence of draws would be that of all scenarios and flights.

    Parameters:
        manager_seed: what it draws from.
    """

    def on_start(self) -> None:
        """Take what it draws from."""
        self.seed = cast("int", self.declare_parameter("manager_seed", 0).value)
        self.looks = 0
        self.thresholds = Thresholds(self)

    def adapt(self, symptoms: Symptoms) -> None:
        """Draw whether to adapt now, and what to do."""
        showing = {failure.name for failure in described_failures().values() if self.shows(failure, symptoms)}
        faults = (fault for fault in described_faults().values() if fault.failure in showing)
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
    """Return whether the node that a cure begins with is there: a node that boots cannot be asked."""
    return symptoms.state(cure[0].node) in {"active", "inactive"}
