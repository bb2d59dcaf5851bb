"""The simulated middleware: a world of processes in one Python process, in virtual time."""

from sunset.rmw.core.tap import Tap
from sunset.rmw.sim._process import SimProcess
from sunset.rmw.sim._simulation import Simulation

__all__ = ["SimProcess", "Simulation", "Tap"]
