"""SUNSET: a ROS 2 exemplar for self-adaptation under concurrent, ambiguous faults."""

import os

__all__ = ["__version__"]

__version__ = "0.1.0"

# Since 1.29, ONNX Runtime reports its use to its maker unless this stands there before it is imported.
os.environ.setdefault("ORT_DISABLE_TELEMETRY", "1")
