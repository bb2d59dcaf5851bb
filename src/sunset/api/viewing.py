"""Runs that can be looked at: in a page that replays them, in a notebook, and in a folder to publish."""

import os
import sys
import tempfile
import webbrowser
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, fields, replace
from functools import partial
from html import escape
from pathlib import Path
from typing import Final, Self
from urllib.parse import quote

from sunset.api.arguments import Extensions, as_path, extended, optional_path
from sunset.errors import InvalidInputError, SunsetError
from sunset.files.outputs import draft_of_folder, write_text
from sunset.processes.workers import Progress, Stages
from sunset.recording import IMAGES_FILE, StoredRun, read_stored_run
from sunset.viewing import Viewed, check_comparable, check_page_file, is_shown, page_text
from sunset_ros.rmw.backends import SIMULATED

_PAGE: Final = "run.html"
"""The page of a run, in a folder of its own, whose place is that of the record below the folder of stored runs."""
_NO_IMAGES: Final = (
    "The record has no images, so that there are no pictures; 'sunset view' of the record shows them, and runs that "
    "are made with --images have them."
)
_PLAYED: Final = (
    "The pictures were made by playing the recorded commands back without the managing system, and {} of them differ "
    "from the run's: run it again with --images."
)
_LIVE: Final = "It was run live, and its images were not kept, so that there are no pictures."


@dataclass(frozen=True, repr=False)
class Run(StoredRun):
    """A stored run that can be looked at.

    Attributes:
        extensions: the extensions that the managed system had, as they were passed.
        files: where its record is not kept, the record's files except images.
    """

    extensions: Extensions = field(default=(), kw_only=True)
    files: Mapping[str, bytes] = field(default_factory=dict, kw_only=True)

    @classmethod
    def of(cls, run: StoredRun, *, extensions: Extensions = (), is_kept: bool = True) -> Self:
        """Return a stored run as a run that can be looked at."""
        files = [] if is_kept else [path for path in run.folder.iterdir() if path.name != IMAGES_FILE]
        return cls(
            **{each.name: getattr(run, each.name) for each in fields(StoredRun) if each.init},
            extensions=extensions,
            files={path.name: path.read_bytes() for path in files},
        )

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

    @contextmanager
    def at_hand(self) -> Iterator[StoredRun]:
        """Give the run with a record in its folder, for as long as it is needed."""
        if not self.files:
            yield self
            return
        with tempfile.TemporaryDirectory(prefix="sunset-") as temporary:
            for name, content in self.files.items():
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

    If the record of a simulated run lacks images, its commands are played back to make them. The managing system is
    not run.

    Args:
        run: a run of `run` or `load`, or its folder.
        other: a run of another managing system on the same scenario, seed and flight.
        out: the page's file; named after the runs' folders, in the current folder, if it is None.
        show: whether it is opened in a browser, if there is a screen.
        model: the model, if it is not installed under the record's name.
        bag: the runs' flight, if it is not the default flight.
        progress: called with (stage, steps done, all steps).
        extensions: extensions that the runs were made with; a `Run` knows its own.

    Raises:
        SunsetError: a run is missing or failed, both cannot be compared, or the page cannot be written.
    """
    runs = [run] if other is None else [run, other]
    known = (each.extensions for each in runs if isinstance(each, Run) and each.extensions)
    drawing = None if progress is None else partial(progress, "Making pictures")
    with extended(extensions or next(known, ())), ExitStack() as stack:
        opened = [_opened(each) for each in runs]
        names = dict.fromkeys(each.folder.resolve().name for each in opened)
        file = optional_path(out, "page's file") or Path("-".join(names) + ".html")
        check_page_file(file)
        if len(opened) > 1:
            if opened[0].record == opened[1].record:
                raise InvalidInputError("A run beside itself shows nothing: name another one, or one only.")
            check_comparable(opened[0].record, opened[1].record)
        stored = [stack.enter_context(each.at_hand()) for each in opened]
        sources = None if model is None else str(model), optional_path(bag, "bag")
        viewed = stack.enter_context(_with_images(stored, *sources, progress))
        write_text(file, page_text(viewed, progress=drawing), "page")
    if show and can_show_pages():
        webbrowser.open(file.resolve().as_uri())
    return file


def _opened(run: StoredRun | str | Path) -> Run:
    if isinstance(run, Run):
        return run
    return Run.of(run if isinstance(run, StoredRun) else read_stored_run(as_path(run, "folder of a run")))


def can_show_pages() -> bool:
    """Return whether pages can be opened: there is a screen, or the environment names a browser."""
    return sys.platform == "darwin" or any(map(os.environ.get, ("BROWSER", "DISPLAY", "WAYLAND_DISPLAY")))


@contextmanager
def _with_images(
    runs: Sequence[StoredRun], model: str | None, bag: Path | None, progress: Stages | None
) -> Iterator[list[Viewed]]:
    """Give the runs with their images, which are made for simulated runs whose records have none."""
    from sunset.experiments import play_back  # noqa: PLC0415  slow, and only needed here

    viewed = [Viewed.of(run, run.folder, _LIVE) for run in runs]
    without = [
        number
        for number, each in enumerate(viewed)
        if each.images is None and each.run.record.middleware == SIMULATED
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


def write_site(
    path: str | Path, out: str | Path, *, progress: Progress | None = None, extensions: Extensions = ()
) -> Path:
    """Write a folder with the report of stored runs and a page for each run, as `sunset report --site` does.

    The folder is self-contained and needs no network, so that it can be published as it is. Pages of runs whose records
    have images contain pictures.

    Args:
        path: the folder that `run` or `bench`, or the command line, has written.
        out: the folder, which must not exist, or be empty.
        progress: called with (written pages, all pages).
        extensions: extensions that the runs were made with.

    Returns:
        The first page, `index.html` in the folder.

    Raises:
        RecordError: the folder or its runs are missing, damaged or of another version.
        OutputError: the folder cannot be written, or is not empty.
    """
    from sunset.evaluation.report import index_page  # noqa: PLC0415  slow, and not needed for a page
    from sunset.evaluation.results import load_results  # noqa: PLC0415  slow, and not needed for a page

    folder, site = as_path(path, "folder of stored runs"), as_path(out, "folder of the site")
    with extended(extensions):
        runs = load_results(folder)
        pages = {run.folder: run.folder.relative_to(folder) / _PAGE for run in runs if not run.is_empty}
        with draft_of_folder(site, "site") as draft:
            for done, (place, page) in enumerate(pages.items()):
                if progress is not None:
                    progress(done, len(pages))
                (draft / page).parent.mkdir(parents=True, exist_ok=True)
                text = page_text([Viewed.of(read_stored_run(place), place, _NO_IMAGES)])
                (draft / page).write_text(text, encoding="utf-8")
            links = {place: quote(os.fsencode(page)) for place, page in pages.items()}
            (draft / "index.html").write_text(index_page(runs, links), encoding="utf-8")
    if progress is not None:
        progress(len(pages), len(pages))
    return Path(out) / "index.html"
