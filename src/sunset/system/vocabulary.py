"""The part of the description that managing systems may know: nodes, topics, signals, and the catalogue of faults.

The catalogue lists how each possible fault shows, and its cures. The faults of a run are not here. The experiment's
topics are here for the oracle, the only managing system that may read them.
"""
# ruff: noqa: PLC0414  the names are imported to be exported

from collections.abc import Mapping

from sunset.system.current import current_system as current_system
from sunset.system.description import Adaptation as Adaptation
from sunset.system.description import AdaptationKind as AdaptationKind
from sunset.system.description import Failure as Failure
from sunset.system.description import Fault as Fault
from sunset.system.description import FaultKind as FaultKind
from sunset.system.description import Signal as Signal
from sunset.system.description import Value as Value
from sunset.system.description import View as View
from sunset.system.description import redeploy as redeploy
from sunset.system.description import restart as restart
from sunset.system.harness import BLACKBOARD_TOPIC as BLACKBOARD_TOPIC
from sunset.system.harness import COST_TOPIC as COST_TOPIC
from sunset.system.harness import DIAGNOSIS_TOPIC as DIAGNOSIS_TOPIC
from sunset.system.harness import FAULT_ENDS_TOPIC as FAULT_ENDS_TOPIC
from sunset.system.harness import INJECTIONS_TOPIC as INJECTIONS_TOPIC
from sunset.system.harness import MANAGING_SYSTEM as MANAGING_SYSTEM
from sunset.system.harness import REPAIR as REPAIR
from sunset.system.harness import RESULT_TOPIC as RESULT_TOPIC
from sunset.system.names import age_entry as age_entry
from sunset.system.names import frequency_entry as frequency_entry
from sunset.system.names import full_name as full_name
from sunset.system.names import heartbeat_entry as heartbeat_entry
from sunset.system.names import state_entry as state_entry
from sunset.system.paper import ENTROPY_SIGNAL as ENTROPY_SIGNAL
from sunset.system.paper import SHARPNESS_SIGNAL as SHARPNESS_SIGNAL
from sunset.system.window import PERIOD_S as PERIOD_S


def described_faults() -> Mapping[str, Fault]:
    """Return the catalogue of faults, by name."""
    return current_system().faults
