"""A folder to publish: the table of stored runs, and a page that replays each."""

import os
from pathlib import Path
from typing import Final
from urllib.parse import quote

from sunset.api.arguments import Extensions, as_path, check_progress, extended
from sunset.evaluation import index_page, load_results
from sunset.output_files import draft_of_folder
from sunset.recording import read_stored_run
from sunset.viewing import Viewed, page_text
from sunset.workers import Progress

_PAGE: Final = "run.html"
"""The page of a run, in a folder of its own, whose place is that of the record below the folder of stored runs."""
_NO_IMAGES: Final = (
    "The record has no images, so that there are no pictures; 'sunset view' of the record shows them, and runs that "
    "are made with --images have them."
)


def write_site(
    path: str | Path,
    out: str | Path,
    *,
    progress: Progress | None = None,
    extensions: Extensions = (),
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
    check_progress(progress)
    folder, site = as_path(path, "folder of stored runs"), as_path(out, "folder of the site")
    with extended(extensions):
        runs = load_results(folder)
        pages = {run.folder: run.folder.relative_to(folder) / _PAGE for run in runs if not run.is_empty}
        with draft_of_folder(site, "site") as draft:
            for done, (place, page) in enumerate(pages.items()):
                if progress is not None:
                    progress(done, len(pages))
                _write_run(place, draft / page)
            links = {place: quote(os.fsencode(page)) for place, page in pages.items()}
            (draft / "index.html").write_text(index_page(runs, links), encoding="utf-8")
    if progress is not None:
        progress(len(pages), len(pages))
    return Path(out) / "index.html"


def _write_run(place: Path, page: Path) -> None:
    page.parent.mkdir(parents=True, exist_ok=True)
    page.write_text(page_text([Viewed.of(read_stored_run(place), place, _NO_IMAGES)]), encoding="utf-8")
