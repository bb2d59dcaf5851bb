"""The greeting: a description of the managed system for a managing system."""

from collections.abc import Mapping
from typing import Any, Final

from sunset.system.vocabulary import (
    REPAIR,
    Adaptation,
    Signal,
    described_nodes,
    described_signals,
    offered_adaptations,
    topic_names,
)

PROTOCOL: Final = 1
"""The version of the protocol of JSON lines."""


def make_greeting(period_s: float, parameters: Mapping[str, object]) -> dict[str, Any]:
    """Return the first line that a program gets, as `docs/programs.md` describes it.

    The parameters of the managing system have thresholds of signals, `task` and `manager_seed`.
    """
    nodes = [
        {
            "name": node.name,
            "inputs": list(node.inputs),
            "outputs": list(node.outputs),
            "state": node.initial_state,
            "activation_delay_s": max(0.0, node.activation_delay_s),
        }
        for node in described_nodes()
    ]
    system = {
        "nodes": nodes,
        "topics": list(topic_names()),
        "signals": [_described_signal(signal, parameters) for signal in described_signals()],
        "adaptations": [_described_adaptation(offered) for offered in offered_adaptations()],
    }
    task, seed = parameters.get("task", REPAIR), parameters.get("manager_seed", 0)
    return {"protocol": PROTOCOL, "system": system, "task": task, "period": period_s, "seed": seed}


def _described_signal(signal: Signal, parameters: Mapping[str, object]) -> dict[str, object]:
    described: dict[str, object] = {"name": signal.name, "node": signal.node, "unit": signal.unit}
    threshold = parameters.get(signal.threshold_name) if signal.calibrated else signal.threshold
    return described if threshold is None else {**described, "threshold": threshold, "below": signal.below}


def _described_adaptation(offered: Adaptation) -> dict[str, object]:
    described: dict[str, object] = {"id": str(offered), "kind": offered.kind.value, "node": offered.node}
    return (
        {**described, "name": offered.parameter, "value": offered.value} if offered.parameter else described
    )
