"""What tests of whole experiments share."""

import fcntl
from pathlib import Path

import pytest

from sunset.data import cache_folder, default_flight
from sunset.experiments import Timing

SHORT = Timing(duration_s=8.0, warm_up_s=1.0)
"""Long enough for the longest redeploy (4 s) and for what follows it to settle."""


@pytest.fixture(scope="session")
def flight() -> Path:
    """The default flight, rendered by one of the test processes if it is not in the cache."""
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".tests.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return default_flight()
