"""SUNSET: a ROS 2 exemplar for self-adaptation under concurrent, ambiguous faults.

Every command of the command line is a function here, such as `sunset.run("gpu_failure", seed=3).metrics`. A managing
system is a subclass of `ManagingSystem`. Mistakes of the caller raise a `SunsetError`, whose text is one sentence.
"""

import os
import re
from importlib import import_module
from pathlib import Path
from typing import Final

_STUB: Final = Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")
_PLACES: Final = {name: module for module, name in re.findall(r"from (\S+) import (\w+)", _STUB)}
"""Name → the module that it is imported from when it is first used."""

__all__ = sorted(["__version__", *_PLACES])  # noqa: PLE0605  the stub has the names

__version__ = "0.1.0"

# Since 1.29, ONNX Runtime reports its use to its maker unless this is set before it is imported.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")


def __getattr__(name: str) -> object:
    if name not in _PLACES:
        raise AttributeError(f"module 'sunset' has no attribute {name!r}")
    return getattr(import_module(_PLACES[name]), name)


def __dir__() -> list[str]:
    return list(__all__)
