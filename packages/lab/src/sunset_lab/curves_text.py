"""Curves as text, CSV and JSON, and the strengths of faults by severity."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, astuple, fields
from itertools import pairwise
from typing import Final

from sunset.calibration import AUC, effects
from sunset.perception.severities import LOSSES, SeverityTable
from sunset.system import get_fault
from sunset.texts.sentences import csv_text
from sunset.texts.tables import aligned
from sunset_lab.curves import BAND, CURED, DROP, SHARPNESS_AUC, Case, Curves, Figures

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

    Args:
        points: (strength, loss), in the order of the strengths.
        loss: a share of the healthy IoU.

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
