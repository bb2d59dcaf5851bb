"""The page on several computers, and the script beside it."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from sunset.experiments import count_runs

DOCS = Path(__file__).parents[2] / "docs"
OPTIONS = ("--suite", "nofault", "--managers", "none", "--duration", "1", "--no-references", "--no-score")


@pytest.mark.thorough
def test_the_example_runs(tmp_path: Path) -> None:
    (example,) = re.findall(
        r"^```python\n(.*?)^```$", (DOCS / "clusters.md").read_text("utf-8"), re.MULTILINE | re.DOTALL
    )
    (tmp_path / "example.py").write_text(example, encoding="utf-8")
    subprocess.run([sys.executable, "example.py"], cwd=tmp_path, check=True, capture_output=True)
    assert count_runs(tmp_path / "calm") == (4, 4)  # those of the oracle, too


@pytest.mark.thorough
def test_a_job_array_runs_a_whole_campaign(tmp_path: Path) -> None:
    bin_folder = tmp_path / "bin"
    bin_folder.mkdir()
    command = bin_folder / "sunset"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m sunset "$@"\n', encoding="ascii")
    command.chmod(0o755)
    script = ["bash", str(DOCS / "clusters" / "campaign.slurm"), str(tmp_path / "results"), *OPTIONS]
    array = {"SLURM_ARRAY_TASK_COUNT": "2", "PATH": f"{bin_folder}:{os.environ['PATH']}"}
    for job in ("2", "1"):
        environment = os.environ | array | {"SLURM_ARRAY_TASK_ID": job}
        subprocess.run([*script, "--repetitions", "2"], env=environment, check=True, capture_output=True)
    assert count_runs(tmp_path / "results") == (2, 2)
