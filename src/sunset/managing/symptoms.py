"""What a managing system sees of the managed one: the blackboard, as a read-only mapping."""

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from sunset.interfaces.rcl_interfaces.msg import Parameter, ParameterType, ParameterValue

__all__ = ["Symptoms", "Value", "read_parameters"]

Value = bool | int | float | str
"""The value of one entry of the blackboard."""

_NAMESPACE: Final = "/managed_subsystem/"


class Symptoms(Mapping[str, Value]):
    """The blackboard at one moment.

    All entries are there under their names, `symptoms["segmentation_entropy"]`; the properties and methods
    give the common ones with a default for what has not been measured yet. Topics and nodes can be given
    by their short names, such as `rgb_camera`, or their full ones.

    Args:
        values: the entries, by name.
        seen: names of the frequencies that have been above 0 since the managing system started.

    >>> symptoms = Symptoms({"managed_subsystem_rgb_camera_freq": 0.0}, ["managed_subsystem_rgb_camera_freq"])
    >>> symptoms.frequency("rgb_camera"), symptoms.stopped("rgb_camera"), symptoms.entropy
    (0.0, True, nan)
    """

    def __init__(self, values: Mapping[str, Value], seen: Iterable[str] = ()) -> None:
        self._values = dict(values)
        self._seen = frozenset(seen)

    def __getitem__(self, key: str) -> Value:
        return self._values[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"Symptoms({self._values!r})"

    def frequency(self, topic: str) -> float:
        """Return the messages per second on a topic, over the last second; NaN if it is not measured."""
        return self._number(_frequency_key(topic))

    def stopped(self, topic: str) -> bool:
        """Return whether a topic that once had messages has had none for the last second."""
        key = _frequency_key(topic)
        return self._values.get(key) == 0 and key in self._seen

    @property
    def entropy(self) -> float:
        """Mean entropy of the last 5 segmented frames, from 0 (sure) to 1; NaN until there are five."""
        return self._number("segmentation_entropy")

    @property
    def sharpness(self) -> float:
        """Mean sharpness of the camera's last 5 images; NaN until there are five."""
        return self._number("camera_sharpness")

    @property
    def autofocus_needed(self) -> bool:
        """Whether the camera finds its own images blurred."""
        return self._values.get("camera_autofocus_needed") is True

    def state(self, node: str) -> str:
        """Return a node's lifecycle state, such as `active`; `unknown` while its heartbeat is not heard."""
        return str(self._values.get(f"{_short(node)}_lc_state", "unknown"))

    def heartbeat(self, node: str) -> float:
        """Return a node's heartbeats per second, over the last second; NaN if it was never heard."""
        return self._number(f"{_short(node)}_heartbeat_freq")

    def _number(self, key: str) -> float:
        value = self._values.get(key)
        return math.nan if value is None or isinstance(value, str) else float(value)


def read_parameters(parameters: Iterable[Parameter]) -> dict[str, Value]:
    """Return the values of a message's parameters; those of types that a blackboard has not are left out."""
    values = {}
    for parameter in parameters:
        value = _value(parameter.value)
        if value is not None:
            values[parameter.name] = value
    return values


def _value(value: ParameterValue) -> Value | None:
    match value.type:
        case ParameterType.PARAMETER_DOUBLE:
            return value.double_value
        case ParameterType.PARAMETER_BOOL:
            return value.bool_value
        case ParameterType.PARAMETER_STRING:
            return value.string_value
        case ParameterType.PARAMETER_INTEGER:
            return value.integer_value
        case _:
            return None


def _short(node: str) -> str:
    return node.rsplit("/", 1)[-1]


def _frequency_key(topic: str) -> str:
    full = topic if topic.startswith("/") else _NAMESPACE + topic
    return f"{full.strip('/').replace('/', '_')}_freq"
