"""The managed system as data: nodes, topics, signals, failures, faults, adaptations, suites, and what is off limits."""

from sunset.system.checks import LONGEST_DELAY_S
from sunset.system.current import (
    LoadedExtension,
    current_system,
    extended_system,
    get_fault,
    load_extension,
    loaded_extensions,
)
from sunset.system.description import (
    Adaptation,
    AdaptationKind,
    Effect,
    Failure,
    Fault,
    FaultKind,
    ImageFunction,
    NodeDescription,
    Signal,
    Topic,
    Value,
)
from sunset.system.harness import (
    HARNESS,
    INFRASTRUCTURE,
    MANAGER_PROCESS,
    OFF_LIMITS_TOPICS,
    RESULT_TOPIC,
    SENSOR_TOPICS,
    SURROUNDING,
    HarnessNode,
)
from sunset.system.names import NAMESPACE, frequency_entry, full_name, scenario_name, short_name
from sunset.system.paper import BLUR_SIGMA, DEPTH_DEGRADATION_RANGE, IMAGE_DEGRADATION_RANGE
from sunset.system.system import Extension, System
from sunset.system.window import DURATION_S, PERIOD_S, SILENCE_S, WINDOW, MovingMean, Window

__all__ = [
    "BLUR_SIGMA",
    "DEPTH_DEGRADATION_RANGE",
    "DURATION_S",
    "HARNESS",
    "IMAGE_DEGRADATION_RANGE",
    "INFRASTRUCTURE",
    "LONGEST_DELAY_S",
    "MANAGER_PROCESS",
    "NAMESPACE",
    "OFF_LIMITS_TOPICS",
    "PERIOD_S",
    "RESULT_TOPIC",
    "SENSOR_TOPICS",
    "SILENCE_S",
    "SURROUNDING",
    "WINDOW",
    "Adaptation",
    "AdaptationKind",
    "Effect",
    "Extension",
    "Failure",
    "Fault",
    "FaultKind",
    "HarnessNode",
    "ImageFunction",
    "LoadedExtension",
    "MovingMean",
    "NodeDescription",
    "Signal",
    "System",
    "Topic",
    "Value",
    "Window",
    "current_system",
    "extended_system",
    "frequency_entry",
    "full_name",
    "get_fault",
    "load_extension",
    "loaded_extensions",
    "scenario_name",
    "short_name",
]
