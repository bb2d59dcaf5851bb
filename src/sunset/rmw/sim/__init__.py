"""The simulated middleware: a world of processes in one Python process, in virtual time."""

from sunset.rmw.core.tap import Tap
from sunset.rmw.sim._compute import DEFAULT_COMPUTE
from sunset.rmw.sim._process import SimProcess
from sunset.rmw.sim._simulation import Simulation

__all__ = ["DEFAULT_COMPUTE", "SimProcess", "Simulation", "Tap"]
