"""The functions of the module `rclpy`."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypeVar

from sunset_ros.context import Context, get_default_context
from sunset_ros.executors import SingleThreadedExecutor
from sunset_ros.node import Node
from sunset_ros.rmw.core.node import Middleware
from sunset_ros.signals import SignalHandlerOptions, install_signal_handlers
from sunset_ros.task import Future

T = TypeVar("T")


def init(
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
    middleware: Middleware | None = None,
) -> None:
    """Join the network: see `Context.init` for the arguments and errors.

    Args:
        args: the command line.
        context: the process; the default context if None.
        domain_id: the domain of the live middleware.
        signal_handler_options: which signals shut the context down; all if None, but none for a context or a
            middleware that is given.
        middleware: the middleware, such as a process of a simulation.
    """
    (context or get_default_context()).init(args, domain_id=domain_id, middleware=middleware)
    if signal_handler_options is None:
        own = context is None and middleware is None
        signal_handler_options = SignalHandlerOptions.ALL if own else SignalHandlerOptions.NO
    install_signal_handlers(signal_handler_options, context=context)


def shutdown(*, context: Context | None = None) -> None:
    """Leave the network; from inside a callback, once the messages of that callback are sent.

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
    """Make a node; see `Node` for the options."""
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
        CallbackError: the callback raised.
        MiddlewareError: this is a callback itself.
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
