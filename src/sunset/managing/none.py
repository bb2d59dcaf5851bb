"""The managing system that does nothing."""

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms


class NoAdaptation(ManagingSystem):
    """Watches and does nothing: the reference that every managing system must beat."""

    def adapt(self, symptoms: Symptoms) -> None:
        """Do nothing."""
