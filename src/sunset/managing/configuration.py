"""The settings of the managed system: present values, and values that a managing system wants."""

from collections.abc import Mapping
from functools import partial
from typing import Any, Final

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.tools import Wiring
from sunset.system.vocabulary import (
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    Value,
    described_faults,
    described_nodes,
    described_views,
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


def view_setting() -> Setting:
    """Return the parameter that chooses the sensors of the pipeline."""
    setting = described_views()[0].setting
    return setting.node, setting.parameter


def settings_without() -> dict[str, tuple[Setting, Value]]:
    """Return full name of a sensor's topic → the setting with which the pipeline works without the sensor."""
    healthy, *others = described_views()
    return {
        full_name(topic): (view_setting(), view.setting.value)
        for view in others
        for node in described_nodes()
        for topic in node.outputs
        if {node.name} == healthy.sensors - view.sensors and view.setting.value is not None
    }


def healthy_settings() -> dict[Setting, Value]:
    """Return the known settings of a healthy system."""
    faults = described_faults().values()
    healthy = {(fault.node, fault.parameter): fault.healthy for fault in faults if is_of_configuration(fault)}
    healthy[view_setting()] = described_views()[0].setting.value
    healthy |= {setting: fault.value for fault in faults for setting in _strengths(fault, *fault.cures[:1])}
    return {setting: value for setting, value in healthy.items() if value is not None}


def is_of_configuration(fault: Fault) -> bool:
    """Return whether a fault is a wrong value of a parameter, which can be read."""
    return fault.kind is FaultKind.CONFIGURATION


def _strengths(fault: Fault, cure: tuple[Adaptation, ...] = ()) -> list[Setting]:
    """Return the parameters with which the nodes of a cure get the strength of a fault."""
    restores = fault.effect is not None and fault.effect.restore is not None
    return [
        (step.node, fault.parameter) for step in cure if restores and step.kind is AdaptationKind.ACTIVATE
    ]


def settings_of(
    cure: tuple[Adaptation, ...], fault: Fault | None = None, strength: Value | None = None
) -> dict[Setting, Value] | None:
    """Return the settings of a cure, with the fault's strength if it is known; None for a cure such as a restart."""
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
    if fault is not None and strength is not None:
        settings |= dict.fromkeys(_strengths(fault, cure), strength)
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

    def redeploy(self, node: str) -> None:
        """Redeploy a node, which forgets its settings."""
        self._manager.redeploy(node)
        self._redeployed_s[node] = self._manager.now_s
        for known in (self._present, self._read):
            for setting in [setting for setting in known if setting[0] == node]:
                del known[setting]

    def see(self, symptoms: Symptoms) -> None:
        """Note the nodes that are back."""
        back = [
            node
            for node, since_s in self._redeployed_s.items()
            if self._manager.now_s - since_s > self.boot_s[node] and symptoms.state(node) == "active"
        ]
        for node in back:
            del self._redeployed_s[node]

    def read(self, faults: Mapping[str, Fault]) -> None:
        """Read the parameters of configuration faults."""
        for fault in filter(is_of_configuration, faults.values()):
            setting = node, parameter = fault.node, fault.parameter
            if node not in self._readers:
                service = f"{full_name(node)}/get_parameters"
                self._readers[node] = self._manager.create_client(GetParameters, service)
            if self._readers[node].service_is_ready():
                future = self._readers[node].call_async(GetParameters.Request(names=[parameter]))
                future.add_done_callback(partial(self._on_value, setting))

    def _on_value(self, setting: Setting, future: Future[Any]) -> None:
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
