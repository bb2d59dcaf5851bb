"""The simulated middleware: a world of processes in one Python process, in virtual time."""

from sunset_ros.rmw.core.tap import Tap as Tap
from sunset_ros.rmw.sim._process import SimProcess as SimProcess
from sunset_ros.rmw.sim._simulation import Simulation as Simulation
