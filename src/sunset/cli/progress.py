"""Progress on stderr, from the beginning of a stage to its end, however long its steps take."""

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, redirect_stdout
from datetime import timedelta
from functools import partial
from time import monotonic
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from rich.console import Console

BUILDING: Final = "Building the town"
"""The stage before the first frame of a flight is rendered."""

_QUICK_S: Final = 0.5
"""Stages shorter than this print no line."""
_LINE_EVERY_S: Final = 1.5
_FRAME_EVERY_S: Final = 0.1
_LONG_S: Final = 600
"""After this time, lines are further apart: by `_SHARE` of the time so far."""
_SHARE: Final = 1 / 30


_drawing = threading.Lock()
# a process that is forked while a line is written would wait for its locks for ever
os.register_at_fork(
    before=_drawing.acquire, after_in_parent=_drawing.release, after_in_child=_drawing.release
)


@contextmanager
def progress_bar(text: str) -> Iterator[Callable[..., None]]:
    """Draw a stage and its duration; give a function `(done, total, note)` that updates it.

    If stderr is not a terminal, or cannot draw, lines replace the bar; after ten minutes they come less often.
    """
    from rich.console import Console  # noqa: PLC0415  slow, and many verbs show no progress

    console = Console(stderr=True)
    draws = console.is_terminal and not console.is_dumb_terminal
    with _bar(console, text) if draws else _lines(text) as update:
        yield update


@contextmanager
def _bar(console: "Console", text: str) -> Iterator[Callable[..., None]]:
    from rich.progress import (  # noqa: PLC0415  likewise
        BarColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[count]}"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
    )
    with Progress(*columns, console=console, auto_refresh=False) as bar:
        task = bar.add_task(text, total=None, count="", note="")

        def draw() -> float:
            bar.refresh()
            return _FRAME_EVERY_S

        def update(done: int, total: int, note: str = "") -> None:
            bar.update(task, completed=done, total=total, count=f"{done}/{total}", note=note)

        try:
            with _repeating(draw, 0):
                yield update
        finally:
            bar.live.transient = not bar.finished


@contextmanager
def _lines(text: str) -> Iterator[Callable[..., None]]:
    began = monotonic()
    count = left = ""
    first: tuple[float, int] | None = None  # the first update: resumed work does not begin at 0
    shown: str | None = None

    def draw() -> float:
        nonlocal shown
        shown = count
        seconds = monotonic() - began
        print(f"{text}: {count}{', ' if count else ''}{seconds:.0f} s{left}", file=sys.stderr, flush=True)
        return _LINE_EVERY_S if seconds < _LONG_S else seconds * _SHARE

    def update(done: int, total: int, note: str = "") -> None:
        nonlocal count, left, first
        count = f"{done} of {total}{', ' if note else ''}{note}"
        now = monotonic()
        start, before = first = first or (now, done)
        seconds = (now - start) * (total - done) / (done - before) if done > before else 0.0
        left = f", {timedelta(seconds=round(seconds))} left" if round(seconds) else ""

    try:
        with _repeating(draw, _QUICK_S):
            yield update
    finally:
        if shown not in {None, count}:
            draw()


@contextmanager
def _repeating(draw: Callable[[], float], pause_s: float) -> Iterator[None]:
    """Call `draw` on a thread after a pause, and again after each pause that it returns."""
    over = threading.Event()

    def repeat() -> None:
        pause = pause_s
        while not over.wait(pause):
            with _drawing:
                pause = draw()

    drawer = threading.Thread(target=repeat, daemon=True)
    drawer.start()
    try:
        yield
    finally:
        over.set()
        drawer.join()


@contextmanager
def rendering_progress() -> Iterator[Callable[[str, int, int], None]]:
    """Give the progress of preparing runs: loading models and bags, and rendering and measuring new flights."""
    with stages_progress() as stage:
        yield rendering_stages(stage)


def rendering_stages(stage: Callable[..., None]) -> Callable[[str, int, int], None]:
    """Return the function of `rendering_progress`, on a function of `stages_progress`."""
    from sunset.data import RENDERING, flights_folder  # noqa: PLC0415  slow, and not needed for the bars

    stage("Preparing")

    def update(name: str, done: int, total: int) -> None:
        if name == RENDERING and done == 0:
            print(
                f"The frames of the flight are rendered once, into {flights_folder()}; later runs read them there.",
                file=sys.stderr,
            )
            stage(BUILDING)  # which takes longer than many frames
        elif not total:
            stage(name)
        else:
            stage(name, done, total)
            if done == total:
                stage("Preparing")

    return update


@contextmanager
def run_progress(
    text: str, campaigns: int = 1
) -> "Iterator[tuple[Callable[[str, int, int], None], RunCounter]]":
    """Give the progress of preparing runs and of the runs, the stage `text`; output of runs goes to stderr."""
    with redirect_stdout(sys.stderr), stages_progress() as stage:
        yield rendering_stages(stage), RunCounter(partial(stage, text), campaigns)


@contextmanager
def stages_progress() -> Iterator[Callable[..., None]]:
    """Give a function `(stage, done, total, note)` that draws a bar for each stage; without numbers it begins a bar."""
    with ExitStack() as bars:
        current: dict[str, Callable[..., None]] = {}

        def update(name: str, done: int | None = None, total: int = 0, note: str = "") -> None:
            if name not in current:
                bars.close()
                current.clear()
                current[name] = bars.enter_context(progress_bar(name))
            if done is not None:
                current[name](done, total, note)

        yield update


class RunCounter:
    """Passes the progress of campaigns on and counts their runs; each begins with the number of stored runs."""

    def __init__(self, update: Callable[[int, int], None], campaigns: int) -> None:
        self._update = update
        self._calls = -campaigns
        self._total = 0

    def __call__(self, done: int, total: int) -> None:
        """Note that so many runs are finished."""
        self._calls += 1
        self._total = total
        self._update(done, total)

    def __str__(self) -> str:
        """Return how many runs were done."""
        return f"{self._calls} runs done, {self._total - self._calls} were there already."
