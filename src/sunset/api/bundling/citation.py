"""The citation of a bundle: its authors, SUNSET, and the paper."""

import re
from collections.abc import Sequence
from datetime import date
from functools import reduce
from typing import Final

import yaml

from sunset import __version__
from sunset.errors import InvalidInputError
from sunset_ros.texts import shown

SOFTWARE: Final = "SUNSET: a ROS 2 exemplar for self-adaptation"
_DEVELOPERS: Final = "The SUNSET developers"
_PAPER: Final = "SUNSET - A Sensor-fUsioN based semantic SegmEnTation exemplar for ROS-based self-adaptation"
_VENUE: Final = "RoSE'26: International Workshop on Robotics Software Engineering"
_PAPER_AUTHORS: Final[tuple[dict[str, str], ...]] = (
    {
        "family-names": "Wiedholz",
        "given-names": "Andreas",
        "orcid": "https://orcid.org/0000-0003-0118-8765",
    },
    {"family-names": "Paintner", "given-names": "Rafael"},
    {"family-names": "Hoffmann", "given-names": "Alwin"},
    {"family-names": "Hernandez", "given-names": "Carlos"},
    {"family-names": "Huber", "given-names": "Tobias"},
)

_AUTHOR: Final = re.compile(
    r"(?P<name>.*?)([ ,;(]*(https://orcid\.org/)?(?P<orcid>(\d{4}-){3}\d{3}[\dX])\)?)?"
)
_LICENCE: Final = r"[A-Za-z0-9][A-Za-z0-9.+-]*|https?://\S+"


def citation_text(title: str, authors: Sequence[str], licence: str, day: str) -> str:
    """Return the citation of a bundle in the Citation File Format, version 1.2.0.

    Args:
        title: of the bundle.
        authors: as in `parse_author`; anonymous if empty.
        licence: its name in SPDX or its address; may be empty.
        day: the day of publication, such as 2026-03-14.

    Raises:
        InvalidInputError: an argument is not usable.
    """
    if not isinstance(title, str) or not title.isprintable():
        raise InvalidInputError(f"The title must be one line of printable characters, got {shown(title)}.")
    if not isinstance(authors, list | tuple):
        raise InvalidInputError(f"The authors must be a list of names, got {shown(authors)}.")
    if not isinstance(licence, str) or (licence and not re.fullmatch(_LICENCE, licence)):
        raise InvalidInputError(
            f"The licence must be a name of SPDX's, such as CC-BY-4.0, or an address, got {shown(licence)}."
        )
    content = {
        "cff-version": "1.2.0",
        "message": "If you use these results, please cite them, SUNSET, and its paper.",
        "type": "dataset",
        "title": title,
        "authors": [parse_author(author) for author in authors] or [{"name": "anonymous"}],
        "date-released": _day(day).isoformat(),
        **({"license-url" if "://" in licence else "license": licence} if licence else {}),
        "references": references(),
    }
    return str(yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=100))


def references() -> list[dict[str, object]]:
    """Return the references of every bundle, SUNSET and the paper, in the Citation File Format."""
    software = {"type": "software", "title": SOFTWARE, "version": __version__, "license": "MIT"}
    paper = {"type": "conference-paper", "title": _PAPER, "year": 2026, "conference": {"name": _VENUE}}
    return [
        software | {"authors": [{"name": _DEVELOPERS}]},
        paper | {"authors": list(map(dict, _PAPER_AUTHORS))},
    ]


def parse_author(text: str) -> dict[str, str]:
    """Return the author that a text names, in the Citation File Format: a name, and an optional ORCID after it.

    Raises:
        InvalidInputError: the name is missing, or the ORCID's check digit is wrong.

    >>> parse_author("Ada Lovelace 0000-0002-1825-0097")
    {'name': 'Ada Lovelace', 'orcid': 'https://orcid.org/0000-0002-1825-0097'}
    """
    match = _AUTHOR.fullmatch(text.strip()) if isinstance(text, str) else None
    if not match or not match["name"] or not match["name"].isprintable():
        raise InvalidInputError(
            f"An author must be a name, with an ORCID behind it if there is one, got {shown(text)}."
        )
    name, orcid = match["name"], match["orcid"]
    if orcid is None:
        return {"name": name}
    *digits, last = list(orcid.replace("-", ""))
    total = reduce(lambda total, digit: (total + int(digit)) * 2, digits, 0)
    if last != "0123456789X"[(12 - total % 11) % 11]:  # ISO 7064, MOD 11-2
        raise InvalidInputError(
            f"The ORCID {orcid} of {name} is mistyped: its last digit does not fit the others."
        )
    return {"name": name, "orcid": f"https://orcid.org/{orcid}"}


def _day(text: str) -> date:
    try:
        return date.fromisoformat(text)
    except (TypeError, ValueError) as error:
        raise InvalidInputError(
            f"The date must be a day, written as 2026-03-14, got {shown(text)}."
        ) from error
