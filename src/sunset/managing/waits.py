"""Waiting until an adaptation can have shown what it does."""

from sunset.managing.base import ManagingSystem


class Waits:
    """Cool-downs by name, in the experiment's time.

    Args:
        manager: the managing system that waits.
    """

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._until_s: dict[str, float] = {}

    def start(self, name: str, seconds: float) -> None:
        """Let a wait begin now; one of the same name that has begun is forgotten."""
        self._until_s[name] = self._manager.now_s + seconds

    def over(self, name: str) -> bool:
        """Return whether a wait is over, or has never begun."""
        return self._manager.now_s >= self._until_s.get(name, 0.0)
