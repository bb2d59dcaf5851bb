"""Runs as figures show them: those that can be put side by side, by suite and managing system."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import ScoreTable, is_scored
from sunset.evaluation.summary import manager_names, named_groups, part_label
from sunset.evaluation.system_styles import in_order
from sunset.recording import TABLE_REFERENCES
from sunset.system import DURATION_S, REPAIR
from sunset.texts import counted

NO_RUN: Final = "There is no valid run of a managing system."

_USUAL: Final = ("", f"{DURATION_S:g} s", "", "", "")
"""What need not be said of a setup, as in `_key`; empty where it is said only if there are several."""

Systems = Mapping[str, Sequence[RunRow]]
"""The valid runs of managing systems, by their names, in the order of `in_order`; none of them is empty."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """Runs that can be put side by side: of one model, duration, middleware, thinking time and version.

    Attributes:
        label: what tells it from others, and a measured time that is not the paper's; empty of the only one.
        duration_s: how long a run is measured [s].
        suites: by name, empty for scenarios of one's own.
        scored: by managing system, the runs that have a part in its score.
        tables: the scores and differences of those suites of which several managing systems were run.
        managers: name of a row of these tables → name of its managing system.
    """

    label: str
    duration_s: float
    suites: Mapping[str, Systems]
    scored: Systems
    tables: tuple[ScoreTable, ...]
    managers: Mapping[str, str]

    @property
    def all_suites(self) -> Systems:
        """The runs of all suites."""
        names = in_order(name for systems in self.suites.values() for name in systems)
        return {
            name: [run for systems in self.suites.values() for run in systems.get(name, ())] for name in names
        }

    def suite_title(self, suite: str) -> str:
        """Return what a suite is called above a panel, and how much of it was run."""
        runs = [run for systems in self.suites.get(suite, {}).values() for run in systems]
        return (suite or "own scenarios") + part_label(runs)

    def title(self, *parts: str) -> str:
        """Return the title of a panel, which says what it shows and, where there are several, of which setup."""
        return " · ".join(filter(None, (*parts, self.label)))


def setups(runs: Sequence[RunRow], tables: Sequence[ScoreTable]) -> list[Setup]:
    """Return the valid runs to repair by setup; without suites of which there are reference rows only.

    Args:
        runs: all of them.
        tables: their scores.
    """
    runs = [run for run in runs if run.task == REPAIR]
    names = manager_names({run.manager for run in runs})
    groups = named_groups(runs, by_flight=False)
    found: dict[tuple[str, ...], dict[str, dict[str, list[RunRow]]]] = {}
    for run in (run for _, group in groups for run in group if run.valid):
        suites = found.setdefault(_key(run), {})
        suites.setdefault(run.suite, {}).setdefault(names[run.manager], []).append(run)
    scored: dict[tuple[str, ...], dict[str, list[RunRow]]] = {}
    for run in (run for _, group in groups for run in group if is_scored(run)):
        scored.setdefault(_key(run), {}).setdefault(names[run.manager], []).append(run)
    durations = {_key(run): run.flight.duration_s for run in runs}
    several = [len(set(values)) > 1 for values in zip(*found, strict=True)]
    return [
        Setup(
            label=", ".join(
                text
                for text, usual, differs in zip(key, _USUAL, several, strict=True)
                if differs or usual not in {"", text}
            ),
            duration_s=durations[key],
            tables=tuple(table for table in tables if _key(table.example) == key),
            scored={name: scored[key][name] for name in in_order(scored[key])},
            managers={row.system: names[row.manager] for table in tables for row in table.rows},
            suites={
                suite: {name: systems[name] for name in in_order(systems)}
                for suite, systems in suites.items()
                if any((suite, name) not in TABLE_REFERENCES for name in systems)
            },
        )
        for key, suites in found.items()
    ]


def uneven_notes(found: Sequence[Setup]) -> tuple[str, ...]:
    """Return a sentence if managing systems that stand side by side were not run on the same."""
    few = []
    for setup in found:
        systems = setup.all_suites
        experiments = {run.experiment for runs in systems.values() for run in runs}
        few += [
            f"{name} has {counted(len(runs), 'run')} of {len(experiments)}"
            for name, runs in systems.items()
            if len(runs) < len(experiments)
        ]
    return (f"Not all were run on the same scenarios, flights and seeds: {'; '.join(few)}.",) if few else ()


def _key(run: RunRow) -> tuple[str, ...]:
    """Return what runs must have in common to stand side by side, as a reader is told it."""
    flight = run.flight
    return (
        run.model,
        f"{flight.duration_s:g} s{' looped' if flight.looped else ''}",
        f"thinking {run.thinking_s:g} s",
        run.middleware,
        f"sunset {run.version or 'unknown'}",
    )
