"""The monitor: collects the symptoms of the managed system for the managing system."""

from functools import partial
from typing import Final, Unpack

from sunset.system import (
    BLACKBOARD_TOPIC,
    DIAGNOSTICS_TOPIC,
    GAP_S,
    MovingMean,
    Rate,
    age_entry,
    current_system,
    frequency_entry,
    full_name,
    heartbeat_entry,
    state_entry,
)
from sunset.system_interfaces.msg import SetBlackboardGroup
from sunset_ros.interfaces import Message, get_message
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from sunset_ros.node import Node, NodeOptions

_PERIOD_S: Final = 0.1


class Monitor(Node):
    """Publishes `/blackboard_group` ten times a second, with the symptoms for the managing system.

    The entries have the names that the published exemplar gives them:

    - `<topic>_freq`: messages of the last second on a topic of the pipeline, `_` in place of `/`, from the first
      message on;
    - `<topic>_age`: seconds since the last message on it, to the millisecond, from the first message on;
    - `<node>_<key>`: a signal of a node, such as `segmentation_entropy` and `camera_sharpness`; for numbers, the mean
      of the last five, from the fifth on; after a gap of a second, from the fifth new number on;
    - `<node>_lc_state`: its lifecycle state, `unknown` after a second without a heartbeat;
    - `<node>_heartbeat_freq`: heartbeats of the last second.
    """

    def __init__(self, **options: Unpack[NodeOptions]) -> None:
        super().__init__("monitor", **options)
        self._topics: dict[str, Rate] = {}
        self._managed = current_system().nodes
        self._heartbeats: dict[str, Rate] = {}
        self._states: dict[str, str] = {}
        self._values: dict[str, MovingMean | bool | str] = {}
        for topic in current_system().topics.values():
            note = partial(self._note, topic.name)
            self.create_subscription(get_message(topic.message_type), full_name(topic.name), note, 10)
        self.create_subscription(DiagnosticArray, DIAGNOSTICS_TOPIC, self._on_diagnostics, 50)
        self._blackboard = self.create_publisher(SetBlackboardGroup, BLACKBOARD_TOPIC, 10)
        self.create_timer(_PERIOD_S, self._publish)

    def _note(self, topic: str, message: Message) -> None:
        del message
        self._topics.setdefault(topic, Rate()).note(self.get_clock().now().nanoseconds)

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        now = self.get_clock().now().nanoseconds
        for status in message.status:
            name = status.hardware_id
            if name not in self._managed:
                continue  # anything may publish on this topic
            self._heartbeats.setdefault(name, Rate()).note(now)
            self._states[name] = status.message
            for item in status.values:
                self._take_value(f"{name}_{item.key}", item.value, now)

    def _take_value(self, key: str, text: str, now_ns: int) -> None:
        if text in {"true", "false"}:
            self._values[key] = text == "true"
            return
        try:
            number = float(text)
        except ValueError:
            self._values[key] = text
            return
        mean = self._values.get(key)
        if not isinstance(mean, MovingMean):
            mean = self._values[key] = MovingMean(GAP_S * 10**9)
        mean.add(now_ns, number)

    def _publish(self) -> None:
        now = self.get_clock().now().nanoseconds
        numbers = {frequency_entry(topic): rate.frequency(now) for topic, rate in self._topics.items()}
        numbers |= {age_entry(topic): rate.age_s(now) for topic, rate in self._topics.items()}
        flags = {key: value for key, value in self._values.items() if isinstance(value, bool)}
        texts = {key: value for key, value in self._values.items() if isinstance(value, str)}
        means = {key: value.value for key, value in self._values.items() if isinstance(value, MovingMean)}
        for name, heartbeats in self._heartbeats.items():
            numbers[heartbeat_entry(name)] = frequency = heartbeats.frequency(now)
            texts[state_entry(name)] = self._states[name] if frequency else "unknown"
        numbers |= {key: mean for key, mean in means.items() if mean is not None}
        kind = ParameterType
        values = {
            **{key: ParameterValue(type=kind.PARAMETER_DOUBLE, double_value=x) for key, x in numbers.items()},
            **{key: ParameterValue(type=kind.PARAMETER_BOOL, bool_value=x) for key, x in flags.items()},
            **{key: ParameterValue(type=kind.PARAMETER_STRING, string_value=x) for key, x in texts.items()},
        }
        group = [Parameter(name=name, value=value) for name, value in values.items()]
        self._blackboard.publish(SetBlackboardGroup(bb_params=group))
