"""Reading of frames from picture files by several threads."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from sunset.town import Frame

T = TypeVar("T")


def read_ahead(read: Callable[[T], Frame], items: Iterable[T], *, jobs: int | None = None) -> Iterator[Frame]:
    """Yield `read(item)` for each item, in order; `jobs` threads, by default one a processor, read ahead.

    Their number changes no byte.
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
