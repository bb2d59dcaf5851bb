"""What starts at once: the help of all verbs waits for no package that only one of them needs."""

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from sunset.cli.parser import VERBS

SLOW = {"apsw", "cv2", "cyclonedds", "embreex", "numpy", "onnxruntime", "rich", "rosbags", "yaml"}
"""Packages that SUNSET needs and that take long to import."""


def imported(program: str) -> set[str]:
    """Return what a program has imported when it ends, however it ends."""
    code = f"import json, sys\ntry:\n    {program}\nfinally:\n    print(json.dumps(list(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    return set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize(
    "program",
    [
        "import sunset",
        *(
            f"from sunset.cli import main; main({words})"
            for words in ([], ["--help"], ["--version"], ["rnu"])
        ),
    ],
)
def test_what_names_no_verb_imports_none(program: str) -> None:
    modules = imported(program)

    assert "sunset" in modules
    verbs = {verb.module or f"sunset.cli.{name}" for name, verb in VERBS.items()}
    assert modules & (SLOW | verbs) == set()


@pytest.mark.parametrize("words", [["scenarios", "--help"], ["report", "--help"]])
def test_a_verb_imports_no_other(words: list[str]) -> None:
    modules = imported(f"from sunset.cli import main; main({words})")

    loaded = {name for name, verb in VERBS.items() if (verb.module or f"sunset.cli.{name}") in modules}
    assert loaded == {words[0]}


@pytest.mark.parametrize("verb", ["faults", "scenarios"])
def test_a_list_imports_few_modules_and_no_slow_package(verb: str) -> None:
    modules = imported(f"from sunset.cli import main; main(['{verb}', 'list'])")

    assert f"sunset.cli.{verb}" in modules
    assert modules & (SLOW - {"rich", "yaml"}) == set()
    assert len([name for name in modules if name.startswith("sunset")]) < 120


def test_showing_a_model_imports_nothing_that_trains() -> None:
    modules = imported("from sunset.cli import main; main(['models', 'show', 'lite'])")

    assert "sunset.cli.models" in modules
    assert {name for name in modules if name.startswith("sunset_lab")} == set()


def test_the_toolbox_for_ros_imports_nothing_of_experiments() -> None:
    modules = imported("from sunset.cli import main; main(['ros', '--help'])")

    assert "sunset_ros" in modules
    assert modules & {"cv2", "embreex", "onnxruntime", "rosbags", "sunset.experiments"} == set()


def test_the_distribution_can_be_run_by_its_own_name() -> None:
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))[
        "project"
    ]

    assert project["scripts"][project["name"]] == project["scripts"]["sunset"]
