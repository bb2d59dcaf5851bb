"""The figure of what became of the faults: cured, masked or missed."""

from collections.abc import Sequence
from typing import Final

from sunset.evaluation.chart_runs import NO_RUN, Setup, uneven_notes
from sunset.evaluation.charts import Chart, Shares
from sunset.evaluation.treatments import fates
from sunset.metrics import FATES, FaultOutcome

_NO_FAULT: Final = "There is no fault in any of the runs."


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
        name: [outcome for run in runs for outcome in run.outcomes] for name, runs in setup.all_suites.items()
    }


def _notes(found: Sequence[Setup], *, has_panels: bool) -> tuple[str, ...]:
    if not any(setup.suites for setup in found):
        return (NO_RUN,)
    return uneven_notes(found) if has_panels else (_NO_FAULT,)
