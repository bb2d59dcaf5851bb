"""The symptoms that a managing system sees, as a read-only mapping; and the greeting, which describes the system."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Final, NoReturn

from sunset.system.vocabulary import (
    ENTROPY_SIGNAL,
    REPAIR,
    RESULT_TOPIC,
    SHARPNESS_SIGNAL,
    Adaptation,
    Signal,
    Value,
    age_entry,
    current_system,
    frequency_entry,
    heartbeat_entry,
    state_entry,
)
from sunset.texts.names import base_name
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter
from sunset_ros.parameter import scalar_of
from sunset_ros.texts import shorten, suggestion

FloatOrNaN = Annotated[float, "NaN until it is measured"]
"""A measured number, or NaN until it is measured. NaN is neither over nor under any threshold."""

PROTOCOL: Final = 1
"""The version of the protocol of JSON lines."""

DEFAULT_ENTROPY_THRESHOLD: Final = 0.06
"""The threshold of the published model."""


class Symptoms(Mapping[str, Value]):
    """The blackboard at one moment.

    It maps the names of entries to values, such as `symptoms["segmentation_entropy"]`, as soon as they are measured.
    Properties and methods return the common entries. Until they are measured, numbers are NaN, which compares false
    with every threshold, and conditions are False. Topics and nodes have short names, such as `rgb_camera`, or full
    names. An unknown topic, node or signal raises a ValueError.

    Args:
        values: the entries, by name.
        entropy_threshold: entropy above which the segmentation counts as unsure, from 0 to 1.

    >>> symptoms = Symptoms({"managed_subsystem_rgb_camera_freq": 0.0})
    >>> symptoms.frequency("rgb_camera"), symptoms.stopped("rgb_camera"), symptoms.entropy, symptoms.unsure
    (0.0, True, nan, False)
    """

    def __init__(
        self,
        values: Mapping[str, Value],
        *,
        entropy_threshold: float = DEFAULT_ENTROPY_THRESHOLD,
    ) -> None:
        self._values = dict(values)
        self._entropy_threshold = entropy_threshold

    def __getitem__(self, key: str) -> Value:
        if key not in self._values:
            raise KeyError(_missing_text(key, self._values))
        return self._values[key]

    def __contains__(self, key: object) -> bool:
        return key in self._values

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    if not TYPE_CHECKING:  # a type checker should find unknown attributes

        def __getattr__(self, name: str) -> NoReturn:
            """Refuse an unknown attribute."""
            known = [attribute for attribute in dir(type(self)) if not attribute.startswith("_")]
            raise AttributeError(
                f"Symptoms have no {name!r}: {suggestion(name, known)}name one of {', '.join(known)}.",
                name=name,
            )

    def __repr__(self) -> str:
        return f"Symptoms({self._values!r})"

    def signal(self, name: str) -> FloatOrNaN:
        """Return the mean of a signal's last 5 samples, such as `segmentation_entropy`; NaN until there are five."""
        return self._number("signal", name, str)

    def frequency(self, topic: str) -> FloatOrNaN:
        """Return the messages per second on a topic, over the last second; NaN until the first came."""
        return self._number("topic", topic, frequency_entry)

    def age(self, topic: str) -> FloatOrNaN:
        """Return how long ago the last message on a topic came [s]; NaN until the first came."""
        return self._number("topic", topic, age_entry)

    def stopped(self, topic: str) -> bool:
        """Return whether a topic that once had messages has had none for the last second."""
        return self.frequency(topic) == 0

    @property
    def up(self) -> bool:
        """Whether the managed system has come up: True from the first segmented frame on."""
        return frequency_entry(RESULT_TOPIC) in self

    @property
    def entropy(self) -> FloatOrNaN:
        """Mean entropy of the last 5 segmented frames, from 0 (sure) to 1; NaN until there are five."""
        return self.signal(ENTROPY_SIGNAL.name)

    @property
    def unsure(self) -> bool:
        """Whether the entropy is over its threshold; False until there are five segmented frames."""
        return self.entropy > self._entropy_threshold

    @property
    def sharpness(self) -> FloatOrNaN:
        """Mean sharpness of the camera's last 5 images; NaN until there are five."""
        return self.signal(SHARPNESS_SIGNAL.name)

    @property
    def autofocus_needed(self) -> bool:
        """Whether the camera finds its own images blurred; False until there are five."""
        return self._values.get("camera_autofocus_needed") is True

    def state(self, node: str) -> str:
        """Return a node's lifecycle state, such as `active`; `unknown` while its heartbeat is missing."""
        return str(self._values.get(self._key("node", node, state_entry), "unknown"))

    def heartbeat(self, node: str) -> FloatOrNaN:
        """Return a node's heartbeats per second, over the last second; NaN until the first came."""
        return self._number("node", node, heartbeat_entry)

    def _key(self, kind: str, name: str, entry: Callable[[str], str]) -> str:
        """Return the name of an entry; an unknown name is a mistake of the caller."""
        system = current_system()
        known = {"signal": system.signals, "topic": system.topics, "node": system.nodes}[kind]
        key = entry(base_name(str(name)) if kind == "node" else str(name))
        if key not in self and key not in map(entry, known):
            raise ValueError(
                f"There is no {kind} {shorten(repr(name), 100)}: {suggestion(str(name), known)}name one of "
                f"{', '.join(known)}. If an extension adds it, pass --extension."
            )
        return key

    def _number(self, kind: str, name: str, entry: Callable[[str], str]) -> FloatOrNaN:
        value = self._values.get(self._key(kind, name, entry))
        return math.nan if value is None or isinstance(value, str) else float(value)


def read_parameters(parameters: Iterable[Parameter]) -> dict[str, Value]:
    """Return the values of a message's parameters, without types that a blackboard cannot hold."""
    values = ((parameter.name, scalar_of(parameter.value)) for parameter in parameters)
    return {name: value for name, value in values if value is not None}


def _missing_text(key: object, values: Iterable[str]) -> str:
    system = current_system()
    known = {*map(frequency_entry, system.topics), *map(age_entry, system.topics), *system.signals}
    if key in known:
        return f"The blackboard does not have {key!r} yet; symptoms.get({key!r}) is None until it does."
    names = sorted(known.union(values))
    quoted = shorten(repr(key), 100)
    return (
        f"The blackboard has no entry {quoted}: {suggestion(str(key), names)}name one of {', '.join(names)}."
    )


def make_greeting(period_s: float, parameters: Mapping[str, object]) -> dict[str, object]:
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
        for node in current_system().nodes.values()
    ]
    system = {
        "nodes": nodes,
        "topics": list(current_system().topics),
        "signals": [_described_signal(signal, parameters) for signal in current_system().signals.values()],
        "adaptations": [
            _described_adaptation(offered) for offered in sorted(current_system().adaptations, key=str)
        ],
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
