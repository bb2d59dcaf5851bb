"""The nodes that surround the managed system, and what a managing system must leave alone."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

BAG_PLAYER: Final = "bag_player"
SCENARIO_EXECUTOR: Final = "scenario_executor"
EXPERIMENT: Final = "experiment"
"""The node that conducts an experiment."""
MANAGING_SYSTEM: Final = "managing_system"
"""What the managing system's node is called, unless its class says otherwise."""

MANAGER_PROCESS: Final = "manager"
"""The name of the process that the managing system's nodes are in."""

REPAIR: Final = "repair"
"""The task in which a managing system adapts the managed one."""
DIAGNOSE: Final = "diagnose"
"""The task in which adaptations are refused, so that a managing system can only say what is wrong."""
TASKS: Final = (REPAIR, DIAGNOSE)

RESULT_TOPIC: Final = "/managed_subsystem/segmentation"
"""The pipeline's output: there are messages on it only where all before it works."""

SENSOR_TOPICS: Final = ("/rgb_raw", "/depth_raw")
"""The bag's images, which only the sensors of the managed system subscribe to."""


TRUTH_TOPIC: Final = "/gt_segmentation"
"""What the segmentation should be, as the bag has it."""
CLOCK_TOPIC: Final = "/clock"
"""The time of the experiment."""
DIAGNOSTICS_TOPIC: Final = "/diagnostics"
"""Heartbeats, with what nodes report."""
BLACKBOARD_TOPIC: Final = "/blackboard_group"
"""What the monitor tells managing systems."""
DIAGNOSIS_TOPIC: Final = "/managing_system/diagnosis"
"""What a managing system takes to be wrong, if it says so (`system_interfaces/msg/Diagnosis`)."""
EVALUATION_TOPIC: Final = "/seg_metrics"
"""How well each frame was segmented."""
INJECTIONS_TOPIC: Final = "/experiment/injections"
"""Which faults were injected."""
FAULT_ENDS_TOPIC: Final = "/experiment/fault_ends"
"""Which of them healed or were cured."""
LOG_TOPIC: Final = "/experiment/log"
"""When the experiment began and ended."""
COMMANDS_TOPIC: Final = "/experiment/commands"
"""What the record says of requests to the managed system (`system_interfaces/msg/Command`)."""
PARAMETER_EVENTS_TOPIC: Final = "/parameter_events"
"""On which every node publishes changes of its parameters; managed nodes leave out what the experiment injects."""
INJECTED_EVENTS_TOPIC: Final = "/experiment/parameter_events"
"""On which managed nodes publish changes of fault parameters, and of other parameters that the experiment sets."""
PARAMETER_TOPICS: Final = (PARAMETER_EVENTS_TOPIC, INJECTED_EVENTS_TOPIC)
"""On which all changes of parameters are published, each once."""


@dataclass(frozen=True, slots=True)
class HarnessNode:
    """A node of the experiment.

    Attributes:
        name: its name.
        node_class: where the class is that a process of it runs, as `module:Class`; empty if none does.
        outputs: the topics that no other node may publish on.
        commands: whether what it asks of the managed system is the experiment's own, such as to inject faults.
        off_limits: whether a managing system must not call its services.
    """

    name: str
    node_class: str = ""
    outputs: tuple[str, ...] = ()
    commands: bool = False
    off_limits: bool = True


HARNESS: Final[Mapping[str, HarnessNode]] = MappingProxyType(
    {
        node.name: node
        for node in (
            HarnessNode(
                BAG_PLAYER,
                "sunset.harness.live_bag_player:LiveBagPlayer",
                (*SENSOR_TOPICS, TRUTH_TOPIC, CLOCK_TOPIC),
            ),
            HarnessNode("monitor", "sunset.harness.monitor:Monitor", (BLACKBOARD_TOPIC,), off_limits=False),
            HarnessNode("evaluator", "sunset.harness.evaluator:Evaluator", (EVALUATION_TOPIC,)),
            HarnessNode(
                SCENARIO_EXECUTOR,
                "sunset.harness.executor:ScenarioExecutor",
                (INJECTIONS_TOPIC, FAULT_ENDS_TOPIC),
                commands=True,
            ),
            HarnessNode(
                "image_views", "sunset.harness.image_views:ImageViews", ("/views/depth", "/views/labels")
            ),
            HarnessNode("launcher", commands=True, off_limits=False),
            HarnessNode(EXPERIMENT, outputs=(LOG_TOPIC,), commands=True),
        )
    }
)
"""The nodes of an experiment that are not managed, by name; `image_views` runs only where a user starts it."""

RESERVED_NAMES: Final = frozenset({*HARNESS, MANAGER_PROCESS, MANAGING_SYSTEM, "operator"})
"""What no managed node may be called."""

SURROUNDING: Final = (BAG_PLAYER, "monitor", "evaluator")
"""Those that feed and watch the managed system, whether there is an experiment or not."""

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
