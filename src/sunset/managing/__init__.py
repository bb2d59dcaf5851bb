"""Managing systems: the base class, the symptoms, and the managing systems that come with SUNSET."""

from sunset.managing.base import ManagingSystem
from sunset.managing.baseline import Baseline
from sunset.managing.command import PREFIX, parse_command
from sunset.managing.diagnosing import Diagnosing
from sunset.managing.greeting import PROTOCOL
from sunset.managing.inspecting import Inspecting
from sunset.managing.known import KnownFault, KnownScenario, UnlistedFault
from sunset.managing.loading import is_registered, load_manager, register_manager
from sunset.managing.names import EXTERNAL, MANAGERS, split_label
from sunset.managing.none import NoAdaptation
from sunset.managing.oracle import ORACLE, Oracle
from sunset.managing.program import Program
from sunset.managing.random_adaptation import RandomAdaptation
from sunset.managing.reactive import Reactive
from sunset.managing.sources import checksum, sources_digest
from sunset.managing.symptoms import FloatOrNaN, Symptoms
from sunset.managing.tools import Waits, Wiring, request
from sunset.system.vocabulary import described_faults

__all__ = [
    "EXTERNAL",
    "MANAGERS",
    "ORACLE",
    "PREFIX",
    "PROTOCOL",
    "Baseline",
    "Diagnosing",
    "FloatOrNaN",
    "Inspecting",
    "KnownFault",
    "KnownScenario",
    "ManagingSystem",
    "NoAdaptation",
    "Oracle",
    "Program",
    "RandomAdaptation",
    "Reactive",
    "Symptoms",
    "UnlistedFault",
    "Waits",
    "Wiring",
    "checksum",
    "described_faults",
    "is_registered",
    "load_manager",
    "parse_command",
    "register_manager",
    "request",
    "sources_digest",
    "split_label",
]
