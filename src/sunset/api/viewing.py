"""Runs that can be looked at: as one page that replays them, and in a notebook."""

import os
import sys
import tempfile
import webbrowser
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import fields, replace
from functools import partial
from html import escape
from pathlib import Path
from typing import Any, Final, Self

from sunset.api.options import (
    Extensions,
    as_path,
    check_flags,
    check_progress,
    extended,
)
from sunset.errors import InvalidInputError, RecordError, SunsetError
from sunset.experiments import play_back
from sunset.output_files import write_text
from sunset.processes.workers import Stages
from sunset.recording import IMAGES_FILE, StoredRun, read_stored_run
from sunset.rmw.backends import SIMULATED
from sunset.texts import shown
from sunset.viewing import Viewed, check_comparable, check_page_file, is_shown, page_text

_PLAYED: Final = (
    "The pictures were made by playing the recorded commands back without the managing system, and {} of them differ "
    "from the run's: run it again with --images."
)
_LIVE: Final = "It was run live, and its images were not kept, so that there are no pictures."


class Run(StoredRun):
    """A run, as its record tells it, that can be looked at.

    It knows the extensions of the managed system that it was made with. Where its record is not kept, it carries the
    record's files except images.
    """

    __slots__ = ("_extensions", "_files")
    _extensions: Extensions
    _files: Mapping[str, bytes]

    @classmethod
    def of(cls, run: StoredRun, *, extensions: Extensions = (), is_kept: bool = True) -> Self:
        """Return a stored run as one that can be looked at."""
        made = cls(**{field.name: getattr(run, field.name) for field in fields(run) if field.init})
        object.__setattr__(made, "_extensions", extensions)
        files = [] if is_kept else [path for path in run.folder.iterdir() if path.name != IMAGES_FILE]
        object.__setattr__(made, "_files", {path.name: path.read_bytes() for path in files})
        return made

    def view(
        self, other: StoredRun | str | Path | None = None, *, out: str | Path | None = None, show: bool = True
    ) -> Path:
        """Write a page that replays the run, alone or beside another, and return its file; as `sunset.view`."""
        return view(self, other, out=out, show=show)

    def _repr_html_(self) -> str | None:
        """Return the run for a notebook: its time lines, and pictures if its record has them.

        It is None, so that its text is shown, where the record or an extension is gone.
        """
        try:
            with extended(self.extensions), self.at_hand() as run:
                viewed = Viewed.of(run, run.folder)
                text = page_text([viewed])
        except SunsetError:
            return None
        return (
            f'<iframe srcdoc="{escape(text)}" sandbox="allow-scripts" title="{escape(repr(self))}" '
            f'style="width: 100%; height: {940 if viewed.images else 720}px; border: 0"></iframe>'
        )

    def __getstate__(self) -> object:
        """Return what is pickled, the extensions and files included."""
        return super().__getstate__(), self.extensions, getattr(self, "_files", {})

    def __setstate__(self, state: Any) -> None:
        """Restore what was pickled."""
        stored, extensions, files = state
        super().__setstate__(stored)  # type: ignore[misc]  # a data class has it
        object.__setattr__(self, "_extensions", extensions)
        object.__setattr__(self, "_files", files)

    @property
    def extensions(self) -> Extensions:
        """The extensions that the managed system had, as they were passed."""
        return getattr(self, "_extensions", ())

    @contextmanager
    def at_hand(self) -> Iterator[StoredRun]:
        """Give the run with a record in its folder, for as long as it is needed."""
        files = getattr(self, "_files", None)
        if not files:
            yield self
            return
        with tempfile.TemporaryDirectory(prefix="sunset-") as temporary:
            for name, content in files.items():
                (Path(temporary) / name).write_bytes(content)
            yield replace(self, folder=Path(temporary))


def view(
    run: StoredRun | str | Path,
    other: StoredRun | str | Path | None = None,
    *,
    out: str | Path | None = None,
    show: bool = True,
    model: str | Path | None = None,
    bag: str | Path | None = None,
    progress: Stages | None = None,
    extensions: Extensions = (),
) -> Path:
    """Write a page that replays a run, or two side by side, as `sunset view` does, and return its file.

    Where the record of a simulated run has no images, they are made by playing its commands back. The managing system
    is not run: it may be a stranger's program.

    Args:
        run: what `run` or `load` returned, or its folder.
        other: one of another managing system on the same scenario, seed and flight.
        out: the page's file; in the current folder, named after the runs' folders, if it is None.
        show: whether it is opened in a browser, where there is a screen.
        model: the model, if it is not one of the record's name.
        bag: the runs' flight, if that is not the default one.
        progress: called with (what is done, how much of it, how much in all).
        extensions: those of the managed system that the runs were made with; a `Run` knows its own.

    Raises:
        InvalidInputError: both are the same run.
        RecordError: there is no such run, it failed, its images cannot be made, or the two cannot be compared.
        OutputError: the page cannot be written.
    """
    check_progress(progress)
    check_flags(show=show)
    listed = [run] if other is None else [run, other]
    known = (one.extensions for one in listed if isinstance(one, Run) and one.extensions)
    with extended(extensions or next(known, ())), ExitStack() as stack:
        given = [one if isinstance(one, Run) else Run.of(_stored(one)) for one in listed]
        file = _default_page(given) if out is None else as_path(out, "page's file")
        check_page_file(file)
        if other is not None:
            if given[0].record == given[1].record:
                raise InvalidInputError("A run beside itself shows nothing: name another one, or one only.")
            check_comparable(given[0].record, given[1].record)
        place = None if bag is None else as_path(bag, "bag")
        runs = [stack.enter_context(one.at_hand()) for one in given]
        with _with_images(runs, None if model is None else str(model), place, progress) as viewed:
            making = None if progress is None else partial(progress, "Making pictures")
            write_text(file, page_text(viewed, progress=making), "page")
    if show and can_show_pages():
        webbrowser.open(file.resolve().as_uri())
    return file


def _stored(run: StoredRun | str | Path) -> StoredRun:
    """Return a run that was given as itself or by its folder."""
    if isinstance(run, StoredRun):
        return run
    if not isinstance(run, str | Path):
        raise InvalidInputError(f"A run is shown by itself or by its folder, got {shown(run)}.")
    folder = as_path(run, "folder of a run")
    if folder.is_file():
        raise RecordError(f"A record is a folder, got the file {folder}: name the folder that it is in.")
    return read_stored_run(folder)


def _default_page(runs: Sequence[StoredRun]) -> Path:
    """Return the page's file where none is named: in the current folder, with the names of the runs' folders."""
    return Path("-".join(dict.fromkeys(run.folder.resolve().name for run in runs)) + ".html")


def can_show_pages() -> bool:
    """Return whether pages can be opened: there is a screen, or the environment names a browser."""
    return sys.platform == "darwin" or any(map(os.environ.get, ("BROWSER", "DISPLAY", "WAYLAND_DISPLAY")))


@contextmanager
def _with_images(
    runs: Sequence[StoredRun], model: str | None, bag: Path | None, progress: Stages | None
) -> Iterator[list[Viewed]]:
    """Give the runs with their images, which are made for simulated runs whose records have none."""
    viewed = [Viewed.of(run, run.folder, _LIVE) for run in runs]
    without = [
        number
        for number, one in enumerate(viewed)
        if one.images is None and one.run.record.middleware == SIMULATED
    ]
    with tempfile.TemporaryDirectory(prefix="sunset-") as temporary:
        for done, number in enumerate(without):
            if progress is not None:
                progress("Playing back", done, len(without))
            run, folder = runs[number], Path(temporary) / str(number)
            differing = play_back(run.folder, folder, model=model, bag=bag, wanted=is_shown)
            note = _PLAYED.format(differing) if differing else ""
            viewed[number] = Viewed.of(run, folder)._replace(note=note)
        if progress is not None and without:
            progress("Playing back", len(without), len(without))
        yield viewed
