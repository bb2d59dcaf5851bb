"""The managed system of this process: the paper's, and what extensions add to it."""

from sunset.system.description import Fault
from sunset.system.paper import PAPER
from sunset.system.system import System

__all__ = ["current_system", "get_fault"]

_system = System(PAPER)


def current_system() -> System:
    """Return the managed system that this process describes, runs and scores."""
    return _system


def get_fault(name: str) -> Fault:
    """Return the fault of that name.

    Raises:
        ScenarioError: there is none; the message lists those that there are.

    >>> get_fault("gpu_failure").redeploy_only
    True
    """
    return _system.fault(name)
