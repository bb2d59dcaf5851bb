"""Users' callbacks: their names in errors, and coroutines."""

from collections.abc import Callable, Coroutine
from functools import partial
from inspect import iscoroutine

from sunset_ros.task import Future


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
