"""The client library, in rclpy's names: `import sunset_ros as rclpy`.

It is a strict subset of rclpy (Jazzy): node code written on it runs on rclpy when only the import lines
change. In addition, `init` takes a middleware, such as a process of a simulation.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from sunset_ros.context import Context
    from sunset_ros.executors import (
        SingleThreadedExecutor,
        create_node,
        init,
        ok,
        shutdown,
        spin,
        spin_once,
        spin_until_future_complete,
        try_shutdown,
    )
    from sunset_ros.node import Node
    from sunset_ros.parameter import Parameter
    from sunset_ros.rmw.core.port import CallbackError
    from sunset_ros.task import Future

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

__version__ = "0.1.0"

_MODULES: Final = {
    "CallbackError": "sunset_ros.rmw.core.port",
    "Context": "sunset_ros.context",
    "Future": "sunset_ros.task",
    "Node": "sunset_ros.node",
    "Parameter": "sunset_ros.parameter",
}
"""Class → its module; all else is in `executors`."""


def __getattr__(name: str) -> object:
    """Import an attribute when it is used: the modules below import this package, and most need little of it."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_MODULES.get(name, "sunset_ros.executors")), name)


def __dir__() -> list[str]:
    return sorted(__all__)
