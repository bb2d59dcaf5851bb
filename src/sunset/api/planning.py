"""What a campaign would be: how many runs, how long it takes, and which differences it would detect."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from itertools import pairwise
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import perf_counter
from types import MappingProxyType
from typing import Final

from sunset.evaluation import load_results, score_tables
from sunset.evaluation.intervals import LEAST_LEVELS, Design, Spread
from sunset.evaluation.power import (
    DIFFERENCE,
    POWER,
    VARIANCES,
    detectable,
    power,
    reaches,
    repetitions_needed,
)
from sunset.experiments import BenchSpec, RunSpec, added_managers, in_turn, plan, prepare, run
from sunset.managing import split_label
from sunset.processes.workers import processors
from sunset.recording import RUN_FILE
from sunset.system import degradations_of
from sunset.texts import counted, listed

_PAUSE: Final = 20
"""A run that comes so many times later than the median one came after a pause."""

_MOMENT_S: Final = 0.01
"""Files that are so close together were copied."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Prospect:
    """How surely a campaign would tell two managing systems apart that differ as two others do.

    Attributes:
        pair: the two others.
        power: how probably it detects a difference of `DIFFERENCE` in utility; None where it has no interval.
        detectable: the difference that it detects with a probability of `POWER`; None likewise.
        repetitions: how many of them detect `DIFFERENCE` with that probability; None where no number does.
    """

    pair: str
    power: float | None
    detectable: float | None
    repetitions: int | None


@dataclass(frozen=True, slots=True, kw_only=True)
class CampaignForecast:
    """What a campaign would be.

    Attributes:
        runs: what they are of → how many.
        design: over what they are spread, where every scenario is run on the same flights; otherwise None.
        pace_s: seconds a run takes, with as many at a time as there are jobs; None if it is not known.
        trial: whether that was measured in two trial runs, and not in an earlier campaign.
        source: where the variances are from.
        prospects: what the campaign would tell.
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
            "power": [
                {
                    "pair": prospect.pair,
                    "power": prospect.power,
                    "detectable": prospect.detectable,
                    "repetitions": prospect.repetitions,
                }
                for prospect in self.prospects
            ],
        }

    def __str__(self) -> str:
        """Return it as lines of text."""
        lines = [f"{what}: {counted(number, 'run')}" for what, number in self.runs.items()]
        lines.append(f"In all: {counted(self.total, 'run')}{_spread(self.design)}.")
        if self.pace_s is None or self.duration_s is None:
            lines.append("How long they take is not known.")
        else:
            whole = timedelta(seconds=round(self.duration_s))
            where = "two trial runs" if self.trial else "the earlier campaign"
            lines.append(f"They take about {whole}: {self.pace_s:.2g} s a run, as measured in {where}.")
        return "\n".join([*lines, *self._power()])

    def _power(self) -> list[str]:
        if self.design is None:
            return ["Which differences they detect is not known: the scenarios are on flights of their own."]
        if self.design.repetitions < LEAST_LEVELS:
            return [f"They detect no difference: fewer than {LEAST_LEVELS} repetitions have no interval."]
        where = f"on {counted(self.design.flights, 'flight')}"
        sizes = {"degradations": self.design.alike, "flights": self.design.flights}
        few = [what for what, size in sizes.items() if size < LEAST_LEVELS]
        lines = [
            (
                f"If two managing systems differ as those of a line do ({self.source}), a difference of "
                f"{DIFFERENCE:g} in utility is detected with this probability:"
            )
        ]
        for prospect in self.prospects:
            if prospect.power is None or prospect.detectable is None:
                lines.append(
                    f"  {prospect.pair}: not known {where}, since the variances are of fewer flights or degradations."
                )
                continue
            needed = (
                f"no number of repetitions {where} reaches {100 * POWER:g} %"
                if prospect.repetitions is None
                else f"{prospect.repetitions} repetitions {where} reach {100 * POWER:g} %"
            )
            lines.append(
                f"  {prospect.pair}: {100 * prospect.power:.0f} %; {needed}; this campaign detects a difference of "
                f"{prospect.detectable:.3f} with {100 * POWER:g} %"
            )
        if few:
            lines.append(
                f"This is of these {listed(few)} only. What is said of others, too, needs at least {LEAST_LEVELS}, and "
                "more runs."
            )
        return lines


def forecast(spec: BenchSpec, like: Path | None = None, *, jobs: int | None = None) -> CampaignForecast:
    """Return what a campaign would be.

    Args:
        spec: the campaign.
        like: the folder of an earlier one, from which pace and variances are taken. If it is None, two runs are done
            and timed, unless the campaign is live.
        jobs: how many runs there would be at a time; None for as many as `bench` does.

    Raises:
        RecordError: there is no such folder, no run in it, or one that is damaged.
        InvalidInputError: the campaign is not usable.
    """
    found, source = dict(VARIANCES), "baseline, reactive and oracle on the test split"
    if like is not None:
        if measured := _measured(like):
            found, source = measured, f"in {like}"
        else:
            source += f", since {like} has no two managing systems with {LEAST_LEVELS} repetitions"
    runs = plan(replace(spec, references=False))
    added = added_managers(spec)
    asked = [run for run in runs if run.manager_name not in added]
    design = _design(asked, spec.repetitions)
    return CampaignForecast(
        runs=MappingProxyType(_counts(spec, len(asked), len(runs))),
        design=design,
        pace_s=_trial_pace(runs, jobs or processors()) if like is None else _pace(like),
        trial=like is None,
        source=source,
        prospects=tuple(_prospect(pair, one, design) for pair, one in found.items()) if design else (),
    )


def _counts(spec: BenchSpec, asked: int, ranked: int) -> dict[str, int]:
    """Return what the runs of a campaign are of, and how many they are.

    Args:
        spec: the campaign.
        asked: how many are of the managing systems that it names.
        ranked: how many are of these and of those that are added for the score.
    """
    names = [label or manager for label, manager in map(split_label, spec.managers)]
    counts = {listed(names): asked}
    if added := added_managers(spec):
        counts[f"{listed(added)}, for the score"] = ranked - asked
    references = len(plan(spec)) - ranked if spec.references else 0
    return counts | ({"the paper's reference rows": references} if references else {})


def _design(runs: Sequence[RunSpec], repetitions: int) -> Design | None:
    """Return over what a campaign is spread; None where some scenarios are on flights of their own."""
    flights: dict[str, set[object]] = {}
    for one in runs:
        flights.setdefault(one.scenario.name, set()).add(one.flight)
    if len({frozenset(each) for each in flights.values()}) > 1:
        return None
    return Design(
        alike=len({_alike(run) for run in runs}),
        flights=len(next(iter(flights.values()))),
        repetitions=repetitions,
    )


def _alike(run: RunSpec) -> str:
    return degradations_of(fault.name for fault in run.scenario.faults) or run.scenario.name


def _spread(design: Design | None) -> str:
    if design is None:
        return ""
    parts = (
        counted(design.alike, "different degradation"),
        counted(design.flights, "flight"),
        counted(design.repetitions, "repetition"),
    )
    return f", over {listed(parts)}"


def _prospect(pair: str, found: Spread, design: Design) -> Prospect:
    if design.repetitions < LEAST_LEVELS or not reaches(found, design):
        return Prospect(pair=pair, power=None, detectable=None, repetitions=None)
    planned = replace(found, sizes=design)
    return Prospect(
        pair=pair,
        power=power(planned),
        detectable=detectable(planned),
        repetitions=repetitions_needed(planned),
    )


def _measured(folder: Path) -> dict[str, Spread]:
    """Return the variances of those differences between neighbours in a campaign that have an interval."""
    return {
        f"{difference.first} − {difference.second}": difference.utility.spread
        for table in score_tables(load_results(folder))
        for difference in table.neighbours
        if difference.utility and difference.utility.spread
    }


def _trial_pace(planned: Sequence[RunSpec], jobs: int) -> float | None:
    """Return the seconds that a run takes, measured on the campaign's first two; None if it is live.

    The second finds most of its inferences in the cache, as most runs of a campaign do.
    """
    runs = in_turn(planned)
    if runs[0].settings.live:
        return None
    prepare(runs[0])
    with TemporaryDirectory(prefix="sunset-") as folder:
        begun_s = perf_counter()
        for number, one in enumerate(runs[:2]):
            run(one, Path(folder, str(number)))
        return (perf_counter() - begun_s) / len(runs[:2]) / min(jobs, len(runs))


def _pace(folder: Path) -> float | None:
    """Return how many seconds there were between two runs of a campaign; None if the files do not tell."""
    times = sorted(file.stat().st_mtime for file in folder.rglob(RUN_FILE))
    gaps = [later - earlier for earlier, later in pairwise(times)]
    usual = median(gaps) if gaps else 0.0
    working = [gap for gap in gaps if gap <= _PAUSE * usual]
    return sum(working) / len(working) if usual > _MOMENT_S else None
