"""Which nodes an experiment consists of; every other node is part of the managing system."""

from types import MappingProxyType
from typing import Final

from sunset.metrics import INFRASTRUCTURE

__all__ = ["INITIAL_STATES", "MANAGED_NODES", "MANAGER_PROCESS", "SYSTEM_NODES"]

MANAGER_PROCESS: Final = "manager"
"""The name of the process that the managing system's nodes are in."""

INITIAL_STATES: Final = MappingProxyType(
    {
        "camera": "active",
        "depth": "active",
        "image_enhancement": "inactive",
        "sensor_fusion": "active",
        "segmentation": "active",
    }
)
"""The lifecycle state of each managed node of the healthy system, by short name."""

MANAGED_NODES: Final = frozenset(f"/managed_subsystem/{name}" for name in INITIAL_STATES)
"""The full names of the managed nodes."""

SYSTEM_NODES: Final = MANAGED_NODES | INFRASTRUCTURE | {"/bag_player", "/evaluator", "/monitor"}
"""The full names of all nodes that are not the managing system's."""
