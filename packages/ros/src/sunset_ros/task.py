"""Results that come later, as in `rclpy.task`, and users' callbacks: their names in errors, and coroutines."""

from collections.abc import Callable, Coroutine, Generator
from functools import partial
from inspect import iscoroutine
from typing import Generic, TypeVar, cast

T = TypeVar("T")


class Future(Generic[T]):
    """A result, or an exception, that a callback will set."""

    __slots__ = ("_callbacks", "_cancelled", "_done", "_exception", "_result")

    def __init__(self) -> None:
        self._done = False
        self._cancelled = False
        self._result: T | None = None
        self._exception: Exception | None = None
        self._callbacks: list[Callable[[Future[T]], object]] = []

    def __repr__(self) -> str:
        state = "cancelled" if self._cancelled else "done" if self._done else "pending"
        return f"<Future {state}>"

    def __await__(self) -> "Generator[Future[T], None, T]":
        """Wait, inside a callback that is a coroutine, until the future is done."""
        while not self.done():
            yield self
        return cast("T", self.result())

    def done(self) -> bool:
        """Return whether there is a result or an exception, or the future is cancelled."""
        return self._done or self._cancelled

    def cancelled(self) -> bool:
        """Return whether it was cancelled."""
        return self._cancelled

    def cancel(self) -> None:
        """Give up on a result that has not come yet."""
        if not self.done():
            self._cancelled = True
            self._call_back()

    def result(self) -> T | None:
        """Return the result, or None if there is none yet.

        Raises:
            Exception: it was set instead of a result.
        """
        if self._exception is not None:
            raise self._exception
        return self._result

    def exception(self) -> Exception | None:
        """Return the exception that was set instead of a result, if any."""
        return self._exception

    def set_result(self, result: T) -> None:
        """Set the result, and call those who wait for it."""
        if not self.done():
            self._result = result
            self._done = True
            self._call_back()

    def set_exception(self, exception: Exception) -> None:
        """Set an exception instead of a result, and call those who wait."""
        if not self.done():
            self._exception = exception
            self._done = True
            self._call_back()

    def add_done_callback(self, callback: "Callable[[Future[T]], object]") -> None:
        """Call `callback(future)` when done, or at once if it is done already."""
        if self.done():
            callback(self)
        else:
            self._callbacks.append(callback)

    def _call_back(self) -> None:
        callbacks, self._callbacks = self._callbacks, []
        for callback in callbacks:
            callback(self)


def callback_name(callback: object) -> str:
    """Return how an error names a callback, such as `Camera.on_image`.

    >>> callback_name(partial(print, 1))
    'print'
    """
    while isinstance(callback, partial):
        callback = callback.func
    return getattr(callback, "__qualname__", None) or type(callback).__qualname__


def driven(callback: Callable[..., object]) -> Callable[..., None]:
    """Return a function that calls the callback, and runs its coroutine if it is a coroutine function."""

    def call(*arguments: object) -> None:
        outcome = callback(*arguments)
        if outcome is not None:
            drive(outcome, lambda _: None)

    return call


def drive(outcome: object, done: Callable[..., object]) -> None:
    """Pass the outcome of a callback to `done`; run a coroutine, and pass its result.

    Whenever the coroutine waits for a future, it goes on in that future's done callback.
    """
    if iscoroutine(outcome):
        _step(outcome, done)
    else:
        done(outcome)


def _step(coroutine: Coroutine[object, None, object], done: Callable[..., object]) -> None:
    try:
        awaited = coroutine.send(None)
    except StopIteration as end:
        done(end.value)
        return
    if not isinstance(awaited, Future):
        coroutine.close()
        raise TypeError(f"A callback may only wait for a sunset_ros.task.Future, got {awaited!r}.")
    awaited.add_done_callback(lambda _: _step(coroutine, done))
