"""How a managing system wants the managed one to be set, and what is set by now."""

from collections.abc import Mapping
from typing import Final

from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.managing.wiring import Wiring
from sunset.system.vocabulary import (
    Adaptation,
    AdaptationKind,
    Sensor,
    Value,
    described_faults,
    full_name,
)

Setting = tuple[str, str]
"""A node and its parameter; an empty parameter is for whether the node is active."""

MODALITY: Final = ("sensor_fusion", "modality")

SEEN: Final[Mapping[Value, frozenset[Sensor]]] = {
    0: frozenset({"camera", "depth"}),
    1: frozenset({"camera"}),
    2: frozenset({"depth"}),
}
"""Modality → the sensors that the segmentation sees with it."""

WITHOUT: Final[Mapping[str, tuple[Setting, Value]]] = {
    full_name("rgb_camera"): (MODALITY, 2),
    full_name("depth_camera"): (MODALITY, 1),
}
"""Full name of a topic → the setting by which the pipeline works without it."""

_STRENGTH: Final = ("image_enhancement", "image_degradation")
"""The strength that the enhancement undoes."""


def healthy_settings() -> dict[Setting, Value]:
    """Return the settings of a system that was not changed, as far as they are known."""
    return {
        MODALITY: 0,
        ("sensor_fusion", "topic_camera_input"): "rgb_camera",
        _STRENGTH: described_faults()[_STRENGTH[1]].value,
    }


def settings_of(cure: tuple[Adaptation, ...], strength: Value | None = None) -> dict[Setting, Value] | None:
    """Return a cure as settings that last; None if it is something that is done once, such as a restart.

    Args:
        cure: adaptations.
        strength: that of the fault, where it is known, which the enhancement is told.
    """
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
        if strength is not None and step.node == _STRENGTH[0]:
            settings[_STRENGTH] = strength
    return settings


class Configuration:
    """Sets what is wanted, and back what is not wanted any more; a redeployed node is set again while it boots.

    Args:
        manager: who wants it.
    """

    def __init__(self, manager: ManagingSystem) -> None:
        self._manager = manager
        self._healthy = healthy_settings()
        self._present: dict[Setting, Value] = {}
        self._redeployed_s: dict[str, float] = {}
        self._boot_s = Wiring().boot_s

    @property
    def booting(self) -> frozenset[str]:
        """The nodes that were redeployed and are not active yet."""
        return frozenset(self._redeployed_s)

    def boot_s(self, node: str) -> float:
        """Return how long a node is away for a redeploy [s]."""
        return self._boot_s[node]

    def get(self, setting: Setting) -> Value | None:
        """Return the value of a setting, as far as it is known."""
        return self._present.get(setting, self._healthy.get(setting))

    def redeploy(self, node: str) -> None:
        """Redeploy a node, which forgets its settings."""
        self._manager.redeploy(node)
        self._redeployed_s[node] = self._manager.now_s
        self._present = {key: value for key, value in self._present.items() if key[0] != node}

    def see(self, symptoms: Symptoms) -> None:
        """Take note of the nodes that are back."""
        back = [
            node
            for node, since_s in self._redeployed_s.items()
            if self._manager.now_s - since_s > self._boot_s[node] and symptoms.state(node) == "active"
        ]
        for node in back:
            del self._redeployed_s[node]

    def want(self, wanted: Mapping[Setting, Value], symptoms: Symptoms) -> None:
        """Set what is wanted and is not so yet, and undo what was set and is not wanted any more."""
        undone = {key: self._healthy.get(key, False) for key in self._present if key not in wanted}
        for (node, parameter), value in (undone | dict(wanted)).items():
            is_known = bool(
                not parameter or (node, parameter) in self._healthy or (node, parameter) in wanted
            )
            is_away = node in self._redeployed_s and symptoms.state(node) != "inactive"
            if is_away or not is_known or self.get((node, parameter)) == value:
                continue
            self._present[node, parameter] = value
            if parameter:
                self._manager.set_parameter(node, parameter, value)
            elif value and symptoms.state(node) != "active":
                self._manager.activate(node)
            elif not value and symptoms.state(node) == "active":
                self._manager.deactivate(node)
