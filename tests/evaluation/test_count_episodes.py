"""The script that counts episodes by failure."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "scripts/count_episodes"


@pytest.mark.thorough
def test_runs_that_do_not_count_are_not_counted(store: Callable[..., Path], tmp_path: Path) -> None:
    store("run", valid=False, reason="it read the truth")
    command = [sys.executable, str(SCRIPT), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.endswith("has no valid run of baseline on paper.\n")
