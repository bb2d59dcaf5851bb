"""Figures of what became of the faults: how long cures take, and what was cured, masked or missed."""

from collections.abc import Sequence
from typing import Final

from sunset.evaluation.chart_runs import NO_RUN, Setup, uneven_notes
from sunset.evaluation.charts import Chart, Curve, Curves, Shares
from sunset.evaluation.treatments import ALL, TimeToCure, fates, times_to_cure, untold_note
from sunset.metrics import FATES, FaultOutcome

_NO_FAULT: Final = "There is no fault in any of the runs."


def cures_chart(found: Sequence[Setup]) -> Chart:
    """Return which share of the faults is not cured yet, by failure, over the time since their onset."""
    panels, lines = [], []
    for setup in found:
        times = {
            name: times_to_cure(outcomes, setup.duration_s) for name, outcomes in _outcomes(setup).items()
        }
        failures = sorted({failure for by_failure in times.values() for failure in by_failure} - {ALL})
        for failure in (*failures, *[ALL] * (len(failures) > 1)):
            known = {name: by_failure[failure] for name, by_failure in times.items() if failure in by_failure}
            curves = {name: _curve(name, time) for name, time in known.items()}
            panels.append(
                Curves(
                    title=setup.title("all failures" if failure == ALL else failure),
                    label="time since the onset [s]",
                    share_label="faults not cured yet",
                    end=setup.duration_s,
                    curves=tuple(curves.values()),
                )
            )
            lines += [
                (
                    *(setup.label, failure, name, time.survival.number, time.survival.events),
                    *(time.mean_s, time.horizon_s, *step),
                )
                for name, time in known.items()
                for step in zip(curves[name].x, curves[name].shares, strict=True)
            ]
    return Chart(
        name="cures",
        title="Time to cure by failure",
        meaning="Which share of the faults is not cured yet, by the estimate of Kaplan and Meier: one that heals by "
        "itself, or is there when its run ends, counts until then. Below the axis are restricted means [s], in which "
        "one that is not cured counts as the measured time. A curve below another one is better.",
        panels=tuple(panels),
        missing=_notes(found, has_panels=bool(panels)),
        head=(
            *("setup", "failure", "system", "faults", "cured", "restricted_mean_s", "horizon_s"),
            *("time_s", "not_cured"),
        ),
        lines=tuple(lines),
    )


def fates_chart(found: Sequence[Setup]) -> Chart:
    """Return which share of each fault was cured, masked and missed."""
    panels, lines = [], []
    for setup in found:
        counts = {name: fates(outcomes) for name, outcomes in _outcomes(setup).items()}
        counts = {name: by_fault for name, by_fault in counts.items() if by_fault}
        faults = sorted({fault for by_fault in counts.values() for fault in by_fault})
        for fate in FATES if faults else ():
            shares = tuple(
                tuple(
                    by_fault[fault][fate] / sum(by_fault[fault].values()) if fault in by_fault else None
                    for by_fault in counts.values()
                )
                for fault in faults
            )
            panels.append(
                Shares(
                    title=setup.title(f"{fate} [%]"),
                    is_good=fate == "cured",
                    lines=tuple(faults),
                    columns=tuple(counts),
                    shares=shares,
                )
            )
        lines += [
            (
                setup.label,
                fault,
                name,
                sum(by_fault[fault].values()),
                *(by_fault[fault][fate] for fate in FATES),
            )
            for fault in faults
            for name, by_fault in counts.items()
            if fault in by_fault
        ]
    return Chart(
        name="fates",
        title="What became of each fault",
        meaning="How many of a hundred faults the managing system cured; of how many it only hid the symptom for a "
        "while (masked); and of how many neither (missed). The data has how many there were.",
        panels=tuple(panels),
        missing=_notes(found, has_panels=bool(panels)),
        head=("setup", "fault", "system", "faults", *FATES),
        lines=tuple(lines),
    )


def _outcomes(setup: Setup) -> dict[str, list[FaultOutcome]]:
    """Return what became of the faults of each managing system's runs, by suites and flights together."""
    return {
        name: [outcome for run in runs for outcome in run.outcomes or ()]
        for name, runs in setup.all_suites.items()
    }


def _curve(name: str, time: TimeToCure) -> Curve:
    """Return the steps of a curve, from the onset to the horizon."""
    steps = zip(time.survival.times.tolist(), time.survival.shares.tolist(), strict=True)
    inside = [(at, share) for at, share in steps if at < time.horizon_s]
    x, shares = zip((0.0, 1.0), *inside, (time.horizon_s, inside[-1][1] if inside else 1.0), strict=True)
    return Curve(system=name, x=x, shares=shares, mean=time.mean_s)


def _notes(found: Sequence[Setup], *, has_panels: bool) -> tuple[str, ...]:
    if not any(setup.suites for setup in found):
        return (NO_RUN,)
    untold = [
        untold_note(name, sum(run.outcomes is None for run in runs), len(runs))
        for setup in found
        for name, runs in setup.all_suites.items()
        if any(run.outcomes is None for run in runs)
    ]
    if has_panels:
        return (*untold, *uneven_notes(found))
    return tuple(untold) or (_NO_FAULT,)
