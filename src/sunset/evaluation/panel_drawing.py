"""Panels of figures, drawn by matplotlib."""

from bisect import bisect_right
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final, Literal

from sunset.evaluation.charts import Curves, Intervals, Panel, Points, Shares
from sunset.evaluation.system_styles import INK, Style
from sunset.figures import BLUE, ORANGE
from sunset.texts import printable, shorten

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SOFT: Final = "#666666"
"""The colour of what is beside the data."""
GRID: Final = "#cccccc"
PAPER: Final = "#ffffff"

_FULL: Final = 0.8
"""Above this share, a cell is so dark that text in it is white."""
_WHITE: Final = "#fefefe"
_LEAST_WIDTH_IN: Final = 3.0
_MEAN_IN: Final = 0.12
"""How high the line of a mean is below the axis [in]."""
_MEAN: Final = 0.085
"""The same as a part of the axis."""
_LONGEST: Final = 34
_LETTER_IN: Final = 0.045
"""How much higher a letter more makes a name that is written aslant [in]."""

Looks = Mapping[str, Style]
"""How managing systems are drawn, by their names."""


def panel_width(panel: Panel) -> float:
    """Return how wide a panel of a page is [in]: text in cells needs room."""
    return (
        max(_LEAST_WIDTH_IN, 1.4 + 0.2 * len(panel.columns)) if isinstance(panel, Shares) else _LEAST_WIDTH_IN
    )


def panel_height(panel: Panel) -> float:
    """Return how high a panel is [in]."""
    match panel:
        case Intervals():
            return 0.75 + 0.19 * len(panel.marks)
        case Shares():
            longest = max(len(short_name(name)) for name in panel.columns)
            return 0.6 + _LETTER_IN * longest + 0.2 * len(panel.lines)
        case Curves():
            return 2.3 + _MEAN_IN * sum(curve.mean is not None for curve in panel.curves)
    return 2.4


def draw_panel(axes: "Axes", panel: Panel, looks: Looks) -> None:
    """Draw a panel in axes of matplotlib."""
    match panel:
        case Intervals():
            _draw_intervals(axes, panel, looks)
        case Curves():
            _draw_curves(axes, panel, looks)
        case Shares():
            _draw_shares(axes, panel)
        case Points():
            _draw_points(axes, panel, looks)
    has_names = isinstance(panel, Intervals) and any(name for _, name in panel.guides)
    axes.set_title(short_name(panel.title), pad=12 if has_names else 5)


def _draw_intervals(axes: "Axes", panel: Intervals, looks: Looks) -> None:
    for place, mark in enumerate(panel.marks):
        style = looks[mark.system]
        if mark.low is not None and mark.high is not None:
            axes.plot([mark.low, mark.high], [place, place], color=style.colour, linewidth=1.6)
        axes.plot([mark.value], [place], **marker_of(style))
    for value, name in panel.guides:
        axes.axvline(value, color=SOFT, linewidth=0.8, linestyle=(0, (4, 2)), zorder=0)
        axes.annotate(
            name,
            (value, 1),
            xycoords=("data", "axes fraction"),
            xytext=(0, 2),
            textcoords="offset points",
            ha="center",
            color=SOFT,
            fontsize=7,
        )
    axes.set_yticks(range(len(panel.marks)), [short_name(mark.label) for mark in panel.marks])
    axes.set_ylim(len(panel.marks) - 0.4, -0.6)
    axes.set_xlabel(panel.label)
    axes.grid(axis="x")
    axes.margins(x=0.06)
    _few_ticks(axes, "x", 3)
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)


def _draw_curves(axes: "Axes", panel: Curves, looks: Looks) -> None:
    for place, curve in enumerate(panel.curves):
        style = looks[curve.system]
        axes.step(curve.x, curve.shares, where="post", **line_of(style))
        # markers stand elsewhere on each curve, so that those which lie on one another can be seen
        at = [
            (place + 0.5 + len(panel.curves) * number) / (4 * len(panel.curves)) * panel.end
            for number in range(4)
        ]
        shares = [curve.shares[max(0, bisect_right(curve.x, x) - 1)] for x in at]
        axes.plot(at, shares, **marker_of(style))
    axes.set(xlim=(0, panel.end), xlabel=panel.label, ylabel=panel.share_label)
    means = [(curve.system, curve.mean) for curve in panel.curves if curve.mean is not None]
    for place, (name, mean) in enumerate(means, 1):
        axes.plot([mean], [-_MEAN * place], **marker_of(looks[name]), clip_on=False)
        side = 1 if mean < 0.7 * panel.end else -1
        axes.annotate(
            f"{mean:.1f}",
            (mean, -_MEAN * place),
            xytext=(6 * side, -0.5),
            textcoords="offset points",
            ha="left" if side > 0 else "right",
            va="center",
            fontsize=6.5,
        )
    axes.set_ylim(-_MEAN * (len(means) + 0.7) if means else -0.02, 1.02)
    if means:
        axes.axhline(0, color=SOFT, linewidth=0.6)
        middle = -_MEAN * (len(means) + 1) / 2
        axes.text(
            -0.02,
            middle,
            "mean [s]",
            transform=axes.get_yaxis_transform(),
            ha="right",
            va="center",
            fontsize=7,
        )
    axes.set_yticks([0, 0.25, 0.5, 0.75, 1], ["0", "25 %", "50 %", "75 %", "100 %"])
    axes.grid()
    _few_ticks(axes, "x")


def _draw_shares(axes: "Axes", panel: Shares) -> None:
    from matplotlib.patches import Rectangle  # noqa: PLC0415  an optional extra

    for line, shares in enumerate(panel.shares):
        for column, share in enumerate(shares):
            if share is None:
                axes.annotate("–", (column, line), ha="center", va="center", color=SOFT)
                continue
            axes.add_patch(
                Rectangle(
                    (column - 0.5, line - 0.5),
                    1,
                    1,
                    facecolor=(BLUE if panel.is_good else ORANGE, share),
                    edgecolor=GRID,
                    linewidth=0.5,
                )
            )
            colour = _WHITE if share > _FULL else INK
            axes.annotate(
                f"{100 * share:.0f}", (column, line), ha="center", va="center", color=colour, fontsize=7
            )
    axes.set_xticks(
        range(len(panel.columns)), [short_name(name) for name in panel.columns], rotation=40, ha="right"
    )
    axes.set_yticks(range(len(panel.lines)), [short_name(name.replace("_", " ")) for name in panel.lines])
    axes.set(xlim=(-0.5, len(panel.columns) - 0.5), ylim=(len(panel.lines) - 0.5, -0.5))
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)


def _draw_points(axes: "Axes", panel: Points, looks: Looks) -> None:
    axes.step(
        [point.x for point in panel.front],
        [point.y for point in panel.front],
        where="post",
        color=SOFT,
        linewidth=0.8,
        linestyle=(0, (4, 2)),
        zorder=0,
    )
    for point in panel.points:
        style = looks[point.system]
        if point.x_interval:
            axes.plot(point.x_interval, (point.y, point.y), color=style.colour, linewidth=1)
        if point.y_interval:
            axes.plot((point.x, point.x), point.y_interval, color=style.colour, linewidth=1)
        axes.plot([point.x], [point.y], **marker_of(style))
    axes.set(xlabel=panel.x_label, ylabel=panel.y_label)
    axes.margins(0.08)
    axes.set_xlim(left=-0.08 * max((point.x for point in panel.points), default=1) or -1)
    axes.grid()
    _few_ticks(axes, "both")


def _few_ticks(axes: "Axes", axis: Literal["x", "both"], most: int = 5) -> None:
    axes.locator_params(axis, nbins=most, steps=[1, 2, 5, 10])


def line_of(style: Style) -> dict[str, Any]:
    """Return how matplotlib draws the line of a managing system."""
    return {"color": style.colour, "linestyle": (0, style.dashes) if style.dashes else "-"}


def marker_of(style: Style) -> dict[str, Any]:
    """Return how matplotlib draws the marker of a managing system."""
    return {
        "color": style.colour,
        "linestyle": "none",
        "marker": style.marker,
        "markersize": {"*": 8, "P": 6}.get(style.marker, 5),
        "markeredgecolor": style.colour if style.marker == "x" else PAPER,
        "markeredgewidth": 1.4 if style.marker == "x" else 0.6,
    }


def short_name(text: str) -> str:
    """Return a name as it stands in a figure."""
    return shorten(printable(text), _LONGEST)
