"""The paper's figure: what faults do to the segmentation's entropy, over time."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from sunset.errors import InvalidInputError
from sunset.evaluation.figure_frame import COLUMN_IN, PAGE_IN, SETTINGS
from sunset.figures import BLUE, GREY, ORANGE, check_figure, drawing, save_figure
from sunset.metrics import Samples
from sunset.system import WINDOW, MovingMean

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# told apart by dashes as well; without the yellow, which is too light for lines
_STYLES: Final[tuple[tuple[str, object], ...]] = (
    ("#000000", "-"),
    (BLUE, "-"),
    (ORANGE, "-"),
    ("#009E73", (0, (5, 1.5))),
    ("#CC79A7", (0, (5, 1.5))),
    ("#E69F00", (0, (3, 1.2, 1, 1.2))),
    ("#56B4E9", (0, (1.2, 1.2))),
)


def entropy_figure(
    series: Mapping[str, Samples], threshold: float, path: Path, *, iou: Mapping[str, Samples] | None = None
) -> None:
    """Draw entropy over time, one line a fault, and the IoU beside it where that is given.

    Lines are means of the last five samples, which is what failure F4 is judged by; single samples are
    drawn faintly behind them. A gap of more than 1 s breaks a line. The width fits one column of a paper,
    or two with the IoU.

    Args:
        series: name → entropy over time [s]; in the order of the legend.
        threshold: above it, F4 holds.
        path: a `.pdf`, `.png` or `.svg`, which is replaced; its folder is made.
        iou: name → IoU over time [s], for names of `series`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        InvalidInputError: there is nothing to draw, or the path has another suffix.
        OutputError: the file cannot be written.

    Source: the paper, figure 2a.
    """
    check_figure(path)
    if not series:
        raise InvalidInputError("There is nothing to draw: no series of samples was given.")
    unknown = sorted(set(iou or {}) - set(series))
    if unknown:
        raise InvalidInputError(f"The IoU of {unknown[0]!r} has no entropy beside it; give both.")
    _draw(series, threshold, path, iou or {})


def _draw(series: Mapping[str, Samples], threshold: float, path: Path, iou: Mapping[str, Samples]) -> None:
    with drawing(SETTINGS) as new_figure:
        figure = new_figure(
            figsize=(PAGE_IN, 2.8) if iou else (COLUMN_IN, 2.9), dpi=300, layout="constrained"
        )
        panels = figure.subplots(1, 2 if iou else 1, squeeze=False, sharex=True)[0]
        styles = {name: _STYLES[place % len(_STYLES)] for place, name in enumerate(series)}
        _panel(panels[0], series, styles, "entropy")
        panels[0].axhline(
            threshold, color=GREY, linewidth=0.9, linestyle=(0, (1, 1)), label=f"threshold {threshold:.3g}"
        )
        if iou:
            _panel(panels[1], iou, styles, "IoU")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(
            handles,
            labels,
            loc="outside upper center",
            ncols=min(len(labels), 3 if iou else 2),
            frameon=False,
            handlelength=2.2,
        )
        save_figure(figure, path)


def _panel(
    axes: "Axes", series: Mapping[str, Samples], styles: Mapping[str, tuple[str, object]], label: str
) -> None:
    for name, samples in series.items():
        colour, dashes = styles[name]
        axes.plot(*_with_gaps(samples.times, samples.values), color=colour, linewidth=0.4, alpha=0.2)
        axes.plot(*_moving_mean(samples), color=colour, linestyle=dashes, label=name.replace("_", " "))
    axes.set_xlabel("time since injection [s]")
    axes.set_ylabel(label)
    axes.set_ylim(bottom=0)
    axes.margins(x=0.01)
    axes.axvline(0, color="#bbbbbb", linewidth=0.6, zorder=0)


def _moving_mean(samples: Samples) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return the mean that each sample is the last one of; NaN, which breaks a line, where there is none."""
    mean = MovingMean(WINDOW.gap_s)
    pairs = zip(samples.times.tolist(), samples.values.tolist(), strict=True)
    return samples.times, np.array([mean.add(*pair) for pair in pairs], dtype=np.float64)


def _with_gaps(
    times: npt.NDArray[np.float64], values: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return a line that a gap of more than 1 s breaks."""
    breaks = np.flatnonzero(np.diff(times) > WINDOW.gap_s) + 1
    return np.insert(times, breaks, times[breaks - 1]), np.insert(values, breaks, np.nan)
