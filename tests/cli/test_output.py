"""What goes to stdout, whoever reads it and whatever a managing system prints."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from sunset.cli import main

pytestmark = pytest.mark.usefixtures("flight")

LOUD = """\
from sunset.managing import ManagingSystem

print("imported")

class Mine(ManagingSystem):
    def adapt(self, symptoms):
        print("{ look at me")
        self.get_logger().info("logged")
        self.set_parameter("kamera", "perform_autofocus", True)
"""


@pytest.mark.parametrize("arguments", [["run", "nofault"], ["bench", "--suite", "nofault", "--jobs", "2"]])
def test_what_a_managing_system_prints_is_no_part_of_the_json(
    arguments: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text(LOUD, encoding="utf-8")
    option = "--manager" if arguments[0] == "run" else "--managers"

    assert main([*arguments, option, f"{mine}:Mine", "--out", str(tmp_path / "out"), "--json"]) == 0

    out, err = capfd.readouterr()
    assert isinstance(json.loads(out), dict)
    assert "{ look at me" in err


def test_a_run_shows_what_the_managing_system_logs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text(LOUD, encoding="utf-8")

    assert main(["run", "nofault", "--manager", f"{mine}:Mine"]) == 0

    err = capsys.readouterr().err
    assert "[managing_system]: logged" in err
    assert "No node offers /managed_subsystem/kamera/set_parameters now" in err


def test_names_with_brackets_are_printed_as_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "brackets.yaml"
    file.write_text("name: '[/bold] [red]x'\nfaults: []\n", encoding="utf-8")

    assert main(["run", str(file), "--manager", "none"]) == 0

    assert "[/bold] [red]x" in capsys.readouterr().out.splitlines()


@pytest.mark.parametrize("arguments", [["faults", "list"], ["run", "nofault", "--manager", "none"]])
@pytest.mark.parametrize("reader", ["head -n 0", "head -n 1"])
def test_a_reader_that_has_seen_enough_is_no_error(arguments: list[str], reader: str) -> None:
    command = f"{sys.executable} -m sunset {' '.join(arguments)} | {reader}"

    done = subprocess.run(
        ["/bin/bash", "-o", "pipefail", "-c", command], capture_output=True, text=True, check=False
    )

    assert done.returncode == 0
    assert "Traceback" not in done.stderr
    assert "Broken" not in done.stderr


def test_a_terminal_without_arrows_gets_the_table_too(tmp_path: Path) -> None:
    assert main(["run", "nofault", "--manager", "none", "--out", str(tmp_path / "run")]) == 0

    done = subprocess.run(
        [sys.executable, "-m", "sunset", "report", str(tmp_path / "run")],
        capture_output=True,
        check=False,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
    )

    assert (done.returncode, done.stderr) == (0, b"")
    assert b"IoU ?" in done.stdout


@pytest.mark.parametrize("noun", ["faults", "managers", "models", "scenarios"])
def test_every_list_is_there_as_json(noun: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([noun, "list", "--json"]) == 0

    assert isinstance(json.loads(capsys.readouterr().out), dict)
