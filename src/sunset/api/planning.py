"""Forecasts of campaigns: how many runs, how long they take, and which differences they would detect."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import timedelta
from itertools import pairwise
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from types import MappingProxyType
from typing import Final

from sunset.evaluation.differences import (
    DIFFERENCE,
    POWER,
    VARIANCES,
    detectable,
    power,
    reaches,
    repetitions_needed,
)
from sunset.evaluation.intervals import LEAST_LEVELS, Design, Spread
from sunset.evaluation.results import load_results
from sunset.evaluation.scores import score_tables
from sunset.experiments import BenchSpec, RunSpec, added_managers, in_turn, plan, prepare_runs, run
from sunset.managing import split_label
from sunset.processes.workers import Stages, processors
from sunset.system import degradations_of
from sunset.texts.names import RUN_FILE
from sunset.texts.sentences import counted, listed

_PAUSE: Final = 20
"""A gap between two runs that is so many times the median gap is a pause of the campaign."""

_MOMENT_S: Final = 0.01
"""Files that were written within this time were copied."""


@dataclass(frozen=True, slots=True)
class Prospect:
    """The power of a campaign for two managing systems that differ as a known pair does.

    Attributes:
        power: probability of detecting a difference of `DIFFERENCE` in utility; None without an interval.
        detectable: the difference that is detected with a probability of `POWER`; None likewise.
        repetitions: how many of them detect `DIFFERENCE` with that probability; None where no number does.
    """

    pair: str
    power: float | None = None
    detectable: float | None = None
    repetitions: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignForecast:
    """The runs of a campaign, their duration and their power.

    Attributes:
        runs: managing systems, or reference rows → number of runs.
        design: the factors that the runs are spread over, if every scenario is run on the same flights; or None.
        pace_s: seconds a run takes, with as many at a time as there are jobs; None if it is not known.
        trial: whether the pace was measured in two trial runs, and not in an earlier campaign.
        source: where the variances are from.
        prospects: the power, for each known pair.
    """

    runs: Mapping[str, int]
    design: Design | None
    pace_s: float | None
    trial: bool
    source: str
    prospects: tuple[Prospect, ...]

    @property
    def total(self) -> int:
        """How many runs there are in all."""
        return sum(self.runs.values())

    @property
    def duration_s(self) -> float | None:
        """How long they take at the measured pace [s]; None if that is not known."""
        return None if self.pace_s is None else self.total * self.pace_s

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {
            "runs": dict(self.runs),
            "total": self.total,
            "design": self.design and self.design._asdict(),
            "pace_s": self.pace_s,
            "duration_s": self.duration_s,
            "difference": DIFFERENCE,
            "chance": POWER,
            "variances": self.source,
            "power": [asdict(prospect) for prospect in self.prospects],
        }

    def __str__(self) -> str:
        """Return it as lines of text."""
        lines = [f"{name}: {counted(number, 'run')}" for name, number in self.runs.items()]
        lines.append(f"In all: {counted(self.total, 'run')}{_spread_text(self.design)}.")
        if self.duration_s is None:
            lines.append("How long they take is not known.")
        else:
            whole = timedelta(seconds=round(self.duration_s))
            where = "two trial runs" if self.trial else "the earlier campaign"
            lines.append(f"They take about {whole}: {self.pace_s:.2g} s a run, as measured in {where}.")
        return "\n".join([*lines, *self._power_lines()])

    def _power_lines(self) -> Iterator[str]:
        if self.design is None:
            yield "Which differences they detect is not known: the scenarios are on flights of their own."
            return
        if self.design.repetitions < LEAST_LEVELS:
            yield f"They detect no difference: fewer than {LEAST_LEVELS} repetitions have no interval."
            return
        yield (
            f"If two managing systems differ as those of a line do ({self.source}), a difference of {DIFFERENCE:g} in "
            "utility is detected with this probability:"
        )
        where = f"on {counted(self.design.flights, 'flight')}"
        yield from (f"  {prospect.pair}: {_prospect_text(prospect, where)}" for prospect in self.prospects)
        sizes = {"degradations": self.design.alike, "flights": self.design.flights}
        if few := [name for name, size in sizes.items() if size < LEAST_LEVELS]:
            yield (
                f"This is of these {listed(few)} only. What is said of others, too, needs at least {LEAST_LEVELS}, and "
                "more runs."
            )


def _spread_text(design: Design | None) -> str:
    if design is None:
        return ""
    parts = (
        counted(design.alike, "different degradation"),
        counted(design.flights, "flight"),
        counted(design.repetitions, "repetition"),
    )
    return f", over {listed(parts)}"


def _prospect_text(prospect: Prospect, where: str) -> str:
    if prospect.power is None or prospect.detectable is None:
        return f"not known {where}, since the variances are of fewer flights or degradations."
    some = prospect.repetitions
    needed = f"{some} repetitions {where} reach" if some else f"no number of repetitions {where} reaches"
    chance = f"{100 * POWER:g} %"
    return (
        f"{100 * prospect.power:.0f} %; {needed} {chance}; this campaign detects a difference of "
        f"{prospect.detectable:.3f} with {chance}"
    )


def count_runs(spec: BenchSpec) -> dict[str, int]:
    """Return how many runs a campaign has: of the named managing systems, and then of added ones."""
    added, runs = added_managers(spec), plan(replace(spec, references=False))
    for_score = sum(run.manager_name in added for run in runs)
    names = [label or manager for label, manager in map(split_label, spec.managers)]
    counts = {listed(names): len(runs) - for_score}
    if added:
        counts[f"{listed(added)}, for the score"] = for_score
    references = len(plan(spec)) - len(runs)
    return counts | ({"the paper's reference rows": references} if references else {})


def forecast(
    spec: BenchSpec, like: Path | None = None, *, jobs: int | None = None, preparing: Stages | None = None
) -> CampaignForecast:
    """Return the runs of a campaign, their duration and their power, as `sunset.plan_bench` does."""
    spreads, source = dict(VARIANCES), "baseline, reactive and oracle on the test split"
    if like is not None:
        if measured := _measured(like):
            spreads, source = measured, f"in {like}"
        else:
            source += f", since {like} has no two managing systems with {LEAST_LEVELS} repetitions"
    runs, added = plan(replace(spec, references=False)), added_managers(spec)
    design = _design([run for run in runs if run.manager_name not in added], spec.repetitions)
    pace_s = _trial_pace(runs, jobs or processors(), preparing) if like is None else _pace(like)
    return CampaignForecast(
        runs=MappingProxyType(count_runs(spec)),
        design=design,
        pace_s=pace_s,
        trial=like is None,
        source=source,
        prospects=tuple(_prospect(*item, design) for item in spreads.items()) if design else (),
    )


def _design(runs: Sequence[RunSpec], repetitions: int) -> Design | None:
    """Return the factors that runs are spread over; None where some scenarios are on flights of their own."""
    flights: dict[str, set[object]] = {}
    for run_spec in runs:
        flights.setdefault(run_spec.scenario.name, set()).add(run_spec.flight)
    if len({frozenset(each) for each in flights.values()}) > 1:
        return None
    scenarios = [run_spec.scenario for run_spec in runs]
    alike = {degradations_of(fault.name for fault in each.faults) or each.name for each in scenarios}
    return Design(alike=len(alike), flights=len(next(iter(flights.values()))), repetitions=repetitions)


def _prospect(pair: str, spread: Spread, design: Design) -> Prospect:
    if design.repetitions < LEAST_LEVELS or not reaches(spread, design):
        return Prospect(pair)
    planned = replace(spread, sizes=design)
    return Prospect(pair, power(planned), detectable(planned), repetitions_needed(planned))


def _measured(folder: Path) -> dict[str, Spread]:
    """Return the variances of those differences between neighbours in a campaign that have an interval."""
    return {
        f"{difference.first} − {difference.second}": difference.utility.spread
        for table in score_tables(load_results(folder))
        for difference in table.neighbours
        if difference.utility and difference.utility.spread
    }


def _trial_pace(planned: Sequence[RunSpec], jobs: int, preparing: Stages | None) -> float | None:
    """Return the seconds that a run takes, measured on the campaign's first two; None if it is live.

    The second finds most of its inferences in the cache, as most runs of a campaign do.
    """
    runs = in_turn(planned)
    if runs[0].settings.live:
        return None
    prepare_runs(runs[:1], preparing)
    if preparing is not None:
        preparing("Timing two runs", 0, 0)
    with TemporaryDirectory(prefix="sunset-") as folder:
        begun_s = perf_counter()
        for number, run_spec in enumerate(runs[:2]):
            run(run_spec, Path(folder, str(number)))
        return (perf_counter() - begun_s) / len(runs[:2]) / min(jobs, len(runs))


def _pace(folder: Path) -> float | None:
    """Return how many seconds there were between two runs of a campaign; None if its files were copied."""
    times = sorted(file.stat().st_mtime for file in folder.rglob(RUN_FILE))
    gaps = [later - earlier for earlier, later in pairwise(times)]
    usual = median(gaps) if gaps else 0.0
    working = [gap for gap in gaps if gap <= _PAUSE * usual]
    return sum(working) / len(working) if usual > _MOMENT_S else None
