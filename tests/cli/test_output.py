"""What goes to stdout, whoever reads it and whatever a managing system prints."""

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.processes.confinement import walls
from sunset.processes.confinement.walls import missing_walls

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


@pytest.mark.thorough
@pytest.mark.parametrize(
    "arguments",
    [["run", "nofault"], ["bench", "--suite", "nofault", "--no-references", "--no-score", "--jobs", "2"]],
)
def test_what_a_managing_system_prints_is_no_part_of_the_json(
    arguments: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text(LOUD, encoding="utf-8")
    option = "--manager" if arguments[0] == "run" else "--managers"

    words = [*arguments, option, f"{mine}:Mine", "--duration", "1", "--out", str(tmp_path / "out"), "--json"]
    assert main(words) == 0

    out, err = capfd.readouterr()
    assert isinstance(json.loads(out), dict)
    assert "{ look at me" in err


def test_a_campaign_in_which_a_managing_system_always_fails_ends_with_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    managers = f"none,ends=exec:{sys.executable} -c exit()"
    command = ["bench", "--suite", "nofault", "--no-references", "--no-score", "--managers", managers]

    assert main([*command, "--repetitions", "1", "--duration", "1", "--out", str(tmp_path / "out")]) == 1

    assert "ends failed in each of its runs: The managing system exec:" in capsys.readouterr().err


@pytest.mark.parametrize("landlock", [True, False])
def test_a_missing_wall_is_said_by_the_run_its_record_and_its_report(
    landlock: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
) -> None:
    mine, out = tmp_path / "mine.py", tmp_path / "run"
    mine.write_text(LOUD, encoding="utf-8")
    if not landlock:
        monkeypatch.setattr(walls, "landlock_version", lambda: 0)
    missing = list(missing_walls())

    assert main(["run", "nofault", "--manager", f"{mine}:Mine", "--duration", "1", "--out", str(out)]) == 0
    warned = "Managing systems run without Landlock on this system" in caplog.text
    capsys.readouterr()
    assert main(["report", str(out), "--format", "table"]) == 0
    noted = "1 run took place without Landlock" in capsys.readouterr().out

    assert json.loads((out / "run.json").read_text())["missing_walls"] == missing
    assert (warned, noted) == ("Landlock" in missing, "Landlock" in missing)


FOCUSING = """\
from sunset.managing import ManagingSystem

class Mine(ManagingSystem):
    def adapt(self, symptoms):
        if symptoms.autofocus_needed:
            self.get_logger().info(f"blurred at {self.get_clock().now().nanoseconds}")
            self.set_parameter("kamera", "perform_autofocus", True)
            self.set_parameter("camera", "perform_autofocus", True)
"""


@pytest.mark.thorough
def test_what_the_managing_system_logs_stands_in_the_time_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text(FOCUSING, encoding="utf-8")
    out = tmp_path / "run"

    assert (
        main(["run", "autofocus_needed", "--manager", f"{mine}:Mine", "--duration", "4", "--out", str(out)])
        == 0
    )

    told, err = capsys.readouterr()
    assert "blurred" not in err
    rows = [line.split() for line in told.splitlines() if re.match(r" +-?\d+\.\d\d s  ", line)]
    (logged,) = [row for row in rows if "blurred" in row]
    start_ns = json.loads((out / "run.json").read_text())["start_ns"]
    assert float(logged[0]) == pytest.approx((int(logged[-1]) - start_ns) / 1e9, abs=0.005)
    kinds = [row[2] for row in rows]
    assert kinds == ["fault", "symptom", "log", "log", "adaptation", "cured", "end"]
    assert any(row[3:7] == ["WARN:", "No", "node", "offers"] for row in rows)


def test_the_time_line_of_a_stored_run_is_printed_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text(FOCUSING, encoding="utf-8")
    out = str(tmp_path / "run")
    scenario = "gpu_failure+image_shift"

    assert main(["run", scenario, "--manager", f"mine={mine}:Mine", "--duration", "5", "--out", out]) == 0
    printed = capsys.readouterr().out
    mine.unlink()
    assert main(["report", out]) == 0

    assert capsys.readouterr().out == printed
    assert "managing system mine, seed 1" in printed


def test_runs_are_listed_a_row_each(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    command = [
        "bench",
        "--suite",
        "nofault",
        "--managers",
        "none,idle=none",
        "--repetitions",
        "2",
        "--jobs",
        "1",
    ]
    assert (
        main([*command, "--no-references", "--no-score", "--duration", "1", "--out", str(out), "--json"]) == 0
    )
    capsys.readouterr()

    assert main(["report", str(out), "--runs", "--format", "json"]) == 0
    runs = json.loads(capsys.readouterr().out)["runs"]
    assert main(["report", str(out), "--runs"]) == 0
    lines = list(csv.DictReader(capsys.readouterr().out.splitlines()))

    assert [(run["manager"], run["seed"]) for run in runs] == [
        ("idle", 1),
        ("idle", 2),
        ("none", 1),
        ("none", 2),
    ]
    for run, line in zip(runs, lines, strict=True):
        stored = json.loads((out / run["folder"] / "run.json").read_text())
        assert {key: run[key] for key in ("scenario", "manager", "seed", "valid", "digest")} == {
            key: stored[key] for key in ("scenario", "manager", "seed", "valid", "digest")
        }
        assert (stored["duration_s"], stored["expected_frames"]) == (1.0, 10)
        assert run.items() >= stored["metrics"].items()
        assert line.keys() == run.keys()
        assert line["valid"] == "true"
        assert line["t_react_s"] == ""
        assert float(line["iou"]) == run["iou"]


@pytest.mark.thorough
def test_names_with_brackets_are_printed_as_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "brackets.yaml"
    file.write_text("name: '[/bold] [red]x'\nfaults: []\n", encoding="utf-8")

    assert main(["run", str(file), "--manager", "none", "--duration", "1"]) == 0

    assert "[/bold] [red]x" in capsys.readouterr().out.splitlines()


@pytest.mark.thorough
@pytest.mark.parametrize(
    "arguments", [["faults", "list"], ["run", "nofault", "--manager", "none", "--duration", "1"]]
)
@pytest.mark.parametrize("reader", ["head -n 0", "head -n 1"])
def test_a_reader_that_has_seen_enough_is_no_error(arguments: list[str], reader: str) -> None:
    command = f"{sys.executable} -m sunset {' '.join(arguments)} | {reader}"

    done = subprocess.run(
        ["/bin/bash", "-o", "pipefail", "-c", command], capture_output=True, text=True, check=False
    )

    assert done.returncode == 0
    assert "Traceback" not in done.stderr
    assert "Broken" not in done.stderr


@pytest.mark.thorough
def test_a_terminal_without_arrows_gets_the_table_too(tmp_path: Path) -> None:
    assert (
        main(["run", "nofault", "--duration", "1", "--manager", "none", "--out", str(tmp_path / "run")]) == 0
    )

    done = subprocess.run(
        [sys.executable, "-m", "sunset", "report", str(tmp_path / "run"), "--format", "table"],
        capture_output=True,
        check=False,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
    )

    assert done.returncode == 0, done.stderr
    assert b"IoU ?" in done.stdout


@pytest.mark.parametrize(
    "noun", ["faults", "managers", pytest.param("models", marks=pytest.mark.thorough), "scenarios"]
)
def test_every_list_is_there_as_json(noun: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([noun, "list", "--json"]) == 0

    assert isinstance(json.loads(capsys.readouterr().out), dict)


@pytest.mark.thorough
def test_what_a_terminal_would_obey_is_shown_instead(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    assert main(["run", "nofault", "--manager", "none", "--duration", "2", "--out", str(run)]) == 0
    described = json.loads((run / "run.json").read_text())
    (run / "run.json").write_text(json.dumps(described | {"model": "lite\x1b[2J"}))
    assert main(["report", str(run)]) == 0
    assert main(["report", str(tmp_path / "none\x1b[2J")]) == 2

    out, err = capsys.readouterr()
    assert r"model lite\x1b[2J" in out
    assert r"none\x1b[2J; name the one" in err
    assert "\x1b" not in out + err


@pytest.mark.thorough
def test_what_a_managing_system_logs_reaches_a_terminal_as_text_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text(LOUD.replace('"logged"', '"logged \\x1b[2J"'), encoding="utf-8")

    assert main(["run", "nofault", "--duration", "1", "--manager", f"{mine}:Mine"]) == 0

    out, _ = capsys.readouterr()
    assert r"logged \x1b[2J" in out
    assert "\x1b" not in out


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("arguments", "code"), [(["run", "nofault", "--duration", "1"], 0), (["run", "nope"], 2)]
)
def test_closed_streams_change_no_exit_code_and_get_no_other_file(
    arguments: list[str], code: int, tmp_path: Path
) -> None:
    command = [sys.executable, "-m", "sunset", *arguments]
    with (tmp_path / "stderr").open("w+b") as stderr:
        unseen = subprocess.run(["/bin/sh", "-c", '"$@" <&- >&-', "sh", *command], stderr=stderr, check=False)
        stderr.write(b"the end")
    silent = subprocess.run(["/bin/sh", "-c", '"$@" 2>&-', "sh", *command], capture_output=True, check=False)

    assert (unseen.returncode, silent.returncode) == (code, code)
    assert (tmp_path / "stderr").read_bytes().endswith(b".\nthe end")
