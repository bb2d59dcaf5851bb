"""The runs of a report for its figures, by suite and managing system."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, NamedTuple

from sunset.evaluation.figure_frame import Style, in_order, styles
from sunset.evaluation.intervals import Estimate
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import ScoreTable, Systems, score_rows
from sunset.evaluation.summary import manager_names, part_label
from sunset.metrics import FaultOutcome
from sunset.recording import TABLE_REFERENCES
from sunset.texts.sentences import counted

_FIRST_SUITES: Final = ("timed", "", "test", "wild", "paper")
"""The suites that figures show first."""

Fault = tuple[str, str]
"""The failure of a fault, and its name."""


class Suite(NamedTuple):
    """A suite with a duration, and its scores, if any."""

    name: str
    title: str
    table: ScoreTable | None


class Setup(NamedTuple):
    """Comparable runs: of the same model, middleware, numeric settings and version of SUNSET."""

    common: str  # their common properties, in a sentence
    suites: Sequence[Suite]  # in the order of figures
    systems: Systems  # the valid runs of all suites, in the order of `in_order`
    scored: Systems  # all runs, since invalid runs count for scores, too
    managers: Mapping[str, str]  # name of a row of `Suite.table` → name of its managing system
    looks: Mapping[str, Style]
    remarks: Sequence[str]  # sentences about the runs


def scores_of(setup: Setup) -> Iterator[tuple[str, str, str, list[tuple[str, Estimate | None]]]]:
    """Yield the suite, flight and heading of a group, and its scores by managing system."""
    for suite in setup.suites:
        rows = [row for row in suite.table.rows if not row.is_calm] if suite.table else []
        yield suite.name, "", suite.title, [(setup.managers[row.system], row.score) for row in rows]
    flights = sorted({_flight_name(run) for runs in setup.scored.values() for run in runs})
    for flight in flights if len(flights) > 1 else ():
        systems = {
            name: [run for run in runs if _flight_name(run) == flight] for name, runs in setup.scored.items()
        }
        scores = score_rows({name: runs for name, runs in systems.items() if runs})
        yield "", flight, f"flight {flight}", [(row.system, row.score) for row in scores]


def outcomes_of(setup: Setup) -> Mapping[tuple[Fault, str], list[FaultOutcome]]:
    """Return (fault, managing system) → outcomes."""
    outcomes = defaultdict[tuple[Fault, str], list[FaultOutcome]](list)
    for name, runs in setup.systems.items():
        for outcome in (outcome for run in runs for outcome in run.outcomes):
            outcomes[(outcome.failure, outcome.fault), name].append(outcome)
    return outcomes


def setup_of(runs: Sequence[RunRow], tables: Sequence[ScoreTable]) -> Setup:
    """Return the setup with the most runs, with their scores from `tables`."""
    names = manager_names({run.manager for run in runs})
    facts = Counter(map(_facts, runs)).most_common(1)[0][0]
    members = [run for run in runs if _facts(run) == facts]
    usual = Counter(map(_duration, members)).most_common(1)[0][0]
    places = {_place(table.example): table for table in tables if _facts(table.example) == facts}
    judged = [run for run in members if run.valid and (run.suite, run.manager) not in TABLE_REFERENCES]
    shown = set(map(_place, judged))
    suites = []
    for place in sorted(shown, key=_order):
        suite, duration = place
        part = part_label([run for run in members if _place(run) == place])
        time = f" [{duration}]" if duration != usual else ""
        suites.append(Suite(suite, f"{suite or 'own scenarios'}{part}{time}", places.get(place)))
    scored = _by_system(members, names)
    systems = _by_system([run for run in members if run.valid and _place(run) in shown], names)
    return Setup(
        common=f"Runs: {', '.join((usual, *facts))}.",
        suites=suites,
        systems=systems,
        scored=scored,
        managers={row.system: names[row.manager] for table in tables for row in table.rows},
        looks=styles([*systems, *scored]),
        remarks=list(_remarks(systems, len(runs) - len(members))),
    )


def _remarks(systems: Systems, others: int) -> Iterator[str]:
    counts = [f"{name} {len(runs)}" for name, runs in systems.items()]
    if not systems:
        yield "There is no valid run of a managing system."
    if len({len(runs) for runs in systems.values()}) > 1:
        yield f"Managing systems have different numbers of valid runs: {', '.join(counts)}."
    if others:
        yield f"{counted(others, 'run')} of other models, middlewares, settings or versions are left out."


def _flight_name(run: RunRow) -> str:
    return run.flight.name or run.flight.short_bag


def _facts(run: RunRow) -> tuple[str, ...]:
    version = f"SUNSET {run.version or 'of an unknown version'}"
    return (f"model {run.model}", f"middleware {run.middleware}", *run.amounts.values(), version)


def _duration(run: RunRow) -> str:
    return f"{run.flight.duration_s:g} s" + (" looped" if run.flight.looped else "")


def _place(run: RunRow) -> tuple[str, str]:
    return run.suite, _duration(run)


def _order(place: tuple[str, str]) -> tuple[int, tuple[str, str]]:
    suite, _ = place
    return (_FIRST_SUITES.index(suite) if suite in _FIRST_SUITES else len(_FIRST_SUITES), place)


def _by_system(runs: Sequence[RunRow], names: Mapping[str, str]) -> Systems:
    managers = in_order(names[run.manager] for run in runs)
    return {name: [run for run in runs if names[run.manager] == name] for name in managers}
