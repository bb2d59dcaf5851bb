"""Curves as text, CSV, JSON and figures, and the strengths of faults by severity."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, astuple, fields
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Final

from sunset.calibration import AUC, effects
from sunset.errors import MissingExtraError
from sunset.files.plots import BLUE, GREY, ORANGE, can_draw, drawing, save_figure
from sunset.perception.card import LOSSES, SeverityTable
from sunset.system import get_fault
from sunset.texts.sentences import csv_text
from sunset.texts.tables import aligned
from sunset_lab.curves import BAND, CURED, DROP, SHARPNESS_AUC, Case, Curves, Figures

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

_HEAD: Final = ("IoU", "of nom.", "entropy", "AUC", "over", "sharpness", "AUC", "under")
_FORMATS: Final = (".3f", ".4f", ".3f", ".2f", ".3f", ".3f", ".2f")
"""Of the fields of `Figures` in a table of text."""


def as_text(curves: Curves) -> str:
    """Return tables of all figures, and a judgement of the suites' strengths."""
    name, version = curves.model
    lines = [
        f"{name}, version {version}: {curves.frames} frames",
        f"thresholds: entropy {curves.entropy_threshold:.4f}, sharpness {curves.sharpness_threshold:.3f}",
        "",
    ]
    rows: list[tuple[str, ...]] = [("fault", "strength", *_HEAD, "cured: IoU", "entropy")]
    for network, figures in curves.nominal.items():
        rows.append((f"none, {network.key}", "", *_texts(curves, figures), "", ""))
    for case in curves.points:
        cured = ("", "") if case.after is None else (f"{case.after.iou:.3f}", f"{case.after.entropy:.4f}")
        (strength,) = case.strengths.values()
        mark = "*" if case.suite else " "
        rows.append((case.name, f"{strength:g}{mark}", *_texts(curves, case.before), *cured))
    lines += aligned(rows)
    if curves.pairs:
        pairs = [(case.name, *_texts(curves, case.before)) for case in curves.pairs]
        lines += ["", *aligned([("two faults at suite strength", *_HEAD), *pairs])]
    return "\n".join([*lines, "", *_cures(curves), "", *_severities(curves), "", *_advice(curves)]) + "\n"


def _texts(curves: Curves, figures: Figures) -> list[str]:
    first, *others = (format(value, form) for value, form in zip(astuple(figures), _FORMATS, strict=True))
    return [first, f"{curves.share(figures):.0%}", *others]


def _cures(curves: Curves) -> Iterator[str]:
    for fault in effects():
        if any(case.after is not None for case in curves.of(fault)):
            yield f"cure of {fault}: {get_fault(fault).cure_texts[0]}"


def _severities(curves: Curves) -> Iterator[str]:
    shares = ", ".join(f"{loss:.0%}" for loss in LOSSES)
    yield f"strengths by severity, 1 to {len(LOSSES)}, which cost {shares} of the nominal IoU:"
    for fault, strengths in severity_table(curves).strengths.items():
        yield f"{fault}: {_joined(strengths)}"


def _joined(values: Iterable[float | None]) -> str:
    return ", ".join("none" if value is None else f"{value:g}" for value in values)


def _advice(curves: Curves) -> Iterator[str]:
    """Yield whether the strengths of the suites fit, and which other strengths would."""
    nominal = curves.main.iou
    fitting = {
        fault: [case.strengths[fault] for case in curves.of(fault) if not case.shortfalls(nominal)]
        for fault in effects()
    }
    for fault, fits in fitting.items():
        for case in curves.of(fault):
            if case.suite:
                verdict = "; ".join(case.shortfalls(nominal)) or "fits"
                others = _joined(fits) or "none that was measured"
                yield f"{fault} at {case.strengths[fault]:g}: {verdict} (strengths that fit: {others})"
    for fault, effect in effects().items():
        if isinstance(effect.suite, str) and curves.of(fault) and curves.of(effect.suite):
            common = _joined(value for value in fitting[effect.suite] if value in fitting[fault])
            yield f"{effect.suite} and {fault} have one strength: both fit at {common or 'none'}"
    if curves.pairs:
        shares = [curves.share(case.before) for case in curves.pairs]
        mean = sum(shares) / len(shares)
        yield (
            f"pairs at suite strength: {min(shares):.0%} to {max(shares):.0%} of the nominal IoU, {mean:.0%} on average"
        )
    yield (
        f"A strength fits if the IoU falls by {DROP} or more, to {BAND[0]:.0%}-{BAND[1]:.0%} of nominal (blur: by "
        f"{DROP}), the AUC of the symptom is {AUC} or more (blur: {SHARPNESS_AUC}), and the cure brings the IoU back "
        f"to within {CURED}."
    )


def severity_table(curves: Curves) -> SeverityTable:
    """Return the strengths by severity of all faults whose strength a scenario can choose."""
    faults = dict.fromkeys(fault for case in curves.points for fault in case.strengths)
    name, version = curves.model
    return SeverityTable(
        model=name,
        version=version,
        frames=curves.frames,
        strengths={fault: _strengths(curves, fault) for fault in faults if get_fault(fault).limits},
    )


def _strengths(curves: Curves, fault: str) -> tuple[float | None, ...]:
    points = [(case.strengths[fault], 1 - curves.share(case.before)) for case in curves.of(fault)]
    strengths = (strength_at([(0.0, 0.0), *points], loss) for loss in LOSSES)
    form = ".0f" if isinstance(get_fault(fault).value, int) else ".4g"
    return tuple(None if value is None else float(format(value, form)) for value in strengths)


def strength_at(points: Sequence[tuple[float, float]], loss: float) -> float | None:
    """Return the least strength with a loss, interpolated between two points; None if no strength has it.

    Points are (strength, loss), in the order of the strengths, and losses are shares of the healthy IoU.

    >>> strength_at([(0.0, 0.0), (1.0, 0.2), (2.0, 0.4)], 0.3), strength_at([(0.0, 0.0), (1.0, 0.2)], 0.3)
    (1.5, None)
    """
    for (weak, less), (strong, more) in pairwise(points):
        if less < loss <= more:
            return weak + (strong - weak) * (loss - less) / (more - less)
    return None


def as_csv(curves: Curves) -> str:
    """Return a row for each measurement, as CSV."""
    names = (field.name for field in fields(Figures))
    rows: list[list[object]] = [["faults", "strengths", "suite", "state", "share_of_nominal_iou", *names]]

    def add(faults: str, strengths: str, suite: object, state: str, figures: Figures) -> None:
        values = (f"{value:.6g}" for value in (curves.share(figures), *astuple(figures)))
        rows.append([faults, strengths, suite, state, *values])

    for network, figures in curves.nominal.items():
        add("", "", "", network.key, figures)
    for case in (*curves.points, *curves.pairs):
        strengths = " + ".join(f"{value:g}" for value in case.strengths.values())
        add(case.name, strengths, int(case.suite), "faulty", case.before)
        if case.after is not None:
            add(case.name, strengths, int(case.suite), "cured", case.after)
    return csv_text(rows)


def as_json(curves: Curves) -> dict[str, object]:
    """Return all figures as a JSON object."""
    name, version = curves.model
    return {
        "model": name,
        "version": version,
        "frames": curves.frames,
        "entropy_threshold": curves.entropy_threshold,
        "sharpness_threshold": curves.sharpness_threshold,
        "nominal": {network.key: asdict(figures) for network, figures in curves.nominal.items()},
        "faults": [
            _object(curves, case)
            | {
                "cured": None if case.after is None else asdict(case.after),
                "shortfalls": list(case.shortfalls(curves.main.iou)),
            }
            for case in curves.points
        ],
        "pairs": [_object(curves, case) for case in curves.pairs],
    }


def _object(curves: Curves, case: Case) -> dict[str, object]:
    return {
        "strengths": dict(case.strengths),
        "suite": case.suite,
        "share_of_nominal_iou": curves.share(case.before),
        "faulty": asdict(case.before),
    }


def draw(curves: Curves, folder: Path) -> tuple[Path, ...]:
    """Draw `curves.png` and `cures.png`, and return their paths.

    Raises:
        MissingExtraError: matplotlib is not installed.
        OutputError: a file cannot be written.
    """
    if not can_draw():
        raise MissingExtraError(
            "The figures were left out because matplotlib is not installed; "
            "run: pip install 'sunset-exemplar[plots]'."
        )
    paths = folder / "curves.png", folder / "cures.png"
    with drawing(_STYLE) as new_figure:
        for path, fill in zip(paths, (_draw_strengths, _draw_cures), strict=True):
            figure = new_figure(dpi=200, layout="constrained")
            fill(figure, curves)
            save_figure(figure, path, make_folder=False)
    return paths


def _draw_strengths(figure: "Figure", curves: Curves) -> None:
    """Draw IoU above, entropy below, in a column for each fault."""
    faults = [fault for fault in effects() if curves.of(fault)]
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


def _draw_cures(figure: "Figure", curves: Curves) -> None:
    """Draw IoU and entropy at suite strength before and after each cure, and the IoU of two faults at once."""
    cases = [case for case in curves.points if case.suite]
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


def _name_bars(axes: "Axes", texts: Sequence[str]) -> None:
    axes.set_yticks(range(len(texts)), [text.replace("_", " ").replace(" + ", "\n+ ") for text in texts])
    axes.invert_yaxis()
