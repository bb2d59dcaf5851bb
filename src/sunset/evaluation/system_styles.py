"""The colours and markers of managing systems, the same in all figures."""

import hashlib
from collections.abc import Iterable, Mapping
from itertools import product
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from sunset.files.plots import BLUE, ORANGE

INK: Final = "#1b1b1b"
PAPER: Final = "#ffffff"
"""The colours of text and background, which a page replaces with its own."""


class Style(NamedTuple):
    """A colour and a marker, as matplotlib names them."""

    colour: str
    marker: str

    @property
    def points(self) -> dict[str, Any]:
        """The arguments with which matplotlib draws points."""
        edge = {"markeredgecolor": PAPER, "markeredgewidth": 0.6}
        size = 9 if self.marker == "*" else 6
        return {"color": self.colour, "marker": self.marker, "markersize": size, "linestyle": "none", **edge}


SHIPPED: Final[Mapping[str, Style]] = MappingProxyType(
    {
        "none": Style("#777777", "X"),
        "random": Style("#CC79A7", "v"),
        "baseline": Style(BLUE, "o"),
        "reactive": Style(ORANGE, "s"),
        "diagnosing": Style("#009E73", "^"),
        "inspecting": Style("#B2182B", "p"),
        "oracle": Style(INK, "*"),
    }
)
"""The styles of SUNSET's own managing systems, from the least informed to the best informed."""

_COLOURS: Final = ("#56B4E9", "#E69F00", "#8C6BB1", "#A6761D")
_OTHERS: Final = tuple(Style(colour, marker) for marker, colour in product("DPh<>", _COLOURS))


def in_order(names: Iterable[str]) -> list[str]:
    """Return managing systems in the order of figures: SUNSET's own, then the others.

    >>> in_order(["mine", "oracle", "baseline"])
    ['baseline', 'oracle', 'mine']
    """
    places = {name: place for place, name in enumerate(SHIPPED)}
    return sorted(set(names), key=lambda name: (places.get(name, len(places)), name))


def styles(names: Iterable[str]) -> Mapping[str, Style]:
    """Return the style of each managing system.

    It depends on the name, so that it is the same in every report, unless another managing system has the same marker.
    More than five of the user's own share markers, and more than twenty share styles.
    """
    chosen: dict[str, Style] = {}
    for name in in_order(names):
        first = int.from_bytes(hashlib.sha256(name.encode()).digest()[:4]) % len(_OTHERS)
        choices = [SHIPPED[name]] if name in SHIPPED else [*_OTHERS[first:], *_OTHERS[:first]]
        markers = {style.marker for style in chosen.values()}
        used = set(chosen.values())
        chosen[name] = min(choices, key=lambda style: (style.marker in markers, style in used))
    return chosen
