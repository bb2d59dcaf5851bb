"""The published exemplar's scenario files: a list of parameter adaptations."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from sunset.errors import ScenarioError
from sunset.names import base_name
from sunset.system import Value, get_fault

REQUIRED_KEYS: Final = ("name", "target_node", "type", "value")
IGNORED_KEYS: Final = ("criticality_level", "is_gt_failure", "probability")
"""Keys of an entry that do not concern the injection."""

_RENAMED: Final[Mapping[str, str]] = MappingProxyType(
    {
        "do_drop_camera": "camera_driver_issue",
        "do_drop_rgb_camera": "camera_driver_issue",
        "do_drop_sensor_fusion": "sync_issue",
        "do_drop_segmentation": "cuda_out_of_memory",
        "do_hard_drop_camera": "hardware_disconnect",
        "do_hard_drop_rgb_camera": "hardware_disconnect",
        "do_hard_drop_sensor_fusion": "memory_leakage",
        "do_hard_drop_segmentation": "gpu_failure",
    }
)
"""Parameter of the older published files → fault: a drop ends with a restart, a hard drop does not."""

_PUBLISHED_STRENGTHS: Final[Mapping[str, float]] = MappingProxyType(
    {"image_degradation": 1.5, "depth_degradation": 2.0, "image_shift": 300.0}
)
"""The strengths of the published files, on full-size images and the published networks."""

_LARGEST: Final = 1e9
"""Far above every strength of a fault."""


def translate(name: str, target_node: str, kind: str, value: Value) -> tuple[str, Value]:
    """Return (fault, value) of an entry of a published file.

    Strengths are scaled so that the published suite's become the strengths of our suites, since image size, noise and
    network differ.

    Raises:
        ScenarioError: the entry is of another type, sets an unknown fault, or sets it at another node.

    >>> translate("image_shift", "/managed_subsystem/sensor_fusion", "parameter_adaptation", 150)
    ('image_shift', 5)
    """
    if kind != "parameter_adaptation":
        raise ScenarioError(f"The type of {name} must be parameter_adaptation, got {kind!r}.")
    fault = get_fault(_RENAMED.get(name, name))
    if base_name(target_node) != fault.node:
        raise ScenarioError(
            f"The fault {name} must have the target_node /managed_subsystem/{fault.node}, "
            f"got {target_node!r}."
        )
    published, ours = _PUBLISHED_STRENGTHS.get(fault.name), fault.value
    if published is None or isinstance(value, bool | str) or isinstance(ours, bool | str):
        return fault.name, value
    if not 0 <= value <= _LARGEST:
        return fault.name, value  # the scenario refuses it, and quotes the file's number
    scaled = ours * value / published
    return fault.name, round(scaled) if isinstance(ours, int) else scaled
