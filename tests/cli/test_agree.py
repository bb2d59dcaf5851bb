"""`sunset agree`: what it runs, what it keeps, and what it refuses."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.experiments import BenchSpec, Settings, Timing, bench

pytestmark = pytest.mark.thorough

SHORT = Settings(timing=Timing(duration_s=4.0))


def agree(out: Path, *more: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "sunset", "agree", "--suite", "nofault", "--managers", "none"]
    command += ["--rate", "10", "--duration", "4", "--out", str(out), "--json", *more]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.xdist_group("live")
@pytest.mark.usefixtures("flight")
def test_the_same_seeds_are_run_in_the_simulation_and_live_and_kept(tmp_path: Path) -> None:
    first = agree(tmp_path)

    assert first.returncode == 0, first.stderr
    (row,) = json.loads(first.stdout)["rows"]
    # whether the computer kept up at ten times the speed is its own affair
    assert row["pairs"] + len(row["left_out"]) == 1
    runs = {file.relative_to(tmp_path): json.loads(file.read_text()) for file in tmp_path.rglob("run.json")}
    place = Path("runs/nofault/none/nofault/seed-1/run.json")
    assert {str(file): run["middleware"] for file, run in runs.items()} == {
        str("sim" / place): "sim",
        str("live" / place): "cyclonedds",
    }
    assert runs["live" / place]["speed"] == 10.0

    again = agree(tmp_path)

    assert again.stdout == first.stdout
    assert "0 runs done, 2 were there already." in again.stderr
    assert agree(tmp_path, "--stored").stdout == first.stdout


@pytest.fixture
def stored(tmp_path: Path, flight: Path) -> Path:
    """Return a folder with simulated runs in the place of the live ones, too."""
    del flight
    out = tmp_path / "stored"
    spec = BenchSpec(
        suite="nofault", references=False, score=False, managers=("none",), repetitions=1, settings=SHORT
    )
    assert bench(spec, out / "sim", jobs=1) == 1
    shutil.copytree(out / "sim", out / "live")
    return out


def test_stored_runs_are_compared_without_running(stored: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = sorted(stored.rglob("*"))

    assert main(["agree", "--stored", "--out", str(stored)]) == 0

    text = capsys.readouterr().out
    assert "none on nofault, model lite [4 s]: 1 pair, 0 left out" in text
    assert "The same failures appeared in 1 of 1 pair, throughout in 1 of 1 scenario." in text
    assert sorted(stored.rglob("*")) == before


def test_nothing_else_is_printed_on_stdout(stored: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["agree", "--stored", "--out", str(stored), "--format", "json"]) == 0

    out = capsys.readouterr().out
    assert out.startswith("{")
    assert out.endswith("}\n")


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["--suite", "rainy"], "rainy"),
        (["--scenarios", "rain"], "The suite artifact has no scenario 'rain'"),
        (["--managers", "external"], "live run only"),
        (["--rate", "0"], "rate of a live run"),
        (["--stored"], "There is no folder"),
        (["--format", "clay"], "clay"),
    ],
)
def test_what_cannot_be_used_is_said_in_one_sentence_and_nothing_is_run(
    arguments: Sequence[str], word: str, tmp_path: Path, complaint: Callable[[Sequence[str]], str]
) -> None:
    assert word in complaint(["agree", "--out", "o", *arguments])

    assert not (tmp_path / "o").exists()
