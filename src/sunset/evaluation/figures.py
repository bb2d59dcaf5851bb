"""Figures of single runs: the entropy over time, as in the paper, and the messages during an outage."""

from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from sunset.evaluation.figure_frame import PAGE_IN, SETTINGS
from sunset.files.plots import BLUE, GREY, ORANGE, drawing, save_figure
from sunset.metrics import ExecutedAdaptation, Samples, Timeline
from sunset.system import GAP_S, MovingMean, full_name
from sunset.texts.names import base_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# with different dashes, too; without yellow, which is too light for lines
_STYLES: Final[tuple[tuple[str, object], ...]] = (
    ("#000000", "-"),
    (BLUE, "-"),
    (ORANGE, "-"),
    ("#009E73", (0, (5, 1.5))),
    ("#CC79A7", (0, (5, 1.5))),
    ("#E69F00", (0, (3, 1.2, 1, 1.2))),
    ("#56B4E9", (0, (1.2, 1.2))),
)

_BEFORE_S: Final = 1.0
_GAP_PERIODS: Final = 3
"""The time between two messages from which on it is drawn as a silence, in periods of the flight."""
_LINE: Final = 0.28
"""The height of a line of text, as a share of the distance of topics."""


def entropy_figure(
    series: Mapping[str, Samples], threshold: float, path: Path, *, iou: Mapping[str, Samples]
) -> None:
    """Draw entropy over time, with a line for each fault, and the IoU beside it.

    Lines are means of the last five samples, which decide failure F4; single samples are drawn faintly behind them. A
    gap of more than 1 s breaks a line.

    Args:
        series: name → entropy over time [s], at least one; in the order of the legend.
        threshold: above it, F4 holds.
        path: a `.pdf`, `.png` or `.svg`, in a folder that may be new.
        iou: name → IoU over time [s].

    Source: the paper, figure 2a.
    """
    with drawing(SETTINGS) as new_figure:
        figure = new_figure(figsize=(PAGE_IN, 2.8), dpi=300, layout="constrained")
        panels = figure.subplots(1, 2, sharex=True)
        styles = {name: _STYLES[place % len(_STYLES)] for place, name in enumerate(series)}
        _panel(panels[0], series, styles, "entropy")
        _panel(panels[1], iou, styles, "IoU")
        panels[0].axhline(
            threshold, color=GREY, linewidth=0.9, linestyle=(0, (1, 1)), label=f"threshold {threshold:.3g}"
        )
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(
            *(handles, labels),
            loc="outside upper center",
            ncols=min(len(labels), 3),
            frameon=False,
            handlelength=2.2,
        )
        save_figure(figure, path)


def _panel(
    axes: "Axes", series: Mapping[str, Samples], styles: Mapping[str, tuple[str, object]], label: str
) -> None:
    for name, samples in series.items():
        colour, dashes = styles[name]
        axes.plot(samples.times, samples.values, ".", color=colour, markersize=1, alpha=0.2)
        axes.plot(*_moving_mean(samples), color=colour, linestyle=dashes, label=name.replace("_", " "))
    axes.set_xlabel("time since injection [s]")
    axes.set_ylabel(label)
    axes.set_ylim(bottom=0)
    axes.margins(x=0.01)
    axes.axvline(0, color="#bbbbbb", linewidth=0.6, zorder=0)


def _moving_mean(samples: Samples) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the mean of the samples up to each sample; NaN, which breaks a line, without enough samples."""
    mean = MovingMean(GAP_S)
    pairs = zip(samples.times.tolist(), samples.values.tolist(), strict=True)
    return samples.times, np.array([mean.add(*pair) for pair in pairs], dtype=np.float64)


def outage_figure(
    timeline: Timeline,
    executed: Sequence[ExecutedAdaptation],
    path: Path,
    *,
    topics: Sequence[str],
    title: str,
) -> None:
    """Draw each message on topics whose silence is a failure, and the adaptations, from 1 s before the injection.

    The path is a `.pdf`, `.png` or `.svg`, in a folder that may be new.
    """
    with drawing({"font.size": 8}) as new_figure:
        figure = new_figure(figsize=(7.2, 2.5), dpi=140, layout="constrained")
        axes = figure.subplots()
        _draw_outage(axes, timeline, executed, topics)
        figure.suptitle(title, fontsize=8, x=0.01, ha="left")
    with drawing():
        save_figure(figure, path)


def _draw_outage(
    axes: "Axes", timeline: Timeline, executed: Sequence[ExecutedAdaptation], topics: Sequence[str]
) -> None:
    for row, topic in enumerate(topics):
        sent = timeline.message_times.get(full_name(topic), np.empty(0))
        axes.eventplot(
            sent[sent > -_BEFORE_S], lineoffsets=-row, linelengths=0.5, linewidths=1.5, colors=BLUE
        )
        ends = [*(sent if sent.size else [-_BEFORE_S]), timeline.duration_s]
        for begin, end in pairwise(ends):
            if end - begin > _GAP_PERIODS * timeline.period_s and end > 0:
                axes.plot([begin, end], [-row, -row], color=ORANGE, linewidth=4, solid_capstyle="butt")
                axes.annotate(
                    f"{end - begin:.1f} s", ((begin + end) / 2, -row + 0.14), ha="center", color=ORANGE
                )
    injected = sorted({injection.time for injection in timeline.injections})
    for time in injected:
        axes.axvline(time, color=ORANGE, linestyle=":", linewidth=1)
        axes.annotate("fault", (time, 0.62), ha="center", color=ORANGE)
    for above, adaptation in enumerate(reversed(executed)):
        text = (adaptation.time, 0.62 + _LINE * above)
        axes.vlines(adaptation.time, 0.4 - len(topics), text[1] + _LINE / 2, "black", "--", linewidth=1)
        axes.annotate(f" {adaptation}", text, color="black")
    axes.set_yticks([-row for row in range(len(topics))], [base_name(topic) for topic in topics])
    height = 0.9 + _LINE * max(0, len(executed) - 1)
    axes.set(
        xlabel="time since injection [s]",
        xlim=(-_BEFORE_S, timeline.duration_s),
        ylim=(0.4 - len(topics), height),
    )
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
