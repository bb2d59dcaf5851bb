"""Figures of a report, drawn by matplotlib: for a page each panel by itself, for a paper all of them as one."""

import io
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from html import escape
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from sunset.evaluation.charts import Chart, Intervals, Shares
from sunset.evaluation.panel_drawing import (
    GRID,
    PAPER,
    SOFT,
    Looks,
    draw_panel,
    line_of,
    marker_of,
    panel_height,
    panel_width,
    short_name,
)
from sunset.evaluation.system_styles import INK, styles
from sunset.figures import drawing, save_figure
from sunset.texts import printable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ON_PAGE: Final = (
    (INK, "currentColor"),
    (SOFT, "var(--soft)"),
    (GRID, "var(--line)"),
    (PAPER, "var(--paper)"),
)
"""Colours that a page has its own of, in the light and in the dark."""

_COLUMN_IN: Final = 3.3
_PAGE_IN: Final = 7.0
_LEGEND_IN: Final = 0.22
"""How high a line of the legend is [in]."""
_HANDLE_IN: Final = 0.6
"""How wide an entry of it is without its name [in]."""
_LETTER_IN: Final = 0.065
_SETTINGS: Final = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8,
    "xtick.labelsize": 7.5,
    "ytick.labelsize": 7.5,
    "legend.fontsize": 7.5,
    "text.color": INK,
    "text.parse_math": False,  # names of others are not formulas
    "axes.titlecolor": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": SOFT,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.4,
    "lines.markersize": 5,
    "lines.scale_dashes": True,
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}


def looks_of(charts: Sequence[Chart]) -> Looks:
    """Return how the managing systems of all figures are drawn, so that each looks the same in all of them."""
    return styles(name for chart in charts for name in chart.systems)


def save_chart(chart: Chart, looks: Looks, path: Path) -> None:
    """Draw a figure with something in it, all panels in one.

    Args:
        chart: the figure.
        looks: how the managing systems are drawn.
        path: a `.pdf` or `.png`, which is replaced; its folder must be there.

    Raises:
        OutputError: the file cannot be written.
    """
    with _drawing() as new_figure:
        save_figure(_whole(chart, looks, new_figure), path, make_folder=False)


def panels_as_svg(chart: Chart, looks: Looks) -> list[str]:
    """Return each panel as SVG to stand in a page, which has the colours `--paper`, `--ink`, `--soft` and `--line`."""
    found = []
    with _drawing() as new_figure:
        for place, panel in enumerate(chart.panels):
            figure = new_figure(figsize=(panel_width(panel), panel_height(panel)), layout="constrained")
            draw_panel(figure.subplots(), panel, looks)
            found.append(_svg(figure, f"{chart.name} {place}", panel.title))
    return found


def swatches(chart: Chart, looks: Looks) -> list[str]:
    """Return the line and the marker of each managing system of a figure's legend, as SVG to stand in it."""
    found = []
    with _drawing() as new_figure:
        for name in chart.legend:
            figure = new_figure(figsize=(0.42, 0.14))
            axes = figure.add_axes((0, 0, 1, 1))
            axes.set_axis_off()
            axes.set(xlim=(-1, 1), ylim=(-1, 1))
            axes.plot([-0.95, 0.95], [0, 0], **line_of(looks[name]))
            axes.plot([0], [0], **marker_of(looks[name]))
            found.append(_svg(figure, f"{chart.name} {name}", ""))
    return found


@contextmanager
def _drawing() -> Iterator[Any]:
    """Give matplotlib's class of figures, and let what is drawn look as figures of a report do."""
    with drawing(_SETTINGS) as new_figure, warnings.catch_warnings():
        # names of managing systems may have letters that the font lacks; a page has its own font
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        yield new_figure


def _whole(chart: Chart, looks: Looks, new_figure: Any) -> "Figure":
    """Return a figure with all panels beside and beneath one another, and the legend."""
    rows = ceil(len(chart.panels) / (2 if isinstance(chart.panels[0], Intervals) else 3))
    columns = ceil(len(chart.panels) / rows)
    width = _COLUMN_IN if columns == 1 else _PAGE_IN
    longest = max(map(len, map(short_name, chart.legend)), default=0)
    in_line = max(1, min(len(chart.legend), int(width / (_HANDLE_IN + _LETTER_IN * longest))))
    height = rows * max(map(panel_height, chart.panels)) + _LEGEND_IN * ceil(len(chart.legend) / in_line)
    figure: Figure = new_figure(figsize=(width, height), dpi=300, layout="constrained")
    grid = list(figure.subplots(rows, columns, squeeze=False).flat)
    for place, axes in enumerate(grid):
        if place >= len(chart.panels):
            axes.set_axis_off()
            continue
        panel = chart.panels[place]
        draw_panel(axes, panel, looks)
        if place % columns and isinstance(panel, Shares):
            axes.tick_params(labelleft=False)  # the lines of all panels are the same
        if place % columns and axes.get_ylabel() == grid[place - 1].get_ylabel():
            axes.yaxis.label.set_visible(False)
    if chart.legend:
        from matplotlib.lines import Line2D  # noqa: PLC0415  an optional extra

        handles = [
            Line2D([], [], **(marker_of(looks[name]) | line_of(looks[name])), label=short_name(name))
            for name in chart.legend
        ]
        figure.legend(
            handles=handles,
            loc="outside lower center",
            ncols=in_line,
            frameon=False,
            handlelength=3,
        )
    return figure


def _svg(figure: "Figure", salt: str, title: str) -> str:
    """Return a figure as SVG in the colours of a page, and the same text for the same drawing."""
    from matplotlib import rc_context  # noqa: PLC0415  an optional extra

    out = io.StringIO()
    with rc_context({"svg.hashsalt": f"sunset {salt}"}):
        figure.savefig(out, format="svg", transparent=True, metadata={"Date": None})
    text = out.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'<g id="[^"]*"', "<g", text)  # several panels of a page have the same
    for colour, own in _ON_PAGE:
        text = text.replace(colour, own)
    name = f' role="img" aria-label="{escape(printable(title))}"' if title else ' aria-hidden="true"'
    return text.replace("<svg", f"<svg{name}", 1).strip()
