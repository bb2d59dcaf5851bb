"""Progress on stderr: what is being done, from its beginning to its end, however long its steps take."""

import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from datetime import timedelta
from time import monotonic
from typing import Final

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from sunset.data import RENDERING, flights_folder

BUILDING: Final = "Building the town"
"""What is done before the first frame of a flight is rendered."""

_QUICK_S: Final = 0.5
"""Stages shorter than this print no line."""
_LINE_EVERY_S: Final = 1.5
_FRAME_EVERY_S: Final = 0.1
_LONG_S: Final = 600
"""After this time, lines are further apart: by `_SHARE` of the time so far."""
_SHARE: Final = 1 / 30


_drawing = threading.Lock()
# a process that is forked in the middle of a line would wait for ever for the locks of what writes it
os.register_at_fork(
    before=_drawing.acquire, after_in_parent=_drawing.release, after_in_child=_drawing.release
)


@contextmanager
def progress_bar(text: str) -> Iterator[Callable[..., None]]:
    """Draw what is being done and for how long; give a function `(done, total, note)` that says how far it is.

    Where stderr is not a terminal, or one that cannot draw, lines stand in for the bar, further apart where it takes
    very long.
    """
    console = Console(stderr=True)
    draws = console.is_terminal and not console.is_dumb_terminal
    with _bar(console, text) if draws else _lines(text) as update:
        yield update


@contextmanager
def _bar(console: Console, text: str) -> Iterator[Callable[..., None]]:
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
    first: tuple[float, int] | None = None  # when it first said how far it was: what is resumed is not at 0
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
    """Call `draw` after a pause, and again after each pause that it returns, whatever else is done meanwhile."""
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
    """Give the progress of loading what a run needs, and of rendering and measuring its flight, which happens once."""
    with stages_progress() as stage:
        yield rendering_stages(stage)


def rendering_stages(stage: Callable[..., None]) -> Callable[[str, int, int], None]:
    """Return what `rendering_progress` gives, on a function that `stages_progress` gave."""
    stage("Preparing")

    def update(what: str, done: int, total: int) -> None:
        if what == RENDERING and done == 0:
            folder = flights_folder()
            print(
                f"The frames of the flight are rendered once, into {folder}; later runs read them there.",
                file=sys.stderr,
            )
            stage(BUILDING)  # which takes longer than many frames
            return
        stage(what, done, total)
        if done == total:
            stage("Preparing")

    return update


@contextmanager
def stages_progress() -> Iterator[Callable[..., None]]:
    """Give a function `(what, done, total, note)` that draws one bar after the other; without numbers it begins one."""
    with ExitStack() as bars:
        current: dict[str, Callable[..., None]] = {}

        def update(what: str, done: int | None = None, total: int = 0, note: str = "") -> None:
            if what not in current:
                bars.close()
                current.clear()
                current[what] = bars.enter_context(progress_bar(what))
            if done is not None:
                current[what](done, total, note)

        yield update
