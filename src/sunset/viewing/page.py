"""The page: one HTML file that loads nothing, made of a template, its styles and scripts, and what it knows of runs."""

import hashlib
import os
import re
from base64 import b64encode
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import Final, NamedTuple

import msgspec

from sunset import __version__
from sunset.classes import CLASSES, COLOURS
from sunset.errors import OutputError, RecordError
from sunset.input_files import open_regular
from sunset.output_files import write_text
from sunset.processes.workers import Progress
from sunset.recording import IMAGES_FILE, RunRecord, StoredImage, StoredRun, read_images, read_messages
from sunset.recording.reader import check_extensions
from sunset.viewing.collecting import run_view
from sunset.viewing.document import LabelClass, Page, PicturesView, RunView
from sunset.viewing.frames import is_shown
from sunset.viewing.pictures import Placed, Source, make_pictures
from sunset.viewing.words import compared

_BYTES: Final = 5_000_000
"""What a page of one run of `_BYTES_S` may have."""
_BYTES_S: Final = 20.0
_OTHERS: Final = 280_000
"""What of it is for all but pictures."""
_NO_PICTURES: Final = PicturesView(0, 0, "", None, [], [])

_STYLES: Final = ("uplot/uPlot.min.css", "page.css")
_SCRIPTS: Final = (
    "uplot/uPlot.iife.min.js",
    "pictures.js",
    "lanes.js",
    "runs.js",
    "moment.js",
    "words.js",
    "page.js",
)
_MARK: Final = '<meta name="generator" content="sunset view">'
"""By which a page is known that may be written over."""
_HEAD: Final = 1000
"""Bytes in which the mark stands."""


class Viewed(NamedTuple):
    """A run that is shown.

    Attributes:
        run: it, as its record tells it.
        images: returns its images in order of time, whenever it is called; None if there are none.
        note: why there are none; empty if there are.
    """

    run: StoredRun
    images: Callable[[], Iterable[StoredImage]] | None
    note: str = ""

    @classmethod
    def of(cls, run: StoredRun, folder: Path, note: str = "") -> "Viewed":
        """Return a run with the images that a folder has, or with a note if it has none."""
        has_images = (folder / IMAGES_FILE).is_file()
        return cls(run, partial(read_images, folder)) if has_images else cls(run, None, note)


def check_comparable(one: RunRecord, other: RunRecord) -> None:
    """Check that two runs can be shown side by side.

    Raises:
        RecordError: they differ in more than the managing system and the model.
    """
    for name, what in _SHARED.items():
        if getattr(one, name) != getattr(other, name):
            raise RecordError(
                f"Two runs are shown side by side if their {what} is the same, got {_short(getattr(one, name))} and "
                f"{_short(getattr(other, name))}: show each on a page of its own."
            )


_SHARED: Final = {
    "scenario": "scenario",
    "faults": "scenario's faults",
    "seed": "seed",
    "bag_checksum": "flight",
    "bag_looped": "looping of the flight",
    "warm_up_s": "warm-up",
    "duration_s": "duration",
    "middleware": "middleware",
}
"""What is the same of two runs that are shown side by side."""


def _short(value: object) -> str:
    text = str(value)
    return text if len(text) <= 60 else f"{text[:12]}…"  # noqa: PLR2004  checksums are 64 long


def check_page_file(file: Path) -> None:
    """Check that a page can be written to a file, before there is one.

    Raises:
        OutputError: it is a folder, or a file that is not a page of ours.
    """
    if file.is_dir():
        raise OutputError(f"The page cannot be written to {file}, which is a folder: name a file in it.")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        if not os.access(file.parent, os.W_OK):
            raise OutputError(f"The page {file} cannot be written: no permission; name another file.")
        if file.exists() and _MARK.encode() not in _head(file):
            raise OutputError(
                f"The file {file} exists, and is not a page of 'sunset view': name another one with --out, in Python "
                "with out."
            )
    except OSError as error:
        raise OutputError(
            f"The page {file} cannot be written: {error.strerror}; name another file."
        ) from error


def _head(file: Path) -> bytes:
    with open_regular(file) as opened:
        return opened.read(_HEAD)


def write_page(viewed: Sequence[Viewed], file: Path, *, progress: Progress | None = None) -> None:
    """Write the page of one run, or of two side by side.

    Args:
        viewed: the runs; the managed system of this process has their extensions.
        file: is replaced; its folder is made.
        progress: called with (frames done, frames in all) while pictures are made.

    Raises:
        RecordError: a record is damaged, was made with another extension, or the two runs cannot be compared.
        OutputError: the file cannot be written, or is something else than such a page.
    """
    check_page_file(file)
    write_text(file, page_text(viewed, progress=progress), "page")


def page_text(viewed: Sequence[Viewed], *, progress: Progress | None = None) -> str:
    """Return the page of one run, or of two side by side, as HTML; as `write_page`."""
    if len(viewed) > 1:
        check_comparable(viewed[0].run.record, viewed[1].run.record)
    for one in viewed:
        check_extensions(one.run.record, one.run.folder)
    pictures, placed = _pictures(viewed, progress)
    runs = [
        run_view(one.run, read_messages(one.run.folder), places, one.note)
        for one, places in zip(viewed, placed, strict=True)
    ]
    page = Page(
        title=viewed[0].run.record.scenario,
        comparison=compared(*(one.run for one in viewed)) if len(viewed) > 1 else [],
        opening=_opening(runs),
        version=__version__,
        runs=runs,
        classes=_classes(),
        pictures=pictures,
    )
    return _filled(page)


def _classes() -> list[LabelClass]:
    return [
        LabelClass(name, f"#{red:02x}{green:02x}{blue:02x}")
        for name, (red, green, blue) in zip(CLASSES, COLOURS, strict=True)
    ]


def _pictures(viewed: Sequence[Viewed], progress: Progress | None) -> tuple[PicturesView, list[list[Placed]]]:
    """Return the pictures of runs, and for each run where its own are."""
    sources = [
        Source(one.images, _frames(one.run.record), is_shown) for one in viewed if one.images is not None
    ]
    if not sources:
        return _NO_PICTURES, [[] for _ in viewed]
    shares = [max(one.run.record.duration_s / _BYTES_S, 1) for one in viewed if one.images is not None]
    in_base64 = (_BYTES - _OTHERS) * sum(shares)
    pictures, found = make_pictures(sources, int(in_base64 * 3 / 4), progress)
    placed = iter(found)
    return pictures, [next(placed) if one.images is not None else [] for one in viewed]


def _frames(run: RunRecord) -> int:
    warm_up = 0.0 if run.warm_up_s is msgspec.UNSET else run.warm_up_s
    return max(round((warm_up + run.duration_s) / run.period_s), 1)


def _filled(page: Page) -> str:
    """Return the page as HTML. Nothing in it is of the template's kind: what is said of runs stands as data."""
    style = "\n".join(_asset(name) for name in _STYLES)
    script = "\n".join(['"use strict";', *(_asset(name) for name in _SCRIPTS)])
    # a text of a run must not end the element that it stands in
    data = msgspec.json.encode(page).decode().replace("<", "\\u003c")
    parts = {
        "@mark@": _MARK,
        "@title@": escape(f"{page.title} · SUNSET"),
        "@style-hash@": _checksum(style),
        "@script-hash@": _checksum(script),
        "@style@": style,
        "@script@": script,
        "@data@": data,
    }
    # in one go, so that no part is looked for in another
    return re.sub("|".join(parts), lambda found: parts[found[0]], _asset("page.html"))


def _asset(name: str) -> str:
    return files("sunset.viewing").joinpath(name).read_text(encoding="utf-8")


def _checksum(text: str) -> str:
    """Return the checksum by which the page's policy knows its own style and script."""
    return b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _opening(runs: Sequence[RunView]) -> float:
    """Return a second before the first fault comes, when all is still well; 0 if none comes."""
    came = [since for run in runs for fault in run.faults for since, _ in fault.spans]
    return max(min(came) - 1.0, min(run.start for run in runs)) if came else 0.0
