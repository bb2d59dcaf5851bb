"""The life of a process on the network, as in `rclpy.context`."""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from sunset_ros.arguments import Arguments
from sunset_ros.errors import MiddlewareError
from sunset_ros.exceptions import NotInitializedException
from sunset_ros.rmw.backends import live_middleware
from sunset_ros.rmw.core.node import Middleware


class Context:
    """The middleware and the arguments of a process, which its nodes share.

    Until `init`, and after a shutdown, what needs the network raises a `NotInitializedException`.
    """

    def __init__(self) -> None:
        self._middleware: Middleware | None = None
        self.arguments = Arguments()
        self.log_once = False
        """Whether stderr has a log message that repeats only once."""
        self._on_shutdown: list[Callable[[], object]] = []

    def init(
        self,
        args: Sequence[str] | None = None,
        *,
        domain_id: int | None = None,
        middleware: Middleware | None = None,
        log_to_stderr: bool | None = None,
        log_once: bool = False,
    ) -> None:
        """Join the network.

        Args:
            args: the command line; `sys.argv` if None.
            domain_id: of the live middleware; ROS_DOMAIN_ID, else 0, if None.
            middleware: such as a process of a simulation; the live middleware if None.
            log_to_stderr: whether logs go to stderr, if the command line does not say; if None, only live.
            log_once: whether a repeated message is written to stderr only the first time.

        Raises:
            MiddlewareError: the context is in use, or the live middleware cannot be set up as asked.
            MissingExtraError: no middleware is given, and the extra `live` is not installed.
            UnknownROSArgsError: an argument after `--ros-args` is unknown or malformed.
            ParameterError: a parameter file cannot be read or is malformed.
        """
        if self.ok():
            raise MiddlewareError("The context is initialised already; shut it down first.")
        if middleware is not None and domain_id is not None:
            raise MiddlewareError("A domain id was given beside a middleware; give it to the middleware.")
        self.arguments = Arguments.parse(sys.argv if args is None else args)
        if self.arguments.log_to_stderr is None:
            self.arguments.log_to_stderr = middleware is None if log_to_stderr is None else log_to_stderr
        self.log_once = log_once
        self._middleware = live_middleware().join(domain_id=domain_id) if middleware is None else middleware

    @property
    def middleware(self) -> Middleware:
        """The process's door to the network, which `init` opens."""
        if self._middleware is None:
            raise NotInitializedException("The context is not initialised: call init() first.")
        return self._middleware

    def ok(self) -> bool:
        """Return whether it is initialised and not shut down."""
        return self._middleware is not None and self._middleware.alive

    def shutdown(self) -> None:
        """Leave the network; in a callback, once its messages are sent."""
        if not self.ok():
            raise NotInitializedException("The context is not initialised, or was shut down already.")
        self.try_shutdown()

    def try_shutdown(self) -> None:
        """Leave the network if not done already."""
        if self.ok():
            self.middleware.shutdown()
            callbacks, self._on_shutdown = self._on_shutdown, []
            for callback in callbacks:
                callback()

    def on_shutdown(self, callback: Callable[[], object]) -> None:
        """Call `callback()` when this context shuts down."""
        self._on_shutdown.append(callback)


_default = Context()


def get_default_context() -> Context:
    """Return the context that is used where none is named."""
    return _default


@contextmanager
def default_context(context: Context) -> Iterator[None]:
    """Make a context the default one for a while."""
    global _default  # noqa: PLW0603  the default is global, as in rclpy
    before, _default = _default, context
    try:
        yield
    finally:
        _default = before
