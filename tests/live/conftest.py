"""Tests of processes need the flight that they play; nothing here depends on how fast the computer is."""

from pathlib import Path

import pytest


@pytest.fixture(scope="session", autouse=True)
def rendered(flight: Path) -> None:
    """Render the default flight before a system is timed."""
