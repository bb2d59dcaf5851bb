"""Another process that asks services of a running system, and what it knows of the nodes beforehand."""

import math
from typing import Any, NamedTuple

from tests.live.systems import Tool

from sunset_ros.interfaces import Message
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter, ParameterValue
from sunset_ros.parameter import parameter_value_to_python

BOOL, INTEGER, DOUBLE, STRING = 1, 2, 3, 4
A_VALUE_OF_EACH_TYPE = {
    0: None,
    BOOL: True,
    INTEGER: 1,
    DOUBLE: 0.5,
    STRING: "rgb_camera",
    5: [b"\x01"],
    6: [True],
    7: [1],
    8: [0.5],
    9: ["a"],
    10: None,
    255: None,
}
"""The last two are no types."""


class Known(NamedTuple):
    """What is known of a parameter beforehand.

    Attributes:
        type: number of its type.
        good: values that are accepted one after the other, the last of which may stay.
        limits: the least and the greatest allowed number.
        bad: values of its type that are refused, besides those beyond the limits.
        read_only: whether none is accepted.
    """

    type: int
    good: tuple[object, ...] = ()
    limits: tuple[float, float] | None = None
    bad: tuple[object, ...] = ()
    read_only: bool = False


DELAY = Known(DOUBLE, limits=(-1.0, 3600.0), read_only=True)
FAULT = Known(BOOL, (False, True))
SWITCH = Known(BOOL, (True, False))
ACTION = Known(BOOL, (False, True))
SIM_TIME = {"use_sim_time": Known(BOOL, (False, True))}
WALL_TIME = {"use_sim_time": Known(BOOL, (True, False))}
ANY_WHOLE = (0, 2**31 - 1)
WHOLE = Known(INTEGER, limits=ANY_WHOLE, read_only=True)
SIZE = Known(INTEGER, limits=(0, 2**14), read_only=True)

NODES: dict[str, dict[str, Known]] = {
    "/managed_subsystem/camera": {
        **SIM_TIME,
        "lifecycle_activation_delay": DELAY,
        "autostart": Known(BOOL, read_only=True),
        "fault_access": SWITCH,
        "sharpness_threshold": Known(DOUBLE, (0.0, 64.0, 1.5), (0.0, 64.0), (math.nan, -math.inf)),
        "image_degradation": Known(DOUBLE, (1.9, 0.5, 0.0), (0.0, 1.9), (math.nan, math.inf)),
        "camera_driver_issue": FAULT,
        "hardware_disconnect": FAULT,
        "autofocus_needed": FAULT,
        "perform_autofocus": ACTION,
    },
    "/managed_subsystem/depth": {
        **SIM_TIME,
        "lifecycle_activation_delay": DELAY,
        "autostart": Known(BOOL, read_only=True),
        "fault_access": SWITCH,
        "seed": Known(INTEGER, limits=(0, 2**32 - 1), read_only=True),
        "depth_degradation": Known(DOUBLE, (100.0, 2.5, 0.0), (0.0, 100.0), (math.nan, math.inf)),
    },
    "/managed_subsystem/image_enhancement": {
        **SIM_TIME,
        "lifecycle_activation_delay": DELAY,
        "autostart": Known(BOOL, read_only=True),
        "fault_access": SWITCH,
        "image_degradation": Known(DOUBLE, (1.9, 0.0, 1.5), (0.0, 1.9), (math.nan,)),
    },
    "/managed_subsystem/sensor_fusion": {
        **SIM_TIME,
        "lifecycle_activation_delay": DELAY,
        "autostart": Known(BOOL, read_only=True),
        "fault_access": SWITCH,
        "topic_camera_input": Known(
            STRING,
            ("/rgb_raw", "rgb_enhanced", "/a/b_1", f"/{'x' * 200}", "rgb_camera"),
            bad=(
                "",
                "/",
                "rgb_enhance",
                "~/rgb",
                "a//b",
                "1a",
                "a b",
                "a/",
                "rgb\0",
                "ä",
                "{node}",
                "x" * 1000,
            ),
        ),
        "modality": Known(INTEGER, (2, 1, 0), (0, 2), (-(2**63), 2**63 - 1)),
        "delta_t_threshold": Known(DOUBLE, (10.0, 0.0, 0.01), (0.0, 10.0), (math.nan, math.inf)),
        "image_shift": Known(INTEGER, (0, 1920), (0, 1920)),
        "sync_issue": FAULT,
        "memory_leakage": FAULT,
        "do_recalibration": ACTION,
    },
    "/managed_subsystem/segmentation": {
        **SIM_TIME,
        "lifecycle_activation_delay": DELAY,
        "autostart": Known(BOOL, read_only=True),
        "fault_access": SWITCH,
        "model": Known(STRING, read_only=True),
        "inference_cache": Known(STRING, read_only=True),
        "device": Known(STRING, read_only=True),
        "cuda_out_of_memory": FAULT,
        "gpu_failure": FAULT,
    },
    "/bag_player": {
        **WALL_TIME,
        "bag": Known(STRING, read_only=True),
        "start_frame": WHOLE,
        "frames": WHOLE,
        "loop": Known(BOOL, read_only=True),
        "rate": Known(DOUBLE, limits=(0.1, 1000.0), read_only=True),
        "phase": Known(DOUBLE, limits=(0.0, 60.0), read_only=True),
        "width": SIZE,
        "height": SIZE,
        "speed": Known(DOUBLE, limits=(0.01, 100.0), read_only=True),
        "field_of_view": Known(DOUBLE, limits=(1.0, 179.0), read_only=True),
        "origin_ns": Known(INTEGER, read_only=True),
    },
    "/monitor": SIM_TIME,
    "/evaluator": SIM_TIME,
    "/scenario_executor": {**SIM_TIME, "scenario": Known(STRING, read_only=True)},
    "/launcher": WALL_TIME,
    "/operator": SIM_TIME,
}

_FIELDS = (
    *("", "bool_value", "integer_value", "double_value", "string_value"),
    *("byte_array_value", "bool_array_value", "integer_array_value", "double_array_value"),
    "string_array_value",
)


class Asker:
    """Asks by the node of a tool."""

    def __init__(self, tool: Tool) -> None:
        self.tool = tool
        self._clients: dict[str, Any] = {}

    def ask(self, service: type[Any], name: str, request: Message) -> Any:
        """Ask a service, as soon as it is there."""
        if name not in self._clients:
            self._clients[name] = self.tool.node.create_client(service, name)
        client = self._clients[name]
        assert self.tool.spin(client.service_is_ready), f"{name} is not there"
        future = client.call_async(request)
        assert self.tool.spin(future.done), f"{name} did not answer"
        return future.result()


def parameter(name: str, kind: int, value: Any) -> Parameter:
    """Return a parameter with a value of a type, or of none if there is no such type."""
    message = ParameterValue(type=kind)
    if value is not None:
        setattr(message, _FIELDS[kind], int(value) if kind == 2 else value)
    return Parameter(name=name, value=message)


def python_value(value: ParameterValue) -> Any:
    """Return a value as Python's own."""
    return parameter_value_to_python(value)


def bad_parameters(node: str) -> list[Parameter]:
    """Return what must be refused, whatever was set before."""
    found = [parameter(name, INTEGER, 1) for name in ("", "nonsense", "use_sim_time.x", "x" * 10_000)]
    for name, known in NODES[node].items():
        found += [
            parameter(name, kind, value)
            for kind, value in A_VALUE_OF_EACH_TYPE.items()
            if kind != known.type or known.read_only
        ]
        beyond = () if known.limits is None else (known.limits[0] - 1, known.limits[1] + 1)
        found += [parameter(name, known.type, value) for value in (*beyond, *known.bad)]
    return found


def good_parameters(node: str) -> list[Parameter]:
    """Return what must be accepted, in this order."""
    return [
        parameter(name, known.type, value)
        for name, known in NODES[node].items()
        for value in known.good
        if known is not FAULT and known is not ACTION
    ]
