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
        ("draw_pictures", ["fog"], "depth_degradation, autofocus_needed"),
    ],
)
def test_a_bad_argument(script: str, arguments: list[str], words: str, tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPTS / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.strip().endswith(words)


@pytest.mark.thorough
@pytest.mark.parametrize("every", ["0", "-5"])
def test_a_bad_argument_of_the_script_that_needs_torch(every: str, tmp_path: Path) -> None:
    pytest.importorskip("torch")
    words = f"must be at least 1, got {every}."
    test_a_bad_argument("measure_stride_limits", ["--every", every], words, tmp_path)
