"""The nodes and topics around the managed system, and the topics that a managing system must leave alone."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

BAG_PLAYER: Final = "bag_player"
SCENARIO_EXECUTOR: Final = "scenario_executor"
EXPERIMENT: Final = "experiment"
"""The node that conducts an experiment."""
MANAGING_SYSTEM: Final = "managing_system"
"""The name of the managing system's node, unless its class says otherwise."""

MANAGER_PROCESS: Final = "manager"
"""The name of the process that the managing system's nodes are in."""

REPAIR: Final = "repair"
"""The task in which a managing system adapts the managed one."""
DIAGNOSE: Final = "diagnose"
"""The task in which adaptations are refused, so that a managing system can only diagnose."""
TASKS: Final = (REPAIR, DIAGNOSE)

RESULT_TOPIC: Final = "/managed_subsystem/segmentation"
"""The pipeline's output, which stops if any node before it stops."""

SENSOR_TOPICS: Final = ("/rgb_raw", "/depth_raw")
"""The bag's images, which only the sensors of the managed system subscribe to."""

TRUTH_TOPIC: Final = "/gt_segmentation"
"""The true segmentation, from the bag."""
CLOCK_TOPIC: Final = "/clock"
"""The time of the experiment."""
DIAGNOSTICS_TOPIC: Final = "/diagnostics"
"""Heartbeats of the managed nodes, with their signals."""
BLACKBOARD_TOPIC: Final = "/blackboard_group"
"""The symptoms, from the monitor to managing systems."""
DIAGNOSIS_TOPIC: Final = "/managing_system/diagnosis"
"""Diagnoses by managing systems (`system_interfaces/msg/Diagnosis`)."""
COST_TOPIC: Final = "/managing_system/cost"
"""The costs of decisions, by managing systems (`system_interfaces/msg/Cost`)."""
EVALUATION_TOPIC: Final = "/seg_metrics"
"""The IoU of each frame."""
INJECTIONS_TOPIC: Final = "/experiment/injections"
"""The injected faults."""
FAULT_ENDS_TOPIC: Final = "/experiment/fault_ends"
"""The injected faults that healed or were cured."""
LOG_TOPIC: Final = "/experiment/log"
"""Begin and end of the experiment."""
COMMANDS_TOPIC: Final = "/experiment/commands"
"""Requests to the managed system, in records only (`system_interfaces/msg/Command`)."""
PARAMETER_EVENTS_TOPIC: Final = "/parameter_events"
"""Changes of parameters, except those that the experiment injects."""
INJECTED_EVENTS_TOPIC: Final = "/experiment/parameter_events"
"""Changes of fault parameters, and of other parameters that the experiment sets."""
PARAMETER_TOPICS: Final = (PARAMETER_EVENTS_TOPIC, INJECTED_EVENTS_TOPIC)
"""The two topics with all changes of parameters, each once."""


@dataclass(frozen=True, slots=True)
class HarnessNode:
    """A node of the experiment.

    Attributes:
        name: its name.
        node_class: the place of the class that its process runs, as `module:Class`; empty without a process.
        outputs: the topics that no other node may publish on.
        commands: whether its requests to the managed system are the experiment's own, such as to inject faults.
        off_limits: whether a managing system must not call its services.
    """

    name: str
    node_class: str = ""
    outputs: tuple[str, ...] = ()
    commands: bool = False
    off_limits: bool = True


_PLAYED: Final = (*SENSOR_TOPICS, TRUTH_TOPIC, CLOCK_TOPIC)
_SHOWN: Final = ("/views/depth", "/views/labels")
HARNESS: Final[Mapping[str, HarnessNode]] = MappingProxyType(
    {
        node.name: node
        for node in (
            HarnessNode(BAG_PLAYER, "sunset.harness.bag_player:LiveBagPlayer", _PLAYED),
            HarnessNode("monitor", "sunset.harness.monitor:Monitor", (BLACKBOARD_TOPIC,), off_limits=False),
            HarnessNode("evaluator", "sunset.harness.evaluator:Evaluator", (EVALUATION_TOPIC,)),
            HarnessNode(
                SCENARIO_EXECUTOR,
                "sunset.harness.executor:ScenarioExecutor",
                (INJECTIONS_TOPIC, FAULT_ENDS_TOPIC),
                commands=True,
            ),
            HarnessNode("image_views", "sunset.harness.image_views:ImageViews", _SHOWN),
            HarnessNode("launcher", commands=True, off_limits=False),
            HarnessNode(EXPERIMENT, outputs=(LOG_TOPIC,), commands=True),
        )
    }
)
"""The nodes of an experiment that are not managed, by name; `image_views` runs only where a user starts it."""

RESERVED_NAMES: Final = frozenset({*HARNESS, MANAGER_PROCESS, MANAGING_SYSTEM, "operator"})
"""Names that managed nodes must not have."""

SURROUNDING: Final = (BAG_PLAYER, "monitor", "evaluator")
"""The nodes that feed and watch the managed system, with or without an experiment."""

INFRASTRUCTURE: Final = frozenset(f"/{node.name}" for node in HARNESS.values() if node.commands)
"""Full names of the nodes whose commands are the experiment's own, such as to inject faults."""

OFF_LIMITS_TOPICS: Final = (
    INJECTIONS_TOPIC,
    FAULT_ENDS_TOPIC,
    LOG_TOPIC,
    TRUTH_TOPIC,
    INJECTED_EVENTS_TOPIC,
    EVALUATION_TOPIC,
)
"""Topics that carry the truth: a managing system that reads them is not scored."""
