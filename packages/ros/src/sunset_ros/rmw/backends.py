"""The middlewares by the names that users give them.

A new middleware is a package beside `sim` and `dds`, an entry in `BACKENDS`, and an import in `live_middleware`.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from sunset_ros.rmw.core.live import LiveMiddleware

SIMULATED: Final = "sim"
"""The default of experiments."""

LIVE: Final = "cyclonedds"
"""The default of live processes."""

BACKENDS: Final[Mapping[str, str]] = MappingProxyType(
    {
        SIMULATED: "simulated, in virtual time",
        LIVE: "a process each, on ROS 2's network, in real time",
    }
)
"""Name → where nodes run, for `--help`; all but the first are live."""


def live_middleware(name: str = LIVE) -> LiveMiddleware:
    """Import a live middleware.

    Raises:
        MissingExtraError: its extra is not installed.
    """
    from sunset_ros.rmw import dds  # noqa: PLC0415  an optional extra

    return {LIVE: dds}[name]
