"""What all tests share."""

import fcntl
from pathlib import Path

import pytest

from sunset.data import cache_folder, default_flight


@pytest.fixture(scope="session")
def flight() -> Path:
    """The default flight, rendered by one of the test processes if it is not in the cache yet."""
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".tests.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return default_flight()
