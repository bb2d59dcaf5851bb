"""Frames out of picture files: several are read at a time, and given in order."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from sunset.data.frame import Frame

T = TypeVar("T")


def read_ahead(read: Callable[[T], Frame], items: Iterable[T], *, jobs: int | None = None) -> Iterator[Frame]:
    """Yield `read(item)` for each item, in order; several threads read a few frames ahead.

    The number of threads changes no byte.

    Args:
        read: reads one frame; called on other threads.
        items: what it is called with.
        jobs: how many threads read; as many as there are processors if not given.
    """
    workers = jobs or os.cpu_count() or 1
    pool = ThreadPoolExecutor(workers)
    pending: deque[Future[Frame]] = deque()
    try:
        for item in items:
            pending.append(pool.submit(read, item))
            if len(pending) > 2 * workers:
                yield pending.popleft().result()
        while pending:
            yield pending.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)
