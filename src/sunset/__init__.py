"""SUNSET: a ROS 2 exemplar for self-adaptation under concurrent, ambiguous faults.

Every command of the command line is a function here, such as `sunset.run("gpu_failure", seed=3).metrics`. A managing
system is a subclass of `ManagingSystem`. Mistakes of the caller raise a `SunsetError`, whose text is one sentence.
"""

import os
from importlib import import_module
from typing import Final

_MODULES: Final = {
    "sunset.api.catalogue": (
        "check_split",
        "generate_split",
        "list_faults",
        "list_managers",
        "list_scenarios",
        "list_suites",
        "make_scenario",
    ),
    "sunset.api.flights": ("bag_statistics", "measure_flights", "render_flight"),
    "sunset_lab.models": (
        *(
            "TrainingOptions",
            "calibrate_model",
            "import_model",
            "measure_curves",
            "measure_iou",
            "train_model",
        ),
    ),
    "sunset.api.options": ("CampaignOptions",),
    "sunset.api.pictures": ("fault_figure", "fault_picture"),
    "sunset.api.bundling": ("bundle", "verify"),
    "sunset.api.results": ("Results", "load", "report", "write_figures"),
    "sunset.api.running": ("agree", "bench", "check_manager", "plan_bench", "run"),
    "sunset.api.viewing": ("Run", "view", "write_site"),
    "sunset.data": ("FlightPlan",),
    "sunset.errors": ("SunsetError",),
    "sunset.experiments": ("Options",),
    "sunset.managing": ("ManagingSystem", "Symptoms"),
    "sunset.perception": ("list_models", "load_model"),
    "sunset.scenarios": ("load_scenario",),
}
"""Module → the names that are imported from it when they are first used; their types are in `__init__.pyi`."""

_PLACES: Final = {name: module for module, names in _MODULES.items() for name in names}

__all__ = sorted(["__version__", *_PLACES])  # noqa: PLE0605  the names stand above

__version__ = "0.1.0"

# Since 1.29, ONNX Runtime reports its use to its maker unless this is set before it is imported.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")


def __getattr__(name: str) -> object:
    if name not in _PLACES:
        raise AttributeError(f"module 'sunset' has no attribute {name!r}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return list(__all__)
