"""Tools for managing systems: topics between nodes, cool-downs, thresholds, adaptations of the catalogue, settings."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Final, cast

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import FloatOrNaN, Symptoms
from sunset.system.vocabulary import (
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    Value,
    current_system,
    full_name,
)
from sunset_ros.client import AnyClient
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters
from sunset_ros.parameter import scalar_of
from sunset_ros.task import Future

Setting = tuple[str, str]
"""A node and its parameter; the parameter is empty for whether the node is active."""

_SET_S: Final = 0.5
"""The time until a value that was set can be read."""


class Wiring:
    """The topics between the managed nodes of a healthy system, by their full names.

    Attributes:
        publisher: topic → the node that publishes on it.
        inputs: node → the topics that it gets from other nodes.
        topics: the topics of active nodes that the monitor watches.
        boot_s: node → the time that it takes to boot [s].
    """

    def __init__(self) -> None:
        nodes = current_system().nodes.values()
        self.publisher = current_system().publishers
        self.inputs = {
            node.name: tuple(topic for topic in map(full_name, node.inputs) if topic in self.publisher)
            for node in nodes
        }
        self.boot_s = {node.name: max(0.0, node.activation_delay_s) for node in nodes}
        active = {node.name for node in nodes if node.initial_state == "active"}
        self.topics = tuple(
            topic for topic in map(full_name, current_system().topics) if self.publisher.get(topic) in active
        )

    def first_silent(self, symptoms: Symptoms) -> str:
        """Return the node furthest upstream whose topic has stopped; an empty text if no topic has stopped."""
        silent = [topic for topic in self.topics if symptoms.stopped(topic)]
        sources = [self.publisher[topic] for topic in silent]
        return next((node for node in sources if not set(silent).intersection(self.topics_before(node))), "")

    def topics_before(self, node: str) -> list[str]:
        """Return the watched topics of all nodes upstream of a node."""
        before = [
            topic for source in self.inputs[node] for topic in self.topics_until(self.publisher[source])
        ]
        return list(dict.fromkeys(before))

    def topics_until(self, node: str) -> list[str]:
        """Return the watched topics of a node and of all nodes upstream of it."""
        return [*self.topics_before(node), *(topic for topic in self.topics if self.publisher[topic] == node)]


class Waits:
    """Cool-downs by name, in the experiment's time.

    Args:
        manager: the managing system that waits.
    """

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._until_s: dict[str, float] = {}

    def start(self, name: str, seconds: float) -> None:
        """Begin a wait now, also if a wait of this name has begun already."""
        self._until_s[name] = self._manager.now_s + seconds

    def over(self, name: str) -> bool:
        """Return whether a wait is over, or has never begun."""
        return self._manager.now_s >= self._until_s.get(name, 0.0)


class Thresholds:
    """The thresholds of all signals; thresholds of the model's card are parameters of the managing system."""

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._signals = current_system().signals
        for signal in self._signals.values():
            if signal.calibrated and not manager.has_parameter(signal.threshold_name):
                manager.declare_parameter(signal.threshold_name, 0.0)

    def badness(self, name: str, symptoms: Symptoms) -> float:
        """Return a signal, negated if low is bad; NaN until it is measured."""
        value = symptoms.signal(name)
        return -value if self._signals[name].below else value

    def threshold(self, name: str) -> FloatOrNaN:
        """Return the threshold of a signal; NaN without a threshold."""
        signal = self._signals[name]
        if signal.calibrated:
            return cast("float", self._manager.get_parameter(signal.threshold_name).value)
        return math.nan if signal.threshold is None else signal.threshold

    def is_beyond(self, name: str, symptoms: Symptoms) -> bool:
        """Return whether a signal is on the wrong side of its threshold; False without a threshold."""
        return self._signals[name].is_beyond(symptoms.signal(name), self.threshold(name))


def request(manager: ManagingSystem, adaptation: Adaptation) -> Future[bool]:
    """Let a managing system do an adaptation, such as a step of a fault's cure.

    Returns:
        The future that the method of `ManagingSystem` for this kind of adaptation returns.
    """
    arguments = (adaptation.parameter, adaptation.value) if adaptation.parameter else ()
    future: Future[bool] = getattr(manager, adaptation.kind)(adaptation.node, *arguments)
    return future


def view_setting() -> Setting:
    """Return the parameter that chooses the sensors of the pipeline."""
    setting = current_system().views[0].setting
    return setting.node, setting.parameter


def settings_without() -> dict[str, tuple[Setting, Value]]:
    """Return full name of a sensor's topic → the setting with which the pipeline works without the sensor."""
    healthy, *others = current_system().views
    return {
        full_name(topic): (view_setting(), view.setting.value)
        for view in others
        for node in current_system().nodes.values()
        for topic in node.outputs
        if {node.name} == healthy.sensors - view.sensors and view.setting.value is not None
    }


def configuration_faults() -> list[Fault]:
    """Return the faults that are wrong values of parameters, which can be read."""
    return [fault for fault in current_system().faults.values() if fault.kind is FaultKind.CONFIGURATION]


def healthy_settings() -> dict[Setting, Value]:
    """Return the known settings of a healthy system."""
    healthy = {(fault.node, fault.parameter): fault.healthy for fault in configuration_faults()}
    healthy[view_setting()] = current_system().views[0].setting.value
    for fault in current_system().faults.values():
        healthy |= dict.fromkeys(strengths_of(fault), fault.value)
    return {setting: value for setting, value in healthy.items() if value is not None}


def strengths_of(fault: Fault) -> list[Setting]:
    """Return the parameters with which the nodes of the cheapest cure get the strength of a fault."""
    restores = fault.effect is not None and fault.effect.restore is not None
    steps = fault.cures[0] if restores and fault.cures else ()
    return [(step.node, fault.parameter) for step in steps if step.kind is AdaptationKind.ACTIVATE]


def settings_of(cure: tuple[Adaptation, ...]) -> dict[Setting, Value] | None:
    """Return the settings of a cure; None for a cure such as a restart."""
    settings: dict[Setting, Value] = {}
    for step in cure:
        if step.kind is AdaptationKind.ACTIVATE:
            settings[step.node, ""] = True
        elif step.kind is AdaptationKind.DEACTIVATE:
            settings[step.node, ""] = False
        elif step.parameter and step.value is not None:
            settings[step.node, step.parameter] = step.value
        else:
            return None
    return settings


class Configuration:
    """Sets wanted settings and restores others; sets a redeployed node again while it boots.

    It never deactivates a node that it activated: an idle node does no harm, and a transition has a price.

    Args:
        manager: the managing system.

    Attributes:
        boot_s: node → the time that it takes to boot [s].
    """

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._healthy = healthy_settings()
        self._present: dict[Setting, Value] = {}
        self._set_s: dict[Setting, float] = {}
        self._read: dict[Setting, Value | None] = {}
        self._readers: dict[str, AnyClient] = {}
        self._redeployed_s: dict[str, float] = {}
        self.boot_s = Wiring().boot_s

    @property
    def booting(self) -> frozenset[str]:
        """The redeployed nodes that are not active yet."""
        return frozenset(self._redeployed_s)

    def get(self, setting: Setting) -> Value | None:
        """Return the value that was set, or the value of a healthy system; None if it is unknown."""
        return self._present.get(setting, self._healthy.get(setting))

    def do(self, step: Adaptation) -> None:
        """Request a step of a cure; a node that is redeployed forgets its settings."""
        request(self._manager, step)
        if step.kind is AdaptationKind.REDEPLOY:
            self._redeployed_s[step.node] = self._manager.now_s
            for known in (self._present, self._read):
                for setting in [setting for setting in known if setting[0] == step.node]:
                    del known[setting]

    def see(self, symptoms: Symptoms) -> None:
        """Note the nodes that are back."""
        now_s = self._manager.now_s
        for node, since_s in [*self._redeployed_s.items()]:
            if now_s - since_s > self.boot_s[node] and symptoms.state(node) == "active":
                del self._redeployed_s[node]

    def read(self) -> None:
        """Read the parameters of configuration faults."""
        for fault in configuration_faults():
            setting = node, parameter = fault.node, fault.parameter
            if node not in self._readers:
                service = f"{full_name(node)}/get_parameters"
                self._readers[node] = self._manager.create_client(GetParameters, service)
            if self._readers[node].service_is_ready():
                future = self._readers[node].call_async(GetParameters.Request(names=[parameter]))
                future.add_done_callback(partial(self._on_value, setting))

    def _on_value(self, setting: Setting, future: Future[GetParameters.Response]) -> None:
        response = future.result()
        if response is not None and response.values and setting[0] not in self._redeployed_s:
            self._read[setting] = scalar_of(response.values[0])

    def is_wrong(self, fault: Fault) -> bool | None:
        """Return whether a configuration fault is present; None if that is unknown."""
        setting = fault.node, fault.parameter
        if setting not in self._read:
            return None
        is_as_set = self._manager.now_s - self._set_s.get(setting, -_SET_S) >= _SET_S
        return is_as_set and self._read[setting] == fault.value != self.get(setting)

    def want(self, wanted: Mapping[Setting, Value], symptoms: Symptoms) -> None:
        """Set the wanted settings that differ, and restore settings that are not wanted any more."""
        undone = {key: self._healthy[key] for key in self._present if key in self._healthy}
        for setting, value in (undone | dict(wanted)).items():
            node, parameter = setting
            is_away = node in self._redeployed_s and symptoms.state(node) != "inactive"
            if is_away or self.get(setting) == value:
                continue
            if parameter:
                self.set(setting, value)
            else:
                self._present[setting] = value
                if value and symptoms.state(node) != "active":
                    self._manager.activate(node)
                elif not value and symptoms.state(node) == "active":
                    self._manager.deactivate(node)

    def set(self, setting: Setting, value: Value) -> None:
        """Set a parameter."""
        self._present[setting], self._set_s[setting] = value, self._manager.now_s
        self._manager.set_parameter(*setting, value)
