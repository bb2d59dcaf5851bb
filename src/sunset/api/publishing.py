"""Bundles: campaigns packed into a file, and checked."""

import secrets
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from sunset.api import bundling
from sunset.api.arguments import (
    Extensions,
    as_path,
    check_flags,
    check_progress,
    extended,
    optional_path,
    whole_of,
)
from sunset.api.bundling import Bundle, Rerun, Verification
from sunset.errors import InvalidInputError
from sunset.processes.workers import Progress
from sunset_ros.seeding import check_seed
from sunset_ros.texts import shown

_SEEDS: Final = 2**32


def bundle(
    folder: str | Path,
    out: str | Path,
    *,
    title: str = "",
    authors: Sequence[str] = (),
    licence: str = "",
    date: str | None = None,
    extensions: Extensions = (),
    progress: Progress | None = None,
) -> Bundle:
    """Pack a finished campaign into a zip file that others can check, as `sunset bundle` does.

    The same campaign, arguments and date give the same bytes.

    Args:
        folder: the campaign.
        out: the file, which must not exist.
        title: of the bundle; derived from the campaign's plan if empty.
        authors: a name each, followed by an ORCID if known; anonymous if empty.
        licence: under which others may use it, as SPDX calls it, such as `CC-BY-4.0`, or its address; none if empty.
        date: the day of publication, as `2026-03-14`; today if None.
        extensions: extensions that the campaign was run with.
        progress: called with (checked runs, all runs).

    Raises:
        SunsetError: the folder holds no campaign, or it is not finished or was changed, a managing system cannot be
            loaded, another argument is not usable, or the file exists or cannot be written.
    """
    check_progress(progress)
    _check_texts(title, licence, authors)
    source, file = as_path(folder, "folder of the campaign"), as_path(out, "bundle")
    metadata: dict[str, Any] = {"title": title, "authors": authors, "licence": licence}
    with extended(extensions):
        published = _today() if date is None else date
        return bundling.bundle(source, file, published=published, progress=progress, **metadata)


def _check_texts(title: object, licence: object, authors: object) -> None:
    for name, text in (("title", title), ("licence", licence)):
        if not isinstance(text, str):
            raise InvalidInputError(f"The {name} must be a text, got {shown(text)}.")
    if not isinstance(authors, list | tuple):
        raise InvalidInputError(f"The authors must be a list of names, got {shown(authors)}.")


def _today() -> str:
    return datetime.now(tz=UTC).date().isoformat()  # noqa: TID251  the day of publication is not a result


def verify(
    path: str | Path,
    *,
    run_again: int = 3,
    seed: int | None = None,
    trust: bool = False,
    model: str | Path | None = None,
    bag: str | Path | None = None,
    progress: Progress | None = None,
) -> Verification:
    """Check a bundle, as `sunset verify` does: every figure, and some runs by running them again.

    Nothing in the bundle is executed, unless it is trusted.

    Args:
        path: of the file.
        run_again: how many runs are run again, chosen at random among those that can be.
        seed: of the choice; drawn at random if None, so that the choice is not known beforehand.
        trust: whether the bundle's own managing systems and extensions, which are programs, may run.
        model: the folder of the campaign's model, if it is not installed.
        bag: the campaign's bag, if it is not the default flight.
        progress: called with (runs that are computed or run again, all such runs).

    Raises:
        RecordError: it is not a bundle, is of another version, or is not fit to be opened.
        InvalidInputError: another argument is not usable.
    """
    check_progress(progress)
    check_flags(trust=trust)
    number = whole_of(run_again)
    if isinstance(number, bool) or not isinstance(number, int) or number < 0:
        raise InvalidInputError(
            f"The number of runs to run again must be at least 0, got {shown(run_again)}."
        )
    chosen_seed = secrets.randbelow(_SEEDS) if seed is None else check_seed(whole_of(seed))
    folder = None if model is None else str(as_path(model, "model"))
    rerun = Rerun(number=number, seed=chosen_seed, trust=trust, model=folder, bag=optional_path(bag, "bag"))
    return bundling.verify(as_path(path, "bundle"), rerun, progress=progress)
