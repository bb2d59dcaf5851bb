"""The page: a single HTML file that loads nothing, made of a template, styles, scripts, and the runs as JSON."""

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
from sunset.files.inputs import check_regular
from sunset.processes.workers import Progress
from sunset.recording import IMAGES_FILE, RunRecord, StoredImage, StoredRun, read_images, read_messages
from sunset.recording.reader import check_extensions
from sunset.viewing.collecting import View, is_shown, run_view
from sunset.viewing.pictures import PicturesView, Placed, Source, make_pictures
from sunset.viewing.words import compared
from sunset_ros.texts import shorten

_BYTES: Final = 5_000_000  # the limit for a page of a run of `_BYTES_S`
_BYTES_S: Final = 20.0
_OTHERS: Final = 280_000  # the share of everything but pictures
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
_MARK: Final = '<meta name="generator" content="sunset view">'  # marks a page, which may be overwritten
_HEAD: Final = 1000  # the bytes of a page in which the mark stands
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
"""The fields that two runs side by side share, and their names in messages."""


class Viewed(NamedTuple):
    """A run that is shown, with a function that returns its images in order of time, or a note why it has none."""

    run: StoredRun
    images: Callable[[], Iterable[StoredImage]] | None
    note: str = ""

    @classmethod
    def of(cls, run: StoredRun, folder: Path, note: str = "") -> "Viewed":
        """Return a run with the images in a folder, or with a note if there are none."""
        has_images = (folder / IMAGES_FILE).is_file()
        return cls(run, partial(read_images, folder)) if has_images else cls(run, None, note)


def check_comparable(first: RunRecord, second: RunRecord) -> None:
    """Check that two runs can be shown side by side.

    Raises:
        RecordError: they differ in more than the managing system and the model.
    """
    for field, name in _SHARED.items():
        values = getattr(first, field), getattr(second, field)
        if values[0] != values[1]:
            shown, other = (shorten(str(value), 60) for value in values)
            raise RecordError(
                f"Two runs are shown side by side if their {name} is the same, got {shown} and {other}: show each on a "
                "page of its own."
            )


def check_page_file(file: Path) -> None:
    """Check that a page can be written to a file, before the page is made.

    Raises:
        OutputError: it is a folder, or a file that is not a page.
    """
    if file.is_dir():
        raise OutputError(f"The page cannot be written to {file}, which is a folder: name a file in it.")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        if not os.access(file.parent, os.W_OK):
            raise OutputError(f"The page {file} cannot be written: no permission; name another file.")
        if file.exists():
            check_regular(file)
            with file.open("rb") as opened:
                is_page = _MARK.encode() in opened.read(_HEAD)
            if not is_page:
                raise OutputError(
                    f"The file {file} exists, and is not a page of 'sunset view': name another one with --out, in "
                    "Python with out."
                )
    except OSError as error:
        raise OutputError(
            f"The page {file} cannot be written: {error.strerror}; name another file."
        ) from error


def page_text(viewed: Sequence[Viewed], *, progress: Progress | None = None) -> str:
    """Return the page of a run, or of two comparable runs side by side, as HTML.

    Args:
        viewed: the runs; the managed system of this process has their extensions.
        progress: called with (frames done, frames in all) while pictures are made.

    Raises:
        RecordError: a record is damaged, or was made with another extension.
    """
    shown = [view.run for view in viewed]
    for run in shown:
        check_extensions(run.record, run.folder)
    pictures, placed = _pictures(viewed, progress)
    runs = [
        run_view(view.run, read_messages(view.run.folder), places, view.note)
        for view, places in zip(viewed, placed, strict=True)
    ]
    title = shown[0].record.scenario
    page = {
        "title": title,
        "comparison": compared(*shown) if len(shown) > 1 else [],
        "opening": _opening(runs),
        "version": __version__,
        "runs": runs,
        "classes": [
            {"name": name, "colour": f"#{red:02x}{green:02x}{blue:02x}"}
            for name, (red, green, blue) in zip(CLASSES, COLOURS, strict=True)
        ],
        "pictures": pictures,
    }
    return _filled(title, page)


def _pictures(viewed: Sequence[Viewed], progress: Progress | None) -> tuple[PicturesView, list[list[Placed]]]:
    sources, share = [], 0.0
    for view in viewed:
        if view.images is not None:
            run = view.run.record
            frames = round(((run.warm_up_s or 0.0) + run.duration_s) / run.period_s)
            sources.append(Source(view.images, max(frames, 1), is_shown))
            share += max(run.duration_s / _BYTES_S, 1)
    if not sources:
        return _NO_PICTURES, [[] for _ in viewed]
    in_base64 = (_BYTES - _OTHERS) * share
    pictures, of_sources = make_pictures(sources, int(in_base64 * 3 / 4), progress)
    placed = iter(of_sources)
    return pictures, [next(placed) if view.images is not None else [] for view in viewed]


def _filled(title: str, page: View) -> str:
    """Return the template with the page's content, of which only JSON comes from runs."""
    style = "\n".join(_asset(name) for name in _STYLES)
    script = "\n".join(['"use strict";', *(_asset(name) for name in _SCRIPTS)])
    # a text of a run must not end the element around it
    data = msgspec.json.encode(page).decode().replace("<", "\\u003c")
    parts = {
        "@mark@": _MARK,
        "@title@": escape(f"{title} · SUNSET"),
        "@style-hash@": _checksum(style),
        "@script-hash@": _checksum(script),
        "@style@": style,
        "@script@": script,
        "@data@": data,
    }
    # all at once, so that marks in the content are left alone
    return re.sub("|".join(parts), lambda mark: parts[mark[0]], _asset("page.html"))


def _asset(name: str) -> str:
    return files("sunset.viewing").joinpath(name).read_text(encoding="utf-8")


def _checksum(text: str) -> str:
    """Return the checksum of a style or script for the page's policy."""
    return b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _opening(runs: Sequence[View]) -> float:
    """Return a second before the first fault; 0 without faults."""
    onsets = [since for run in runs for fault in run["faults"] for since, _ in fault["spans"]]
    first: float = min(run["start"] for run in runs)
    return max(min(onsets) - 1.0, first) if onsets else 0.0
