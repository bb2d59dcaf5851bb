"""The line in which things wait for the thread that handles them."""

import threading
import time
from collections import deque
from contextlib import suppress
from queue import Empty
from typing import Generic, TypeVar

T = TypeVar("T")


class WaitingLine(Generic[T]):
    """A queue without bounds that any thread and any signal handler fills, and one thread empties.

    `queue.SimpleQueue` would be it, but the one of CPython 3.11 waits forever, whatever its timeout, when its thread
    does not get a processor for longer than the timeout just before it begins to wait: it takes a negative time
    that is left for none given.
    """

    def __init__(self) -> None:
        self._items: deque[T] = deque()
        self._news = threading.Lock()  # locked unless something came since `get` looked last

    def put(self, item: T) -> None:
        """Add something at the end."""
        self._items.append(item)
        if self._news.locked():
            with suppress(RuntimeError):  # another thread unlocks it first
                self._news.release()

    def get(self, timeout_s: float | None = None) -> T:
        """Take what came first, having waited until there is something: for at most so many seconds, None for ever.

        Raises:
            queue.Empty: nothing came.
        """
        end_s = None if timeout_s is None else time.monotonic() + timeout_s
        while not self._items:
            if end_s is None:
                self._news.acquire()
            elif not self._news.acquire(timeout=max(0.0, end_s - time.monotonic())):
                raise Empty
        return self._items.popleft()

    def __bool__(self) -> bool:
        """Whether there is something."""
        return bool(self._items)
