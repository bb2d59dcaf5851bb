"""The nodes that surround the managed system, and what a managing system must leave alone."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

__all__ = [
    "HARNESS",
    "INFRASTRUCTURE",
    "MANAGER_PROCESS",
    "OFF_LIMITS_TOPICS",
    "RESULT_TOPIC",
    "SENSOR_TOPICS",
    "HarnessNode",
]

MANAGER_PROCESS: Final = "manager"
"""The name of the process that the managing system's nodes are in."""

RESULT_TOPIC: Final = "/managed_subsystem/segmentation"
"""What the pipeline has at its end: there are messages on it only where all before it works."""

SENSOR_TOPICS: Final = ("/rgb_raw", "/depth_raw")
"""What the world shows to the sensors of the managed system."""


@dataclass(frozen=True, slots=True)
class HarnessNode:
    """A node of the experiment.

    Attributes:
        name: its name.
        outputs: the topics that nobody else may publish on.
        commands: whether what it asks of the managed system is the experiment's own, such as to inject faults.
        off_limits: whether a managing system must not call its services.
    """

    name: str
    outputs: tuple[str, ...] = ()
    commands: bool = False
    off_limits: bool = True


HARNESS: Final[Mapping[str, HarnessNode]] = MappingProxyType(
    {
        node.name: node
        for node in (
            HarnessNode("bag_player", (*SENSOR_TOPICS, "/gt_segmentation", "/clock")),
            HarnessNode("monitor", ("/blackboard_group",), off_limits=False),
            HarnessNode("evaluator", ("/seg_metrics",)),
            HarnessNode("scenario_executor", ("/experiment/injections",), commands=True),
            HarnessNode("launcher", commands=True, off_limits=False),
            HarnessNode("experiment", ("/experiment/log",), commands=True),
        )
    }
)
"""The nodes of an experiment that are not managed, by name."""

INFRASTRUCTURE: Final = frozenset(f"/{node.name}" for node in HARNESS.values() if node.commands)
"""Full names of the nodes whose commands are the experiment's own, such as to inject faults."""

OFF_LIMITS_TOPICS: Final = (
    "/experiment/injections",
    "/experiment/log",
    "/gt_segmentation",
    "/parameter_events",
    "/seg_metrics",
)
"""Topics that carry the truth: a managing system that reads them is not scored."""
