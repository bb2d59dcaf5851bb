"""The middlewares by the names that users give them.

A new middleware is a package beside `sim` and `dds`, and an entry in `BACKENDS`.
"""

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType
from typing import Final, NamedTuple, cast

from sunset_ros.rmw.core.live import LiveMiddleware

SIMULATED: Final = "sim"
"""The default of experiments."""

LIVE: Final = "cyclonedds"
"""The default of live processes."""


class Backend(NamedTuple):
    """A middleware: its package in `sunset_ros.rmw`, and where nodes run, for `--help`."""

    package: str
    where: str


BACKENDS: Final[Mapping[str, Backend]] = MappingProxyType(
    {
        SIMULATED: Backend("sim", "simulated, in virtual time"),
        LIVE: Backend("dds", "a process each, on ROS 2's network, in real time"),
    }
)
"""Name → middleware; all but the first are live."""


def live_middleware(name: str = LIVE) -> LiveMiddleware:
    """Import a live middleware.

    Raises:
        MissingExtraError: its extra is not installed.
    """
    return cast("LiveMiddleware", import_module(f"{__package__}.{BACKENDS[name].package}"))
