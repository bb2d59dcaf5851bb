"""SUNSET: a ROS 2 exemplar for self-adaptation under concurrent, ambiguous faults.

What the command line measures is one call each, as in `sunset.run("gpu_failure", seed=3).metrics`. A managing system is
a subclass of `ManagingSystem`. A mistake of the caller's is a `SunsetError`, whose text is one sentence.
"""

import os
from importlib import import_module
from types import MappingProxyType
from typing import Final

__all__ = [
    "FlightPlan",
    "ManagingSystem",
    "Options",
    "Results",
    "Run",
    "SunsetError",
    "Symptoms",
    "__version__",
    "agree",
    "bag_statistics",
    "bench",
    "bundle",
    "calibrate_model",
    "check_manager",
    "check_split",
    "fault_figure",
    "fault_picture",
    "generate_split",
    "import_model",
    "list_faults",
    "list_managers",
    "list_models",
    "list_scenarios",
    "list_suites",
    "load",
    "load_model",
    "load_scenario",
    "make_scenario",
    "measure_curves",
    "measure_flights",
    "measure_iou",
    "plan_bench",
    "render_flight",
    "report",
    "run",
    "train_model",
    "verify",
    "view",
    "write_figures",
    "write_site",
]

__version__ = "0.1.0"

# Since 1.29, ONNX Runtime reports its use to its maker unless this stands there before it is imported.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")

# what types these have stands in `__init__.pyi`: every module imports this one, which must import none of them
_ELSEWHERE: Final = MappingProxyType(
    {
        "FlightPlan": ("sunset.data", "FlightPlan"),
        "ManagingSystem": ("sunset.managing", "ManagingSystem"),
        "SunsetError": ("sunset.errors", "SunsetError"),
        "Symptoms": ("sunset.managing", "Symptoms"),
    }
)
"""What is not of `sunset.api`: module and name."""


def __getattr__(name: str) -> object:
    """Import what is asked for, since all of it takes longer than most programs need."""
    if name.startswith("_") or name not in __all__:
        raise AttributeError(f"module 'sunset' has no attribute {name!r}")
    module, attribute = _ELSEWHERE.get(name, ("sunset.api", name))
    return getattr(import_module(module), attribute)


def __dir__() -> list[str]:
    return sorted(__all__)
