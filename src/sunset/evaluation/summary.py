"""The rows of the table, with the runs of a managing system each."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from math import inf
from operator import attrgetter
from pathlib import PurePath
from typing import Final

from msgspec.inspect import FloatType, IntType, UnionType, type_info

from sunset.evaluation.figure_frame import SHIPPED
from sunset.evaluation.intervals import Estimate, estimate
from sunset.evaluation.results import FIGURES, RunRow
from sunset.files.schemas import fields_of
from sunset.metrics import FATES, FaultOutcome, RunMetrics
from sunset.recording import TABLE_REFERENCES
from sunset.system import REPAIR

PAPER_SUITES: Final = frozenset({"paper", "nofault", "degraded"})
"""The suites of the paper's table."""
_REFERENCE_FIGURES: Final = (
    "iou",
    "iou_all",
    "miou",
    "frames_without_truth",
)  # they judge no managing system
_SUITES: Final = ("paper", "artifact", "nofault", "degraded")
_SUITE_LABELS: Final = {
    "paper": "",
    "nofault": ", no faults",
    "degraded": ", F4 and F5",
    "": " (own scenarios)",
}


@dataclass(frozen=True)
class SystemRow:
    """A row of the table.

    Attributes:
        system: its name.
        all_runs: its runs, also invalid runs; they have all but scenario and seed in common.
    """

    system: str
    all_runs: Sequence[RunRow]

    @property
    def example(self) -> RunRow:
        """A run of the row."""
        return self.all_runs[0]

    @cached_property
    def valid(self) -> Sequence[RunRow]:
        """Its valid runs."""
        return [run for run in self.all_runs if run.valid]

    @property
    def runs(self) -> int:
        """The number of valid runs."""
        return len(self.valid)

    @cached_property
    def estimates(self) -> Mapping[str, Estimate | None]:
        """Figure → estimate over the valid runs; None where it is not applicable."""
        judged = _REFERENCE_FIGURES if self.is_reference else FIGURES
        return {name: estimate_figure(self.valid, name) if name in judged else None for name in FIGURES}

    @property
    def outcomes(self) -> Sequence[FaultOutcome]:
        """The outcomes of the faults of all valid runs; empty for reference rows."""
        return [outcome for run in self.valid if not self.is_reference for outcome in run.outcomes]

    def total(self, figure: str) -> float:
        """Return a figure's sum over the valid runs; 0 for reference rows."""
        return 0 if self.is_reference else sum(run.metrics[figure] or 0 for run in self.valid)

    @property
    def is_reference(self) -> bool:
        """Whether it shows the managed system alone."""
        return (self.example.suite, self.example.manager) in TABLE_REFERENCES

    @property
    def unresolved_rate(self) -> float | None:
        """The share of failure episodes that no adaptation ended; None without episodes, and for reference rows."""
        episodes = self.total("episodes")
        return self.total("episodes_unresolved") / episodes if episodes else None

    @property
    def cured(self) -> int:
        """The number of cured faults."""
        return sum(outcome.cured is not None for outcome in self.outcomes)

    @property
    def cured_rate(self) -> float | None:
        """The share of cured faults; None without faults."""
        return self.cured / len(self.outcomes) if self.outcomes else None

    @property
    def fates(self) -> dict[str, dict[str, int]]:
        """The number of faults by fate: fault → fate → number."""
        counts = Counter((outcome.fault, outcome.fate) for outcome in self.outcomes)
        return {name: {fate: counts[name, fate] for fate in FATES} for name in sorted({f for f, _ in counts})}


def summarise(rows: Iterable[RunRow]) -> list[SystemRow]:
    """Return a row for each managing system and suite, the paper's two reference rows first.

    Runs of different models, flights, middlewares or versions are in different rows, whose names say which if there are
    several. Names also mark looped flights, unusual durations, incomplete suites, and settings. Invalid runs count
    for no figure, and are listed.
    """
    return [SystemRow(name, group) for name, group in named_groups(rows)]


def estimate_figure(runs: Sequence[RunRow], name: str) -> Estimate | None:
    """Return the mean of a figure of runs, with an interval within the figure's limits; None if no run has it."""
    mean = estimate([run.metrics[name] for run in runs], [run.cluster for run in runs])
    if mean is None or mean.interval is None:
        return mean
    (low, high), (least, most) = mean.interval, _limits(name)
    most = min(most, runs[0].flight.duration_s) if name.endswith("_s") else most
    return replace(mean, low=max(low, least), high=min(high, most))


@cache
def _limits(name: str) -> tuple[float, float]:
    """Return the least and the largest value of a figure."""
    kind = type_info(fields_of(RunMetrics)[name])
    kinds = kind.types if isinstance(kind, UnionType) else (kind,)
    number = next(each for each in kinds if isinstance(each, IntType | FloatType))
    return (-inf if number.ge is None else number.ge, inf if number.le is None else number.le)


def named_groups(
    rows: Iterable[RunRow], *, by_flight: bool = True, name_suite: bool = True
) -> list[tuple[str, list[RunRow]]]:
    """Return the names of rows, as in `summarise`, with their runs.

    Unless it is `by_flight`, all flights of a duration are in a row, and names have no settings. Names have the suite
    if `name_suite`.
    """
    runs = list(rows)
    groups: dict[tuple[object, ...], list[RunRow]] = {}
    for run in sorted(runs, key=_order):
        like = run if by_flight else replace(run, flight=replace(run.flight, bag="", name=""))
        groups.setdefault((run.suite, run.manager, *like.conditions), []).append(run)
    names = manager_names({run.manager for run in runs})
    return [
        (
            names[group[0].manager]
            + (_SUITE_LABELS.get(group[0].suite, f" ({group[0].suite})") if name_suite else "")
            + (setting_label(group[0], runs, part_label(group)) if by_flight else part_label(group)),
            group,
        )
        for group in groups.values()
    ]


def setting_label(run: RunRow, runs: Sequence[RunRow], part: str = "", *, by_flight: bool = True) -> str:
    """Return the settings in the name of a run's row: unusual settings, and settings that differ within a report.

    `runs` are all runs of the report, and `part` is the text behind the model.
    """
    several_models, several_bags, several_middlewares, several_versions = (
        len({value(other) for other in runs}) > 1
        for value in map(attrgetter, ("model", "flight.bag", "middleware", "version"))
    )
    return (
        (f" [{run.model}]" if several_models else "")
        + part
        + run.flight.label(bag=by_flight and several_bags)
        + (f" [{run.task}]" if run.task != REPAIR else "")
        + "".join(f" [{text}]" for name, text in run.amounts.items() if run.settings[name])
        + (f" [{run.middleware}]" if several_middlewares else "")
        + (f" [sunset {run.version or 'unknown'}]" if several_versions else "")
    )


def part_label(group: Sequence[RunRow]) -> str:
    """Return the suffix ` [3 of 54 scenarios]` for a name; empty for a complete or unknown suite."""
    number = len({run.scenario.removesuffix(f" {run.faults}") for run in group})
    size = max((run.suite_size for run in group), default=0)
    return f" [{number} of {size} scenarios]" if number < size else ""


def _order(run: RunRow) -> tuple[object, ...]:
    """Return the key of rows' order: references, then suites, then managing systems."""
    pair = (run.suite, run.manager)
    return (
        _place(pair, TABLE_REFERENCES),
        _place(run.suite, _SUITES),
        run.suite,
        _place(run.manager, tuple(SHIPPED)),
        run.manager,
        *run.conditions,
        run.scenario,
        run.seed,
    )


def _place(item: object, order: Sequence[object]) -> int:
    return order.index(item) if item in order else len(order)


def manager_names(managers: set[str]) -> dict[str, str]:
    """Return managing system → short name: files without their folders, unless two names would be the same."""
    files = {manager for manager in managers if "/" in manager and not manager.startswith("exec:")}
    short = {manager: PurePath(manager).name if manager in files else manager for manager in managers}
    names = list(short.values())
    return {manager: name if names.count(name) == 1 and name else manager for manager, name in short.items()}
