"""The scripts that measure: what a user gets wrong with them."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[2] / "scripts"


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("script", "arguments", "words"),
    [
        ("count_episodes", ["nowhere"], "name the one that 'sunset bench --out' wrote."),
        ("count_episodes", ["."], "no folder with a run.json in it."),
        ("artifact", ["nothing"], "name some of run, same, table, workers, recompute, bundle, rules, live."),
        ("try_assumptions", ["nowhere", "flown"], "name the one that 'sunset bench --out' wrote."),
        ("draw_pictures", ["fog"], "depth_degradation, autofocus_needed"),
    ],
)
def test_a_bad_argument(script: str, arguments: list[str], words: str, tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPTS / script), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.strip().endswith(words)


def run_artifact(*words: str) -> str:
    command = [sys.executable, str(SCRIPTS / "artifact"), *words]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def test_the_page_for_reviewers_has_the_claims_of_the_script() -> None:
    page = (SCRIPTS.parent / "ARTIFACT.md").read_text(encoding="utf-8")

    assert re.findall(r"^\| `(\w+)`: ", page, re.MULTILINE) == [
        line.split()[0] for line in run_artifact("--list").splitlines()
    ]


@pytest.mark.thorough
def test_a_claim_is_checked_and_told_in_a_line(flight: Path) -> None:
    assert flight.exists()
    claim, *more, end = run_artifact("rules").splitlines()

    assert re.fullmatch(
        r"pass +\d+ s  rules: who looks at the truth is found out; the run counts: expected False, got False",
        claim,
    )
    assert all(line.startswith("pass ") for line in more)
    assert re.fullmatch(r"\d+ s in all, none failed\.", end)


@pytest.mark.thorough
@pytest.mark.parametrize("every", ["0", "-5"])
def test_a_bad_argument_of_the_script_that_needs_torch(every: str, tmp_path: Path) -> None:
    pytest.importorskip("torch")
    words = f"must be at least 1, got {every}."
    test_a_bad_argument("measure_stride_limits", ["--every", every], words, tmp_path)


def test_the_artifact_goes_on_after_a_command_that_fails() -> None:
    done = subprocess.run(
        [sys.executable, str(SCRIPTS / "artifact"), "run", "rules"],
        env=os.environ | {"SUNSET_CACHE_DIR": "/proc/nowhere"},
        capture_output=True,
        text=True,
        check=False,
    )
    *lines, last = done.stdout.splitlines()
    assert [line.split()[0] for line in lines] == ["FAIL", "FAIL"]
    assert all("the cache folder" in line or "SUNSET_CACHE_DIR" in line for line in lines)
    assert (done.returncode, done.stderr) == (1, "")
    assert last.endswith("2 failed.")


def test_the_artifact_says_how_to_make_the_environment_that_it_needs() -> None:
    without_packages = [sys.executable, "-S", str(SCRIPTS / "artifact")]
    done = subprocess.run(without_packages, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "SUNSET is not installed" in done.stderr
    assert "pip install ./packages/ros '.[live]'" in done.stderr
