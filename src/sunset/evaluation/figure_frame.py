"""The frame of a report's figures: size, panels, legend, files, and the styles of managing systems."""

import hashlib
import io
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from html import escape
from itertools import product
from math import ceil
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from sunset.files.plots import BLUE, ORANGE, drawing, save_figure
from sunset.texts.sentences import csv_text
from sunset_ros.texts import printable

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

INK: Final = "#1b1b1b"
PAPER: Final = "#ffffff"
"""The colours of text and background, which a page replaces with its own."""
COLUMN_IN: Final = 3.5
PAGE_IN: Final = 7.0
"""Widths of a figure [in]: of a column and of a page."""
HEIGHT_IN: Final = 9.0
"""The greatest height of a figure [in]."""
SOFT: Final = "#666666"
"""The colour of axes and guides."""
GRID: Final = "#cccccc"
SETTINGS: Final = {
    "font.size": 8,
    "axes.titlesize": "medium",
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "figure.labelsize": "medium",
    "text.parse_math": False,  # names of others are not formulas
    **dict.fromkeys(("text.color", "axes.labelcolor", "xtick.color", "ytick.color"), INK),
    "axes.edgecolor": SOFT,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.5,
}
"""The settings of matplotlib."""

_ON_PAGE: Final = {INK: "currentColor", SOFT: "var(--soft)", GRID: "var(--line)", PAPER: "var(--paper)"}
"""Colours that a page replaces with its own, light or dark."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportFigure:
    """A figure of a report, in files and in a page."""

    name: str
    title: str
    caption: str
    head: Sequence[str]  # the names of the columns of its data
    lines: Sequence[Sequence[object]]
    picture: "Figure | None"  # None without data to draw
    missing: Sequence[str]  # sentences about parts that are not drawn

    def as_csv(self) -> str:
        """Return its data as CSV."""
        return csv_text([self.head, *self.lines])

    def save(self, path: Path) -> None:
        """Write the picture to a `.pdf`, `.png` or `.svg` in an existing folder."""
        if self.picture is not None:
            with report_drawing():
                save_figure(self.picture, path, make_folder=False)

    def as_html(self) -> str:
        """Return it with its data for a page, which has the colours `--paper`, `--soft` and `--line`."""
        texts = [f"<h3>{escape(self.title)}</h3>", f"<p>{escape(printable(self.caption))}</p>"]
        texts += [f'<p class="missing">{escape(printable(text))}</p>' for text in self.missing]
        picture = "" if self.picture is None else f'<div class="scroll">{self._svg(self.picture)}</div>\n'
        data = f"<details><summary>Data as CSV</summary><pre>{escape(printable(self.as_csv()))}</pre></details>\n"
        return (
            f'<figure id="{self.name}">\n<figcaption>{"".join(texts)}</figcaption>\n'
            f"{picture}{data if self.lines else ''}</figure>"
        )

    def _svg(self, picture: "Figure") -> str:
        out = io.StringIO()
        with report_drawing({"svg.hashsalt": self.name, "svg.fonttype": "none"}):
            picture.savefig(out, format="svg", transparent=True, metadata={"Date": None})
        text = out.getvalue()
        text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
        text = re.sub(r'<g id="[^"]*"', "<g", text)  # ids would repeat within the page
        text = re.sub("|".join(_ON_PAGE), lambda match: _ON_PAGE[match.group()], text)
        width = "page" if picture.get_figwidth() > COLUMN_IN else "column"
        return text.replace(
            "<svg", f'<svg class="{width}" role="img" aria-label="{escape(self.title)}"', 1
        ).strip()


@contextmanager
def report_drawing(settings: Mapping[str, object] = MappingProxyType({})) -> Iterator[None]:
    """Let matplotlib draw in the style of a report, with further settings."""
    with drawing({**SETTINGS, **settings}), warnings.catch_warnings():
        # names of managing systems may have letters that the font lacks; a page has its own font
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield


def panels(
    count: int, most_columns: int, height: float, *, sharey: bool = True
) -> tuple["Figure", list["Axes"]]:
    """Return a figure and its panels of this height [in], which share their horizontal scale."""
    from matplotlib.figure import Figure  # noqa: PLC0415  an optional extra

    columns = min(count, most_columns)
    rows, width = ceil(count / columns), COLUMN_IN if columns == 1 else PAGE_IN
    figure = Figure(figsize=(width, min(HEIGHT_IN, rows * height)), dpi=300, layout="constrained")
    grid = list(figure.subplots(rows, columns, sharex=True, sharey=sharey, squeeze=False).flat)
    for place, axes in enumerate(grid):
        axes.tick_params(labelbottom=place + columns >= count)
        if place >= count:
            axes.set_axis_off()
    return figure, grid[:count]


def add_legend(figure: "Figure", handles: Iterable["Artist"]) -> None:
    """Put a legend below a figure, and increase its height."""
    entries = list(handles)
    width = 0.6 + 0.07 * max(len(str(handle.get_label())) for handle in entries)
    columns = max(1, min(len(entries), int(figure.get_figwidth() / width)))
    figure.set_figheight(min(HEIGHT_IN, figure.get_figheight() + 0.05 + 0.17 * ceil(len(entries) / columns)))
    figure.legend(handles=entries, loc="outside lower center", ncols=columns, frameon=False, handlelength=3)


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


SHIPPED: Final = {
    "none": Style("#777777", "X"),
    "random": Style("#CC79A7", "v"),
    "baseline": Style(BLUE, "o"),
    "reactive": Style(ORANGE, "s"),
    "diagnosing": Style("#009E73", "^"),
    "inspecting": Style("#B2182B", "p"),
    "oracle": Style(INK, "*"),
}
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
