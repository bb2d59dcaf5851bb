"""Executors, as in `rclpy.executors`, and the functions of the module `rclpy`."""

from collections.abc import Callable, Coroutine, Iterator, Sequence
from contextlib import contextmanager
from typing import Self, TypeVar, Unpack

from sunset_ros.context import Context, get_default_context
from sunset_ros.errors import MiddlewareError
from sunset_ros.exceptions import NotInitializedException
from sunset_ros.node import Node, NodeOptions
from sunset_ros.rmw.core.node import Middleware
from sunset_ros.signals import SignalHandlerOptions, install_signal_handlers
from sunset_ros.task import Future, callback_name, drive

T = TypeVar("T")


class SingleThreadedExecutor:
    """Runs the callbacks of its nodes, one at a time, in the order in which they become ready.

    Without a context, it is of the default one. All that spins raises a `CallbackError` if a callback raised.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        self.context = context or get_default_context()
        self._nodes: list[Node] = []
        self._is_shutdown = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.shutdown()

    def add_node(self, node: Node) -> bool:
        """Run the callbacks of a node; return whether it did not do so before.

        Raise a `MiddlewareError` if the node belongs to another context.
        """
        if node in self._nodes:
            return False
        if node.context is not self.context:
            raise MiddlewareError(f"Node {node.get_fully_qualified_name()} belongs to another context.")
        self._nodes.append(node)
        node.handle.attach()
        return True

    def remove_node(self, node: Node) -> None:
        """Hold the callbacks of a node back."""
        if node in self._nodes:
            self._nodes.remove(node)
            node.handle.detach()

    def get_nodes(self) -> list[Node]:
        """Return the nodes whose callbacks it runs."""
        return list(self._nodes)

    def create_task(
        self,
        callback: Callable[..., object] | Coroutine[object, None, object],
        *args: object,
        **kwargs: object,
    ) -> Future[object]:
        """Call a function soon, as a callback of the first node; the future is done with its result.

        The function may be a coroutine function, and a coroutine may be given in its place. Raise a `MiddlewareError`
        if the executor has not got a node.
        """
        if not self._nodes:
            raise MiddlewareError("An executor without nodes cannot run a task; add a node first.")
        future: Future[object] = Future()
        self._nodes[0].handle.post(
            lambda: drive(callback(*args, **kwargs) if callable(callback) else callback, future.set_result),
            f"{callback_name(callback)} (task)",
        )
        return future

    def spin(self) -> None:
        """Run callbacks until the context is shut down."""
        while self.context.ok() and not self._is_shutdown:
            self.context.middleware.spin_once(None)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait for a callback and run it; None or a negative number of seconds is for ever.

        Raises:
            MiddlewareError: called from inside a callback.
            NotInitializedException: the context is not initialised, or was shut down.
        """
        if not self.context.ok():
            raise NotInitializedException("A context that is not initialised, or was shut down, cannot spin.")
        self.context.middleware.spin_once(_nanoseconds(timeout_sec))

    def spin_until_future_complete(self, future: Future[T], timeout_sec: float | None = None) -> None:
        """Run callbacks until a future is done, the context is shut down, or time is over."""
        middleware = self.context.middleware
        timeout_ns = _nanoseconds(timeout_sec)
        end_ns = None if timeout_ns is None else middleware.steady_ns() + timeout_ns
        while not future.done() and self.context.ok() and not self._is_shutdown:
            remaining_ns = None if end_ns is None else max(0, end_ns - middleware.steady_ns())
            ran = middleware.spin_once(remaining_ns)  # it may have returned without a callback
            if end_ns is not None and middleware.steady_ns() >= end_ns + ran:
                return

    def wake(self) -> None:
        """Make a waiting `spin_once` return."""
        self.context.middleware.wake()

    def shutdown(self, timeout_sec: float | None = None) -> bool:  # noqa: ARG002  rclpy's; nothing here waits
        """Stop running callbacks and end `spin`, from any thread; return True, since nothing is waited for."""
        self._is_shutdown = True
        for node in self.get_nodes():
            self.remove_node(node)
        if self.context.ok():
            self.wake()
        return True


def _nanoseconds(timeout_sec: float | None) -> int | None:
    return None if timeout_sec is None or timeout_sec < 0 else round(timeout_sec * 1e9)


def init(
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    domain_id: int | None = None,
    signal_handler_options: SignalHandlerOptions | None = None,
    middleware: Middleware | None = None,
) -> None:
    """Join the network: see `Context.init` for the arguments and errors.

    `signal_handler_options` say which signals shut the context down; by default all, but none for a context or a
    middleware that is given.
    """
    (context or get_default_context()).init(args, domain_id=domain_id, middleware=middleware)
    if signal_handler_options is None:
        own = context is None and middleware is None
        signal_handler_options = SignalHandlerOptions.ALL if own else SignalHandlerOptions.NO
    install_signal_handlers(signal_handler_options, context=context)


def shutdown(*, context: Context | None = None) -> None:
    """Leave the network; see `Context.shutdown`."""
    (context or get_default_context()).shutdown()


def try_shutdown(*, context: Context | None = None) -> None:
    """Leave the network if not done already."""
    (context or get_default_context()).try_shutdown()


def ok(*, context: Context | None = None) -> bool:
    """Return whether the context is initialised and not shut down."""
    return (context or get_default_context()).ok()


def create_node(node_name: str, **options: Unpack[NodeOptions]) -> Node:
    """Make a node; see `Node` for the options."""
    return Node(node_name, **options)


def spin(node: Node, executor: SingleThreadedExecutor | None = None) -> None:
    """Run the callbacks of a node until its context is shut down; see `SingleThreadedExecutor.spin`."""
    with _executor_of(node, executor) as executing:
        executing.spin()


def spin_once(
    node: Node, *, executor: SingleThreadedExecutor | None = None, timeout_sec: float | None = None
) -> None:
    """Wait for a callback of a node and run it; see `SingleThreadedExecutor.spin_once`."""
    with _executor_of(node, executor) as executing:
        executing.spin_once(timeout_sec)


def spin_until_future_complete(
    node: Node,
    future: Future[T],
    executor: SingleThreadedExecutor | None = None,
    timeout_sec: float | None = None,
) -> None:
    """Run the callbacks of a node until a future is done, its context is shut down, or time is over."""
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
