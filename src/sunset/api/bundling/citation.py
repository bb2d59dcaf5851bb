"""The citation of a bundle: its authors, SUNSET, and the paper."""

import re
from dataclasses import dataclass
from datetime import date
from typing import Final

import yaml

from sunset import __version__
from sunset.errors import InvalidInputError
from sunset_ros.texts import shown

SOFTWARE: Final = "SUNSET: a ROS 2 exemplar for self-adaptation"
ANONYMOUS: Final = "anonymous"

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

_ORCID: Final = re.compile(r"^(?P<name>.*?)[ ,;(]*(https://orcid\.org/)?(?P<id>(\d{4}-){3}\d{3}[\dX])\)?$")
_LICENCE_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9.+-]*")
_LICENCE_ADDRESS: Final = re.compile(r"https?://\S+")


@dataclass(frozen=True)
class Author:
    """An author of a campaign, with the address of the ORCID, which may be empty."""

    name: str
    orcid: str = ""


@dataclass(frozen=True)
class Citation:
    """The citation of a bundle, with the licence's name in SPDX or its address; authors and licence may be empty."""

    title: str
    authors: tuple[Author, ...]
    licence: str
    published: date

    def __post_init__(self) -> None:
        """Check the title and the licence."""
        if not self.title.isprintable():
            raise InvalidInputError(
                f"The title must be one line of printable characters, got {self.title!r}."
            )
        known = _LICENCE_NAME.fullmatch(self.licence) or _LICENCE_ADDRESS.fullmatch(self.licence)
        if self.licence and not known:
            raise InvalidInputError(
                f"The licence must be a name of SPDX's, such as CC-BY-4.0, or an address, got {shown(self.licence)}."
            )

    @property
    def licence_address(self) -> str:
        """The address of the licence; may be empty."""
        is_name = self.licence and not _LICENCE_ADDRESS.fullmatch(self.licence)
        return f"https://spdx.org/licenses/{self.licence}" if is_name else self.licence

    def to_cff(self) -> str:
        """Return the content of a file in the Citation File Format, version 1.2.0."""
        key = "license-url" if self.licence_address == self.licence else "license"
        content = {
            "cff-version": "1.2.0",
            "message": "If you use these results, please cite them, SUNSET, and its paper.",
            "type": "dataset",
            "title": self.title,
            "authors": [
                {"name": author.name} | ({"orcid": author.orcid} if author.orcid else {})
                for author in self.authors or (Author(ANONYMOUS),)
            ],
            "date-released": self.published.isoformat(),
            **({key: self.licence} if self.licence else {}),
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


def parse_author(text: str) -> Author:
    """Return the author that a text names: a name, and an optional ORCID after it.

    Raises:
        InvalidInputError: the name is missing, or the ORCID's check digit is wrong.

    >>> parse_author("Ada Lovelace 0000-0002-1825-0097")
    Author(name='Ada Lovelace', orcid='https://orcid.org/0000-0002-1825-0097')
    """
    match = _ORCID.match(text.strip()) if isinstance(text, str) else None
    name = match["name"] if match else text
    if not isinstance(name, str) or not name.strip() or not name.isprintable():
        raise InvalidInputError(
            f"An author must be a name, with an ORCID behind it if there is one, got {shown(text)}."
        )
    if match and not _is_orcid(match["id"]):
        raise InvalidInputError(
            f"The ORCID {match['id']} of {name} is mistyped: its last digit does not fit the others."
        )
    return Author(name.strip(), f"https://orcid.org/{match['id']}" if match else "")


def _is_orcid(text: str) -> bool:
    """Return whether the last digit is the check digit of the others (ISO 7064, MOD 11-2)."""
    digits = text.replace("-", "")
    total = 0
    for digit in digits[:-1]:
        total = (total + int(digit)) * 2
    return digits[-1] == "0123456789X"[(12 - total % 11) % 11]


def parse_date(text: str) -> date:
    """Return a day that was given as text, such as 2026-03-14.

    Raises:
        InvalidInputError: the text is not a day.
    """
    try:
        return date.fromisoformat(text)
    except (TypeError, ValueError) as error:
        raise InvalidInputError(
            f"The date must be a day, written as 2026-03-14, got {shown(text)}."
        ) from error
