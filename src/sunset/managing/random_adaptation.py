"""A managing system that adapts at random: what luck alone is worth."""

from typing import Final, cast

from sunset.managing.base import ManagingSystem
from sunset.managing.requesting import request
from sunset.managing.symptoms import Symptoms
from sunset.seeding import generator
from sunset.system.vocabulary import offered_adaptations

_EVERY_S: Final = 3.0
"""Mean time between two adaptations [s]."""


class RandomAdaptation(ManagingSystem):
    """Adapts at random moments, whatever the symptoms: any adaptation that the system offers, each as often.

    It knows nothing. Both are drawn from the seed of the run.

    Parameters:
        manager_seed: what it draws from.
    """

    def on_start(self) -> None:
        """Draw the first moment."""
        seed = cast("int", self.declare_parameter("manager_seed", 0).value)
        self.random = generator(seed, "random adaptation")
        self.adaptations = offered_adaptations()
        self.next_s = self.draw_moment()

    def adapt(self, symptoms: Symptoms) -> None:
        """Do one of the adaptations if it is time for it."""
        del symptoms
        if self.get_clock().now().nanoseconds / 1e9 >= self.next_s:
            request(self, self.adaptations[int(self.random.integers(len(self.adaptations)))])
            self.next_s = self.draw_moment()

    def draw_moment(self) -> float:
        """Return when the next adaptation is due, in seconds of the experiment's time."""
        return self.get_clock().now().nanoseconds / 1e9 + float(self.random.exponential(_EVERY_S))
