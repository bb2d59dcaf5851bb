"""The catalogue: every fault, the failure it shows as, and exactly which adaptations cure it.

A fault is *cured* when its symptom is gone and the segmentation is as good as before; what a cure of
the catalogue does not list must not cure. Nothing here is code that does something: nodes, scenarios,
tests and documentation read it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Final

from sunset.errors import ScenarioError
from sunset.faults.degradations import DEPTH_DEGRADATION_RANGE, IMAGE_DEGRADATION_RANGE
from sunset.texts import suggestion

__all__ = [
    "ADAPTATIONS",
    "EXCLUSIVE",
    "FAULTS",
    "Adaptation",
    "AdaptationKind",
    "Failure",
    "Fault",
    "FaultKind",
    "Value",
    "get_fault",
]

Value = bool | int | float | str
"""The value of a ROS parameter, as far as faults and adaptations need them."""


class Failure(StrEnum):
    """What is observed when something is wrong (paper, section 3.3)."""

    F1 = "F1"
    F2 = "F2"
    F3 = "F3"
    F4 = "F4"
    F5 = "F5"

    @property
    def description(self) -> str:
        """What one sees, in a few words."""
        return _FAILURES[self]


_FAILURES = {
    Failure.F1: "the camera sends no images",
    Failure.F2: "the sensor fusion sends no images",
    Failure.F3: "the segmentation sends no results",
    Failure.F4: "the segmentation is unsure of its results",
    Failure.F5: "the camera's images are blurred",
}


class FaultKind(StrEnum):
    """Where a fault lives, which decides how long it lives."""

    INTERNAL = "internal"
    """In a node: it ends with the node's process at the latest."""
    EXTERNAL = "external"
    """In the world: it outlasts a redeploy, and the pipeline can only work around it."""
    CONFIGURATION = "configuration"
    """In how the nodes are connected: it outlasts a redeploy too."""


class AdaptationKind(StrEnum):
    """What a managing system can do to the managed one."""

    RESTART = "restart"
    """Lifecycle deactivate, then activate."""
    REDEPLOY = "redeploy"
    """The node's process ends and a new one starts."""
    SET_PARAMETER = "set_parameter"
    CHANGE_TOPIC = "change_topic"
    """Set a parameter that names the topic that the node subscribes to."""
    ACTIVATE = "activate"
    DEACTIVATE = "deactivate"


@dataclass(frozen=True, slots=True)
class Adaptation:
    """One adaptation of one node.

    Attributes:
        kind: what is done.
        node: the node's name without namespace.
        parameter: the parameter that is set; empty where none is.
        value: what it is set to; None where none is.
    """

    kind: AdaptationKind
    node: str
    parameter: str = ""
    value: Value | None = None

    def __str__(self) -> str:
        """Return it in words, such as `set sensor_fusion.modality to 1` or `restart camera`."""
        if self.parameter:
            value = str(self.value).lower() if isinstance(self.value, bool) else self.value
            return f"set {self.node}.{self.parameter} to {value}"
        return f"{self.kind} {self.node}"


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault of the catalogue.

    Attributes:
        name: its name in scenarios, and for most the parameter that injects it.
        failure: the failure that it shows as first.
        node: the node that it is injected into, without namespace.
        parameter: the parameter that injects it.
        value: the value that injects it, at the strength of the paper's suite.
        healthy: the value of the parameter without the fault.
        kind: where it lives.
        cures: each entry is a set of adaptations that cure it together; the cheapest first.
        injection: what is done to inject it at the suite's strength.
        limits: least and greatest allowed value; None where the value is no number.
        description: what happens, one sentence.
    """

    name: str
    failure: Failure
    node: str
    parameter: str
    value: Value
    healthy: Value
    kind: FaultKind
    cures: tuple[tuple[Adaptation, ...], ...]
    injection: tuple[Adaptation, ...]
    limits: tuple[float, float] | None
    description: str

    @property
    def redeploy_only(self) -> bool:
        """Whether a redeploy cures it, and nothing cheaper."""
        return bool(self.cures) and self.cures[0][0].kind is AdaptationKind.REDEPLOY


_NODES = ("camera", "depth", "image_enhancement", "sensor_fusion", "segmentation")


def _restart(node: str) -> Adaptation:
    return Adaptation(AdaptationKind.RESTART, node)


def _redeploy(node: str) -> Adaptation:
    return Adaptation(AdaptationKind.REDEPLOY, node)


_ACTIVATE_ENHANCEMENT = Adaptation(AdaptationKind.ACTIVATE, "image_enhancement")
_DEACTIVATE_ENHANCEMENT = Adaptation(AdaptationKind.DEACTIVATE, "image_enhancement")
_USE_CAMERA = Adaptation(AdaptationKind.CHANGE_TOPIC, "sensor_fusion", "topic_camera_input", "rgb_camera")
_USE_ENHANCED = Adaptation(AdaptationKind.CHANGE_TOPIC, "sensor_fusion", "topic_camera_input", "rgb_enhanced")
_MODALITIES = tuple(
    Adaptation(AdaptationKind.SET_PARAMETER, "sensor_fusion", "modality", value) for value in (0, 1, 2)
)
_RECALIBRATE = Adaptation(AdaptationKind.SET_PARAMETER, "sensor_fusion", "do_recalibration", value=True)
_AUTOFOCUS = Adaptation(AdaptationKind.SET_PARAMETER, "camera", "perform_autofocus", value=True)

ADAPTATIONS: Final[tuple[Adaptation, ...]] = (
    *(_restart(node) for node in _NODES),
    *(_redeploy(node) for node in _NODES),
    _ACTIVATE_ENHANCEMENT,
    _DEACTIVATE_ENHANCEMENT,
    _USE_CAMERA,
    _USE_ENHANCED,
    *_MODALITIES,
    _RECALIBRATE,
    _AUTOFOCUS,
)
"""Every adaptation that the managed system offers."""


def _flag(
    name: str,
    failure: Failure,
    node: str,
    cures: tuple[Adaptation, ...],
    description: str,
) -> Fault:
    """Return an internal fault that is either there or not, cured by any one of `cures`."""
    return Fault(
        name=name,
        failure=failure,
        node=node,
        parameter=name,
        value=True,
        healthy=False,
        kind=FaultKind.INTERNAL,
        cures=tuple((cure,) for cure in cures),
        injection=(Adaptation(AdaptationKind.SET_PARAMETER, node, name, value=True),),
        limits=None,
        description=description,
    )


def _strength(
    name: str,
    node: str,
    value: float,
    kind: FaultKind,
    *,
    cures: tuple[tuple[Adaptation, ...], ...],
    limits: tuple[float, float],
    description: str,
) -> Fault:
    """Return an F4 fault that has a strength; an `int` stays one."""
    return Fault(
        name=name,
        failure=Failure.F4,
        node=node,
        parameter=name,
        value=value,
        healthy=type(value)(0),
        kind=kind,
        cures=cures,
        injection=(Adaptation(AdaptationKind.SET_PARAMETER, node, name, value),),
        limits=limits,
        description=description,
    )


_ALL = (
    _flag(
        "camera_driver_issue",
        Failure.F1,
        "camera",
        (_restart("camera"), _redeploy("camera")),
        "The camera's driver hangs and no image comes out until it is started anew.",
    ),
    _flag(
        "hardware_disconnect",
        Failure.F1,
        "camera",
        (_redeploy("camera"),),
        "The camera has lost its connection, which only starting the hardware anew brings back.",
    ),
    _flag(
        "sync_issue",
        Failure.F2,
        "sensor_fusion",
        (_restart("sensor_fusion"), _redeploy("sensor_fusion")),
        "The fusion no longer finds matching pairs of images until it is started anew.",
    ),
    _flag(
        "memory_leakage",
        Failure.F2,
        "sensor_fusion",
        (_redeploy("sensor_fusion"),),
        "The fusion has used up its memory, which only a new process gives back.",
    ),
    _flag(
        "cuda_out_of_memory",
        Failure.F3,
        "segmentation",
        (_restart("segmentation"), _redeploy("segmentation")),
        "The segmentation gets no memory on the graphics card until it is started anew.",
    ),
    _flag(
        "gpu_failure",
        Failure.F3,
        "segmentation",
        (_redeploy("segmentation"),),
        "The graphics card has failed, which only starting the hardware anew brings back.",
    ),
    _strength(
        "image_degradation",
        "camera",
        0.9,
        FaultKind.EXTERNAL,
        cures=((_ACTIVATE_ENHANCEMENT, _USE_ENHANCED),),
        limits=IMAGE_DEGRADATION_RANGE,
        description="The camera's images are darker and their colours are shifted.",
    ),
    Fault(
        name="unneeded_enhancement",
        failure=Failure.F4,
        node="sensor_fusion",
        parameter="topic_camera_input",
        value="rgb_enhanced",
        healthy="rgb_camera",
        kind=FaultKind.CONFIGURATION,
        cures=((_USE_CAMERA,),),
        injection=(_ACTIVATE_ENHANCEMENT, _USE_ENHANCED),
        limits=None,
        description="The image enhancement is applied to images that are good without it.",
    ),
    _strength(
        "image_shift",
        "sensor_fusion",
        10,
        FaultKind.INTERNAL,
        cures=((_RECALIBRATE,), (_redeploy("sensor_fusion"),)),
        limits=(0, 1920),
        description="The fusion has lost its calibration: colour and depth images no longer match.",
    ),
    _strength(
        "depth_degradation",
        "depth",
        0.25,
        FaultKind.EXTERNAL,
        cures=((_MODALITIES[1],),),
        limits=DEPTH_DEGRADATION_RANGE,
        description="The depth images are noisy; the strength is the noise's standard deviation in metres.",
    ),
    _flag(
        "autofocus_needed",
        Failure.F5,
        "camera",
        (_AUTOFOCUS, _redeploy("camera")),
        "The camera has lost its focus and its images are blurred.",
    ),
)

FAULTS: Final[Mapping[str, Fault]] = MappingProxyType({fault.name: fault for fault in _ALL})
"""Name → fault, in the paper's order of failures; read-only."""

EXCLUSIVE: Final[tuple[tuple[str, str], ...]] = (("image_degradation", "unneeded_enhancement"),)
"""Pairs of faults that cannot be there at the same time: each would be the other's cure."""


def get_fault(name: str) -> Fault:
    """Return the fault of that name.

    Raises:
        ScenarioError: there is none; the message lists those that there are.

    >>> get_fault("gpu_failure").redeploy_only
    True
    """
    try:
        return FAULTS[name]
    except KeyError:
        raise ScenarioError(
            f"There is no fault {name!r}: {suggestion(name, FAULTS)}choose one of {', '.join(FAULTS)}."
        ) from None
