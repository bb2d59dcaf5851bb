"""The client library, in rclpy's names: `from sunset import ros as rclpy`.

It is a strict subset of rclpy (Jazzy): node code written on it runs on rclpy when only the import lines
change. What is more: `init` may be told a middleware, such as a process of a simulation.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from sunset.rmw.core.node import Middleware
from sunset.rmw.core.port import CallbackError
from sunset.ros.context import Context, get_default_context
from sunset.ros.executors import SingleThreadedExecutor
from sunset.ros.node import Node
from sunset.ros.parameter import Parameter
from sunset.ros.signals import SignalHandlerOptions, install_signal_handlers
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

T = TypeVar("T")


def init(
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
    middleware: Middleware | None = None,
) -> None:
    """Join the network.

    Args:
        args: as of `Context.init`, which also says what may be raised.
        context: the process; the default context if None.
        domain_id: as of `Context.init`.
        signal_handler_options: which signals shut the context down; all if None, but none for a context or a
            middleware that is given.
        middleware: as of `Context.init`.
    """
    (context or get_default_context()).init(args, domain_id=domain_id, middleware=middleware)
    if signal_handler_options is None:
        own = context is None and middleware is None
        signal_handler_options = SignalHandlerOptions.ALL if own else SignalHandlerOptions.NO
    install_signal_handlers(signal_handler_options, context=context)


def shutdown(*, context: Context | None = None) -> None:
    """Leave the network; from inside a callback, after that callback and what it sends.

    Raises:
        NotInitializedException: the context is not initialised, or was shut down.
    """
    (context or get_default_context()).shutdown()


def try_shutdown(*, context: Context | None = None) -> None:
    """Leave the network if not done already."""
    (context or get_default_context()).try_shutdown()


def ok(*, context: Context | None = None) -> bool:
    """Return whether the context is initialised and not shut down."""
    return (context or get_default_context()).ok()


def create_node(node_name: str, **options: Any) -> Node:
    """Make a node; the options are those of `Node`."""
    return Node(node_name, **options)


def spin(node: Node, executor: SingleThreadedExecutor | None = None) -> None:
    """Run the callbacks of a node until its context is shut down.

    Raises:
        CallbackError: a callback raised.
    """
    with _executor_of(node, executor) as executing:
        executing.spin()


def spin_once(
    node: Node, *, executor: SingleThreadedExecutor | None = None, timeout_sec: float | None = None
) -> None:
    """Wait for a callback of a node and run it.

    Raises:
        CallbackError: it raised.
        MiddlewareError: called from inside a callback.
    """
    with _executor_of(node, executor) as executing:
        executing.spin_once(timeout_sec)


def spin_until_future_complete(
    node: Node,
    future: Future[T],
    executor: SingleThreadedExecutor | None = None,
    timeout_sec: float | None = None,
) -> None:
    """Run the callbacks of a node until a future is done, its context is shut down, or time is over.

    Raises:
        CallbackError: a callback raised.
    """
    with _executor_of(node, executor) as executing:
        executing.spin_until_future_complete(future, timeout_sec)


@contextmanager
def _executor_of(node: Node, executor: SingleThreadedExecutor | None) -> Iterator[SingleThreadedExecutor]:
    executor = executor or SingleThreadedExecutor(context=node.context)
    added = executor.add_node(node)
    try:
        yield executor
    finally:
        if added:
            executor.remove_node(node)
