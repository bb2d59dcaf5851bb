"""`sunset view`: a page of a stored run, or one sentence."""

import json
import os
import re
import shutil
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from sunset.cli import main
from sunset.experiments import RunSpec, prepare
from sunset.experiments.run import record_failure
from sunset.scenarios import Scenario


@pytest.fixture(scope="module")
def run(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a short run, in a folder of its own."""
    assert flight.exists()
    folder = tmp_path_factory.mktemp("view") / "short"
    assert main(["run", "gpu_failure", "--duration", "1", "--out", str(folder)]) == 0
    return folder


def test_the_page_is_named_after_the_run_and_opened(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    browser = tmp_path / "browser"
    browser.write_text('#!/bin/sh\necho "$1" > "$(dirname "$0")/opened"\n', encoding="utf-8")
    browser.chmod(browser.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("BROWSER", f"{browser} %s")
    before = {path: path.read_bytes() for path in run.iterdir()}

    assert main(["view", str(run)]) == 0

    told = capsys.readouterr()
    page = tmp_path / "short.html"
    assert told.out == ""
    assert told.err.endswith("The page is short.html.\n")
    assert (tmp_path / "opened").read_text(encoding="utf-8").strip() == page.as_uri()
    assert {path: path.read_bytes() for path in run.iterdir()} == before
    assert page.stat().st_size < 5_000_000


def test_a_page_that_is_not_opened_is_said_to_be_opened_in_a_browser(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BROWSER", "false")

    assert main(["view", str(run), "--no-open"]) == 0

    assert capsys.readouterr().err.endswith("The page is short.html: open it in a browser.\n")


def test_pictures_that_the_recorded_commands_do_not_make_are_said(run: Path, tmp_path: Path) -> None:
    folder, page = tmp_path / "other", tmp_path / "page.html"
    shutil.copytree(run, folder)
    record = json.loads((folder / "run.json").read_text())
    (folder / "run.json").write_text(json.dumps(record | {"seed": record["seed"] + 1}))

    assert main(["view", str(folder), "--no-open", "--out", str(page)]) == 0

    note = (
        r"without the managing system, and [0-9]+ of them differ from the run's: run it again with --images"
    )
    assert re.search(note, page.read_text())


def failed(_: Path, tmp_path: Path) -> list[str]:
    """Return a run that failed as a whole, as a campaign keeps it."""
    spec = RunSpec(scenario=Scenario("nofault"), manager="none")
    record_failure(spec, prepare(spec), tmp_path / "run", manager_checksum="", reason="A node failed.")
    return [str(tmp_path / "run")]


def damaged(run: Path, tmp_path: Path) -> list[str]:
    folder = tmp_path / "damaged"
    shutil.copytree(run, folder)
    (folder / "messages.mcap").write_bytes(b"nothing")
    return [str(folder)]


def other_seed(run: Path, tmp_path: Path) -> list[str]:
    folder = tmp_path / "other"
    assert main(["run", "gpu_failure", "--seed", "2", "--duration", "1", "--out", str(folder)]) == 0
    return [str(run), str(folder)]


def to_pipe(run: Path, tmp_path: Path) -> list[str]:
    os.mkfifo(tmp_path / "pipe")
    return [str(run), "--out", str(tmp_path / "pipe")]


MISTAKES: dict[str, tuple[Callable[[Path, Path], list[str]], str]] = {
    "a folder without a run": (lambda _, path: [str(path)], "is not a complete record: run.json is missing"),
    "no such folder": (lambda _, path: [str(path / "none")], "is not a complete record"),
    "a file": (lambda run, _: [str(run / "run.json")], "A record is a folder, got the file"),
    "a failed run": (failed, "has no time line, since it failed"),
    "a damaged run": (damaged, "is damaged"),
    "a flight that is gone": (lambda run, path: [str(run), "--bag", str(path / "bag")], "There is no bag at"),
    "another model": (lambda run, path: [str(run), "--model", str(path)], "model"),
    "two seeds": (other_seed, "if their seed is the same, got 1 and 2"),
    "itself beside it": (lambda run, _: [str(run), str(run)], "A run beside itself shows nothing"),
    "a folder to write to": (lambda run, path: [str(run), "--out", str(path)], "which is a folder"),
    "a folder that cannot be": (
        lambda run, _: [str(run), "--out", "/dev/null/page.html"],
        "The page /dev/null/page.html cannot be written: ",
    ),
    "a pipe to write to": (to_pipe, "not a regular file"),
    "a file of others": (
        lambda run, _: [str(run), "--out", str(run / "run.json")],
        "is not a page of 'sunset view'",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_sentence(
    run: Path,
    mistake: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments, words = MISTAKES[mistake]
    command = ["view", "--no-open", *arguments(run, tmp_path)]
    capsys.readouterr()

    assert main(command) == 2

    (line,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("sunset: ")]
    assert words in line
    assert line.endswith(".")
    assert not list(tmp_path.glob("*.html"))
