"""Long work says on stderr what it does, from its beginning on."""

import io
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from rich.console import Console
from tests.cli.conftest import PROGRESS

from sunset.cli import progress as module
from sunset.cli.progress import progress_bar, rendering_progress
from sunset.processes.calls import Watch, call_isolated


def wait(seconds: float) -> None:
    threading.Event().wait(seconds)


def wait_until(predicate: Callable[[], bool]) -> None:
    """Wait until something has happened, however busy the computer is."""
    end = time.monotonic() + 20
    while not predicate():
        assert time.monotonic() < end
        wait(0.01)


class Stderr:
    """What has been written to stderr."""

    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self._capsys = capsys
        self._told = ""

    @property
    def lines(self) -> list[str]:
        """The lines of it."""
        self._told += self._capsys.readouterr().err
        return self._told.splitlines()


@pytest.fixture
def stderr(capsys: pytest.CaptureFixture[str]) -> Stderr:
    return Stderr(capsys)


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let lines come soon; no time passes for them."""
    monkeypatch.setattr(module, "monotonic", lambda: 7.0)
    monkeypatch.setattr(module, "_QUICK_S", 0.01)
    monkeypatch.setattr(module, "_LINE_EVERY_S", 0.05)


@pytest.mark.usefixtures("impatient")
def test_work_that_never_says_how_far_it_is_is_not_silent(stderr: Stderr) -> None:
    with progress_bar("Building"):
        wait_until(lambda: len(stderr.lines) > 3)

    assert stderr.lines[0] == "Building: 0 s"
    assert all(PROGRESS.fullmatch(line) for line in stderr.lines)


@pytest.mark.usefixtures("impatient")
def test_the_last_line_says_how_far_it_came(stderr: Stderr) -> None:
    with progress_bar("Building") as progress:
        wait_until(lambda: bool(stderr.lines))
        progress(7, 7)

    assert stderr.lines[0] == "Building: 0 s"
    assert stderr.lines[-1] == "Building: 7 of 7, 0 s"


def test_lines_tell_a_remark_and_the_time_that_is_left(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    times = iter((0.0, 10.0, 85.0, 90.0, 95.0))
    draws: list[Callable[[], float]] = []

    @contextmanager
    def once(draw: Callable[[], float], _: float) -> Iterator[None]:
        draws.append(draw)
        yield

    monkeypatch.setattr(module, "monotonic", lambda: next(times))
    monkeypatch.setattr(module, "_repeating", once)
    with progress_bar("rgb") as progress:
        progress(100, 400)  # resumed
        progress(250, 400, "loss rgb 1.500")
        draws[0]()

    # 150 steps took 75 s, and 150 are left
    assert capsys.readouterr().err.splitlines() == ["rgb: 250 of 400, loss rgb 1.500, 90 s, 0:01:15 left"]


def test_lines_of_long_work_are_far_apart(monkeypatch: pytest.MonkeyPatch, stderr: Stderr) -> None:
    monkeypatch.setattr(module, "_QUICK_S", 0.01)
    monkeypatch.setattr(module, "_LONG_S", 0.005)
    monkeypatch.setattr(module, "_SHARE", 1)  # the next line after as long again

    with progress_bar("Building"):
        wait(1.0)
        wait_until(lambda: len(stderr.lines) >= 3)

    assert len(stderr.lines) <= 8  # at 0.01, 0.02, 0.04, … s


def test_lines_are_less_than_2_s_apart_for_ten_minutes(monkeypatch: pytest.MonkeyPatch) -> None:
    times = iter((0.0, 599.0))
    pauses: list[float] = []

    @contextmanager
    def once(draw: Callable[[], float], _: float) -> Iterator[None]:
        pauses.append(draw())
        yield

    monkeypatch.setattr(module, "monotonic", lambda: next(times))
    monkeypatch.setattr(module, "_repeating", once)
    with progress_bar("Building"):
        pass

    assert pauses[0] < 2


def test_quick_work_is_done_in_silence(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("Building"):
        pass

    assert capsys.readouterr().err == ""


def test_a_terminal_shows_the_work_before_it_says_how_far_it_is() -> None:
    text, xterm = io.StringIO(), {"TERM": "xterm"}
    with module._bar(Console(file=text, force_terminal=True, width=80, _environ=xterm), "Building"):
        wait_until(lambda: "Building" in text.getvalue())


@pytest.mark.usefixtures("impatient")
def test_a_terminal_that_cannot_draw_gets_lines(stderr: Stderr, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes stderr for a terminal then
    monkeypatch.setenv("TERM", "dumb")
    with progress_bar("Building"):
        wait_until(lambda: "Building: 0 s" in stderr.lines)


@pytest.mark.usefixtures("impatient")
def test_that_frames_are_rendered_is_explained_once(stderr: Stderr) -> None:
    with rendering_progress() as progress:
        wait_until(lambda: bool(stderr.lines))
        for done, line in enumerate(("Building the town: 0 s", "Rendering: 1 of 2, 0 s", "Preparing: 0 s")):
            before = len(stderr.lines)
            progress("Rendering", done, 2)
            wait_until(lambda line=line, before=before: line in stderr.lines[before:])  # type: ignore[misc]

    lines = stderr.lines
    (explained,) = [line for line in lines if not PROGRESS.fullmatch(line)]
    assert explained.startswith("The frames of the flight are rendered once, into ")
    assert [line.split(":")[0] for line in lines if "0 s" in line][:1] == ["Preparing"]
    assert "Building the town: 0 s" in lines
    assert "Rendering: 1 of 2, 0 s" in lines
    assert lines[-1].startswith("Preparing: ")


@pytest.mark.thorough
@pytest.mark.parametrize("terminal", [False, True])
def test_a_process_forked_while_it_is_drawn_can_write_to_stderr(
    terminal: bool, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name in ("_QUICK_S", "_LINE_EVERY_S", "_FRAME_EVERY_S", "_SHARE"):
        monkeypatch.setattr(module, name, 0)
    if terminal:
        monkeypatch.setenv("FORCE_COLOR", "1")  # rich takes stderr for one then

    def say(_: Watch) -> None:
        sys.stderr.write("heard\n")

    with progress_bar("Building"):
        for _ in range(30):
            call_isolated(say, limit_s=10)

    assert capfd.readouterr().err.count("heard") == 30
