"""How figures draw managing systems: each in its own colour and marker, in all of them."""

import hashlib
from collections.abc import Iterable, Mapping
from itertools import product
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from sunset.figures import BLUE, ORANGE

INK: Final = "#1b1b1b"
PAPER: Final = "#ffffff"
"""The colours of text and of what is behind it; a page puts its own in their place."""


class Style(NamedTuple):
    """A colour and a marker, as matplotlib names them."""

    colour: str
    marker: str

    @property
    def points(self) -> dict[str, Any]:
        """How matplotlib draws points."""
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
"""Those that come with SUNSET, from the one that knows least to the one that knows most."""

_COLOURS: Final = ("#56B4E9", "#E69F00", "#8C6BB1", "#A6761D")
_OTHERS: Final = tuple(Style(colour, marker) for marker, colour in product("DPh<>", _COLOURS))


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
        first = int.from_bytes(hashlib.sha256(name.encode()).digest()[:4]) % len(_OTHERS)
        choices = [SHIPPED[name]] if name in SHIPPED else [*_OTHERS[first:], *_OTHERS[:first]]
        markers = {style.marker for style in found.values()}
        used = set(found.values())
        found[name] = min(choices, key=lambda style: (style.marker in markers, style in used))
    return found
