"""Tests of processes need the flight that they play; nothing here depends on how fast the computer is."""

import fcntl

import pytest

from sunset.data import cache_folder, default_flight


@pytest.fixture(scope="session", autouse=True)
def flight() -> None:
    """Render the default flight once, whichever test process comes first."""
    folder = cache_folder()
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / ".flight.lock").open("w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        default_flight()
