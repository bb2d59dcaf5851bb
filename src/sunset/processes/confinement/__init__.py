"""The walls around processes that run foreign code: they see the files that they need, and the network.

`walls` puts them up from inside a process, before it runs anything; `sunset.processes` starts such processes.
"""

from sunset.processes.confinement.walls import (
    WALLS,
    View,
    confinement_report,
    missing_walls,
    prepare,
    put_up,
)

__all__ = ["WALLS", "View", "confinement_report", "missing_walls", "prepare", "put_up"]
