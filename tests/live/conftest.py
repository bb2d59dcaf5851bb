"""Tests of processes need the flight that they play; nothing here depends on how fast the computer is.

Those of the group `live` look at what a run was, and come one after the other; beside them come those of the group
`processes`, which look at what becomes of processes.
"""

from pathlib import Path

import pytest


@pytest.fixture(scope="session", autouse=True)
def rendered(flight: Path) -> None:
    """Render the default flight before a system is timed."""
