"""A figure of an outage: which topics fall silent, which only by ripple, and what brings them back."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from sunset.figures import BLUE, ORANGE, check_figure, drawing, save_figure
from sunset.metrics import ExecutedAdaptation, Timeline
from sunset.names import base_name
from sunset.system import full_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BEFORE_S: Final = 1.0
_GAP_PERIODS: Final = 3
"""A longer time between two messages is drawn as a silence, in periods of the flight."""
_LINE: Final = 0.28
"""Height of a line of text; 1 is from topic to topic."""


def outage_figure(
    timeline: Timeline,
    executed: Sequence[ExecutedAdaptation],
    topics: Sequence[str],
    path: Path,
    *,
    title: str = "",
) -> None:
    """Draw each message on topics whose silence is a failure, and the adaptations, from 1 s before the injection.

    Args:
        timeline: of a run.
        executed: its adaptations.
        topics: the topics, from above.
        path: a `.pdf`, `.png` or `.svg`, which is replaced; its folder is made.
        title: above the figure.

    Raises:
        MissingExtraError: matplotlib is not installed.
        InvalidInputError: the path has another suffix.
        OutputError: the file cannot be written.
    """
    check_figure(path)
    with drawing({"font.size": 8}) as new_figure:
        figure = new_figure(figsize=(7.2, 2.5), dpi=140, layout="constrained")
        axes = figure.subplots()
        _fill(axes, timeline, executed, topics)
        figure.suptitle(title, fontsize=8, x=0.01, ha="left")
    with drawing():
        save_figure(figure, path)


def _fill(
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
