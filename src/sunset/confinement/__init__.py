"""A confined process, in which code of others runs: it sees what it needs to run, and one socket.

`Confinement` is a server that forks such processes; `ConfinedProcess` is one of them, as its user sees it. The server
is an interpreter of its own that has never seen what its user knows. A copy of it has neither its user's memory, nor
its arguments, environment or open files. What a process can do is restricted before it runs anything: `walls.py`.
"""

from sunset.confinement.process import ConfinedProcess, Confinement, copy_process
from sunset.confinement.walls import WALLS, View, confinement_report, missing_walls

__all__ = [
    "WALLS",
    "ConfinedProcess",
    "Confinement",
    "View",
    "confinement_report",
    "copy_process",
    "missing_walls",
]
