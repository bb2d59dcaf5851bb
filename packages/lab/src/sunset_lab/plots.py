"""Figures of curves, by strength and after the cures."""

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

from sunset.calibration import SHARPNESS, effects, signal_of
from sunset.errors import MissingExtraError
from sunset.files.plots import BLUE, GREY, ORANGE, drawing, save_figure
from sunset_lab.curves import BAND, Case, Curves, Figures

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FAULTY: Final = ORANGE  # dashes and hatching differ, too
_CURED: Final = BLUE
_STYLE: Final = {
    "font.size": 7,
    "axes.titlesize": 7,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.2,
    "lines.markersize": 2.5,
}


def draw(curves: Curves, folder: Path) -> tuple[Path, ...]:
    """Draw `curves.png`, `sharpness.png` and `cures.png` as far as there is data, and return their paths.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OutputError: a file cannot be written.
    """
    if find_spec("matplotlib") is None:
        raise MissingExtraError(
            "The figures were left out because matplotlib is not installed; "
            "run: pip install 'sunset-exemplar[plots]'."
        )
    drawn = []
    with drawing(_STYLE) as new_figure:
        for name, fill in (("curves", _by_strength), ("sharpness", _sharpness), ("cures", _cures)):
            figure = new_figure(dpi=200, layout="constrained")
            if fill(figure, curves):
                drawn.append(folder / f"{name}.png")
                save_figure(figure, drawn[-1], make_folder=False)
    return tuple(drawn)


def _by_strength(figure: "Figure", curves: Curves) -> bool:
    """Draw IoU above, entropy below, in a column for each fault."""
    faults = [fault for fault in effects() if curves.of(fault)]
    if not faults:
        return False
    figure.set_size_inches(1.5 * len(faults) + 0.7, 3.6)
    rows = figure.subplots(2, len(faults), squeeze=False, sharex="col", sharey="row")
    for place, fault in enumerate(faults):
        upper, lower = rows[0][place], rows[1][place]
        _lines(upper, curves.of(fault), fault, lambda figures: figures.iou)
        _lines(lower, curves.of(fault), fault, lambda figures: figures.entropy)
        _band(upper, curves)
        lower.axhline(curves.entropy_threshold, color=GREY, linewidth=0.8, linestyle=":")
        upper.set_title(fault.replace("_", " "))
        lower.set_xlabel(effects()[fault].unit)
    rows[0][0].set(ylabel="IoU", ylim=(0, None))
    rows[1][0].set(ylabel="entropy (dotted: threshold)", ylim=(0, None))
    handles, labels = rows[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return True


def _lines(axes: "Axes", cases: Sequence[Case], fault: str, value: Callable[[Figures], float]) -> None:
    strengths = [case.strengths[fault] for case in cases]
    cured = [(case.strengths[fault], value(case.after)) for case in cases if case.after]
    axes.plot(strengths, [value(case.before) for case in cases], "o-", color=_FAULTY, label="with the fault")
    if cured:
        axes.plot(*zip(*cured, strict=True), "--", color=_CURED, label="after its cure")
    for case in cases:
        if case.suite:
            strength = case.strengths[fault]
            axes.axvline(strength, color=GREY, linewidth=0.8, linestyle="-.", label="suite strength")
    if strengths[-1] > 10 * strengths[0]:
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")


def _band(axes: "Axes", curves: Curves) -> None:
    low, high = (share * curves.main.iou for share in BAND)
    label = f"{BAND[0]:.0%}–{BAND[1]:.0%} of nominal"
    axes.axhspan(low, high, color="#009E73", alpha=0.15, linewidth=0, label=label)


def _sharpness(figure: "Figure", curves: Curves) -> bool:
    """Draw the camera image's sharpness by strength, in a column for each fault that blurs."""
    faults = [fault for fault in effects() if curves.of(fault) and signal_of(fault) == SHARPNESS]
    if not faults:
        return False
    figure.set_size_inches(3.2 * len(faults), 2.4)
    for axes, fault in zip(figure.subplots(1, len(faults), squeeze=False)[0], faults, strict=True):
        _lines(axes, curves.of(fault), fault, lambda figures: figures.sharpness)
        axes.set(yscale="log", xlabel=effects()[fault].unit, ylabel="sharpness (dotted: threshold)")
        if curves.sharpness_threshold > 0:
            axes.axhline(curves.sharpness_threshold, color=GREY, linewidth=0.8, linestyle=":")
        axes.legend(frameon=False)
    return True


def _cures(figure: "Figure", curves: Curves) -> bool:
    """Draw IoU and entropy at suite strength before and after each cure, and the IoU of two faults at once."""
    cases = [case for case in curves.points if case.suite]
    if not cases:
        return False
    figure.set_size_inches(7.4, 3.2)
    first, second, third = figure.subplots(1, 3)
    for axes, name in ((first, "iou"), (second, "entropy")):
        for shift, color, hatch, label, side in (
            (-0.2, _FAULTY, "///", "with the fault", [case.before for case in cases]),
            (0.2, _CURED, "", "after its cure", [case.after for case in cases]),
        ):
            bars = [(place + shift, getattr(figures, name)) for place, figures in enumerate(side) if figures]
            if bars:
                axes.barh(*zip(*bars, strict=True), height=0.4, color=color, hatch=hatch, label=label)
        axes.axvline(getattr(curves.main, name), color="black", linewidth=0.8, label="nominal")
        axes.set(xlabel=name.replace("iou", "IoU"))
        _name_bars(axes, [case.name if axes is first else "" for case in cases])
    second.axvline(curves.entropy_threshold, color=GREY, linewidth=0.8, linestyle=":", label="threshold")
    pairs = curves.pairs
    third.barh(range(len(pairs)), [case.before.iou for case in pairs], color=_FAULTY, hatch="///")
    third.axvline(curves.main.iou, color="black", linewidth=0.8)
    third.axvspan(*(share * curves.main.iou for share in BAND), color="#009E73", alpha=0.15, linewidth=0)
    third.set(xlabel="IoU with two faults")
    _name_bars(third, [case.name for case in pairs])
    handles, labels = second.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return True


def _name_bars(axes: "Axes", texts: Sequence[str]) -> None:
    axes.set_yticks(range(len(texts)), [text.replace("_", " ").replace(" + ", "\n+ ") for text in texts])
    axes.invert_yaxis()
