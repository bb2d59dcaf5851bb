"""The scripts that measure: what a user gets wrong with them."""

import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[2] / "scripts"


@pytest.mark.parametrize(
    ("script", "arguments", "words"),
    [
        ("count_episodes", ["nowhere"], "name the one that 'sunset bench --out' wrote."),
        ("count_episodes", ["."], "no folder with a run.json in it."),
        ("published_figures", ["nowhere"], "name the one that 'sunset bench --out' wrote."),
        ("measure_stride_limits", ["--every", "0"], "must be at least 1, got 0."),
        ("measure_stride_limits", ["--every", "-5"], "must be at least 1, got -5."),
    ],
)
def test_a_bad_argument(script: str, arguments: list[str], words: str, tmp_path: Path) -> None:
    if script == "measure_stride_limits":
        pytest.importorskip("torch")
    command = [sys.executable, str(SCRIPTS / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.strip().endswith(words)
