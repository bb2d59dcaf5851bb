"""How managing systems are told apart in figures: the same one looks the same in all of them, in grey too."""

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import Final

from sunset.figures import BLUE, ORANGE

INK: Final = "#1b1b1b"
"""The colour of text; a page puts its own in its place."""


@dataclass(frozen=True, slots=True)
class Style:
    """How a managing system is drawn.

    Attributes:
        colour: of its line and marker.
        marker: as matplotlib names it.
        dashes: lengths of dashes and gaps by turns, in widths of the line; empty for a line without gaps.
    """

    colour: str
    marker: str
    dashes: tuple[float, ...]


SHIPPED: Final[Mapping[str, Style]] = MappingProxyType(
    {
        "none": Style("#777777", "x", (1, 1.2)),
        "random": Style("#CC79A7", "v", (2.5, 1.2)),
        "baseline": Style(BLUE, "o", ()),
        "reactive": Style(ORANGE, "s", (5, 1.5)),
        "diagnosing": Style("#009E73", "^", (6, 1.2, 1, 1.2)),
        "oracle": Style(INK, "*", (9, 1.5, 1, 1.2, 1, 1.2)),
    }
)
"""Those that come with SUNSET, from the one that knows least to the one that knows most."""

_COLOURS: Final = ("#56B4E9", "#E69F00", "#8C6BB1", "#A6761D")
_MARKERS: Final = (("D", (3, 1)), ("P", (4, 1, 1, 1)), ("X", (2, 1)), ("<", (7, 2)), (">", (5, 1, 2, 1)))
_OTHERS: Final = tuple(
    Style(colour, marker, dashes) for (marker, dashes), colour in product(_MARKERS, _COLOURS)
)


def in_order(names: Iterable[str]) -> list[str]:
    """Return managing systems in the order in which figures name them: those that come with SUNSET, then the others.

    >>> in_order(["mine", "oracle", "baseline"])
    ['baseline', 'oracle', 'mine']
    """
    places = {name: place for place, name in enumerate(SHIPPED)}
    return sorted(set(names), key=lambda name: (places.get(name, len(places)), name))


def styles(names: Iterable[str]) -> Mapping[str, Style]:
    """Return how each managing system is drawn.

    It depends on its name, so that it looks the same in every report, unless another one of them has its marker. More
    than five of one's own share markers, and more than twenty look alike in part.
    """
    found: dict[str, Style] = {}
    for name in in_order(names):
        style = SHIPPED.get(name)
        if style is None:
            first = int.from_bytes(hashlib.sha256(name.encode()).digest()[:4])
            choices = [_OTHERS[(first + step) % len(_OTHERS)] for step in range(len(_OTHERS))]
            used = set(found.values())
            markers = {one.marker for one in used}
            style = min(choices, key=lambda choice: (choice.marker in markers, choice in used))
        found[name] = style
    return MappingProxyType(found)
