"""Progress on stderr."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

__all__ = ["progress_bar", "rendering_progress", "stages_progress"]


@contextmanager
def progress_bar(text: str) -> Iterator[Callable[[int, int], None]]:
    """Give a function `(done, total)` that draws a bar; nothing is drawn before its first call.

    Where stderr is no terminal, lines at every tenth stand in for the bar.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        yield _lines(console, text)
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    bar = Progress(*columns, console=console)
    task = bar.add_task(text, total=None)

    def update(done: int, total: int) -> None:
        bar.start()
        bar.update(task, completed=done, total=total)

    try:
        yield update
    finally:
        bar.stop()


def _lines(console: Console, text: str) -> Callable[[int, int], None]:
    tenths = -1

    def update(done: int, total: int) -> None:
        nonlocal tenths
        if done * 10 // max(total, 1) > tenths:
            tenths = done * 10 // max(total, 1)
            console.print(f"{text}: {done} of {total}", highlight=False)

    return update


@contextmanager
def rendering_progress() -> Iterator[Callable[[int, int], None]]:
    """Give the progress of rendering the default flight, which happens once."""
    with progress_bar("Rendering the flight (once)") as update:
        yield update


@contextmanager
def stages_progress() -> Iterator[Callable[[str, int, int], None]]:
    """Give a function `(what, done, total)` that draws one bar after the other."""
    with ExitStack() as bars:
        current: dict[str, Callable[[int, int], None]] = {}

        def update(what: str, done: int, total: int) -> None:
            if what not in current:
                bars.close()
                current.clear()
                current[what] = bars.enter_context(progress_bar(what))
            current[what](done, total)

        yield update
