"""The middlewares by the names that users give them.

A new middleware is a package beside `sim` and `dds`, and an entry in `BACKENDS`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

from sunset_ros.rmw.core.live import LiveMiddleware


@dataclass(frozen=True)
class Backend:
    """A middleware.

    Attributes:
        name: its name.
        description: where nodes run, for `--help`.
        load: imports a live middleware; None for the simulation.
    """

    name: str
    description: str
    load: Callable[[], LiveMiddleware] | None = None


def _load_cyclonedds() -> LiveMiddleware:
    from sunset_ros.rmw import dds  # noqa: PLC0415  an optional extra

    return dds


SIMULATED: Final = "sim"
"""The default of experiments."""

LIVE: Final = "cyclonedds"
"""The default of live processes."""

BACKENDS: Final[Mapping[str, Backend]] = MappingProxyType(
    {
        backend.name: backend
        for backend in (
            Backend(SIMULATED, "in this process, virtual time"),
            Backend(LIVE, "a process each, on ROS 2's network, in real time", _load_cyclonedds),
        )
    }
)


def live_middleware(name: str = LIVE) -> LiveMiddleware:
    """Import a live middleware.

    Raises:
        MissingExtraError: its extra is not installed.
    """
    load = BACKENDS[name].load
    assert load is not None, f"{name} is simulated"  # noqa: S101  the caller's mistake
    return load()
