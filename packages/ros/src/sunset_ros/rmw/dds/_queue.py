"""A queue for signal handlers and threads."""

import threading
import time
from collections import deque
from contextlib import suppress
from queue import Empty
from typing import Generic, TypeVar

T = TypeVar("T")


class WaitingLine(Generic[T]):
    """An unbounded queue that threads and signal handlers fill, and a single thread empties.

    `queue.SimpleQueue` of CPython 3.11 can block for ever: it takes a timeout that passes just before it begins to wait
    for no timeout.
    """

    def __init__(self) -> None:
        self._items: deque[T] = deque()
        self._news = threading.Lock()  # locked unless an item has come since the last `get`

    def put(self, item: T) -> None:
        """Add an item at the end."""
        self._items.append(item)
        if self._news.locked():
            with suppress(RuntimeError):  # another thread unlocks it first
                self._news.release()

    def get(self, timeout_s: float | None = None) -> T:
        """Take the first item after a wait of at most so many seconds, None for ever; raise `Empty` without one."""
        end_s = None if timeout_s is None else time.monotonic() + timeout_s
        while not self._items:
            if not self._news.acquire(timeout=-1 if end_s is None else max(0.0, end_s - time.monotonic())):
                raise Empty
        return self._items.popleft()

    def __bool__(self) -> bool:
        """Return whether there are items."""
        return bool(self._items)
