"""The client library, in rclpy's names: `from sunset import ros as rclpy`.

It is a strict subset of rclpy (Jazzy): node code written on it runs on rclpy when only the import lines
change. In addition, `init` takes a middleware, such as a process of a simulation.
"""

from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from sunset.rmw.core.port import CallbackError
    from sunset.ros._functions import (
        create_node,
        init,
        ok,
        shutdown,
        spin,
        spin_once,
        spin_until_future_complete,
        try_shutdown,
    )
    from sunset.ros.context import Context
    from sunset.ros.executors import SingleThreadedExecutor
    from sunset.ros.node import Node
    from sunset.ros.parameter import Parameter
    from sunset.ros.task import Future

__all__ = [
    "CallbackError",
    "Context",
    "Future",
    "Node",
    "Parameter",
    "SingleThreadedExecutor",
    "create_node",
    "init",
    "ok",
    "shutdown",
    "spin",
    "spin_once",
    "spin_until_future_complete",
    "try_shutdown",
]

_MODULES: Final = MappingProxyType(
    {
        "CallbackError": "sunset.rmw.core.port",
        "Context": "sunset.ros.context",
        "Future": "sunset.ros.task",
        "Node": "sunset.ros.node",
        "Parameter": "sunset.ros.parameter",
        "SingleThreadedExecutor": "sunset.ros.executors",
    }
)
"""Class → its module; the functions are in `_functions`."""


def __getattr__(name: str) -> object:
    """Import an attribute when it is used: the modules below import this package, and most need little of it."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES.get(name, "sunset.ros._functions")), name)


def __dir__() -> list[str]:
    return sorted(__all__)
