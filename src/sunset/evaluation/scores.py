"""The score of managing systems: the share of the possible gain of repairing that each reaches."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from math import fsum, inf
from statistics import fmean
from typing import Final, NamedTuple, TypeAlias

from sunset.evaluation.differences import Experiment, Figures, ManagerDifference, differences
from sunset.evaluation.intervals import Cluster, Estimate, estimate, estimate_ratio
from sunset.evaluation.results import RunRow
from sunset.evaluation.summary import estimate_figure, named_groups, setting_label
from sunset.metrics import utility_of
from sunset.recording import SCORE_REFERENCES, TABLE_REFERENCES
from sunset.system import REPAIR

Systems: TypeAlias = Mapping[str, Sequence[RunRow]]
"""Name of a managing system → its runs, at least one."""
LEAST_GAIN: Final = 0.02
"""The least gain of repairing, in the mean of seeds, of runs that count for the score; others count for harm."""
PRICE_MULTIPLES: Final = (0.0, 0.5, 1.0, 2.0, 4.0)
"""The multiples of the prices at which a report gives the order."""
FIRST_FIGURES: Final = ("iou_all", "t_down_s", "needless")
"""The figures that stand beside the score."""

SCORE_METHOD: Final = (
    "Score: mean(utility - none's) / mean(oracle's - none's) over the same scenarios, flights and seeds: 0 is never "
    "repairing, 1 is knowing the faults. Utility: quality, less what each adaptation costs by its kind in "
    "frames of healthy output. A run that is invalid or missing counts as none's, or as it was if worse."
)
HARM: Final = f"Harm: mean(none's - utility) over the runs in which repairing wins less than {LEAST_GAIN}."
"""The definitions of score and harm, in words."""

NO_SCORE: Final = (
    "There is no score: it needs a flight with labels, and runs of none and oracle with the same scenarios, flights "
    "and seeds, each of the two in one version."
)
"""A note for reports without scores."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreRow:
    """A managing system in a suite, on all its flights."""

    system: str  # the row's name
    manager: str
    evidence: str  # `symptoms` or `images`; `nothing` and `faults` for the references
    runs: int
    invalid: int  # of its runs
    missing: int  # runs that only other managing systems of the table have
    score: Estimate | None  # over the runs with something to repair
    harm: Estimate | None  # the utility of never repairing less its own, over the other runs
    unpaired: int  # runs without valid runs of both references, which count for neither
    estimates: Mapping[str, Estimate | None]  # of `FIRST_FIGURES`, over the valid runs
    faults: int  # in the valid runs
    cured: int

    @property
    def is_reference(self) -> bool:
        """Whether it is `none` or `oracle`, whose scores are 0 and 1."""
        return self.manager in SCORE_REFERENCES

    @property
    def is_calm(self) -> bool:
        """Whether most of its runs had nothing to repair, so that the harm says more than the score."""
        return self.harm is not None and 2 * self.harm.runs > self.runs

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        names = ("system", "manager", "evidence", "is_reference", "runs")
        return {
            **{name: getattr(self, name) for name in names},
            "runs_invalid": self.invalid,
            "runs_missing": self.missing,
            "runs_unpaired": self.unpaired,
            "score": self.score and self.score.to_json(),
            "harm": self.harm and self.harm.to_json(),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreTable:
    """The managing systems of a suite, on all its flights, from the best to the worst."""

    title: str  # the suite, with its settings if other tables have the same suite
    example: RunRow  # all runs have the same settings
    rows: tuple[ScoreRow, ...]  # by score; by harm if most runs have nothing to repair; else by mean utility
    differences: tuple[ManagerDifference, ...]  # between comparable rows, the better first
    orders: Mapping[
        float, tuple[str, ...]
    ]  # multiple of the prices → the rows' names by score at these prices

    @property
    def classes(self) -> Mapping[str, tuple[str, ...]]:
        """Evidence → the names of managing systems with this evidence and of the references, the best first."""
        evidences = {row.evidence for row in self.rows if not row.is_reference} or {"symptoms"}
        return {
            evidence: tuple(row.system for row in self.rows if row.is_reference or row.evidence == evidence)
            for evidence in sorted(evidences, reverse=True)
        }

    @property
    def neighbours(self) -> tuple[ManagerDifference, ...]:
        """The differences between successive rows with the same evidence."""
        pairs = {pair for names in self.classes.values() for pair in pairwise(names)}
        return tuple(pair for pair in self.differences if (pair.first, pair.second) in pairs)

    def orders_of(self, evidence: str) -> dict[float, tuple[str, ...]]:
        """Return multiple of the prices → the order of managing systems with the same evidence."""
        names = self.classes[evidence]
        return {
            multiple: tuple(name for name in order if name in names)
            for multiple, order in self.orders.items()
        }

    @property
    def about(self) -> dict[str, object]:
        """The common settings of its runs, as JSON values."""
        run = self.example
        return {
            "suite": run.suite,
            "model": run.model,
            "duration_s": run.flight.duration_s,
            "bag_looped": run.flight.looped,
            "middleware": run.middleware,
            "version": run.version,
        }

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {
            **self.about,
            "rows": [row.to_json() for row in self.rows],
            "differences": [difference.to_json() for difference in self.differences],
            "order_by_price": {
                evidence: {f"{multiple:g}": order for multiple, order in self.orders_of(evidence).items()}
                for evidence in self.classes
            },
        }


def utility(run: RunRow, healthy: Figures, multiple: float = 1.0) -> float | None:
    """Return a run's utility at a multiple of the prices, with the healthy IoU of `none`; None without labels."""
    whole, cost = run.metrics["iou_all"], run.metrics["cost_frames"] or 0.0
    worth = healthy.get(run.experiment, run.metrics["iou_healthy"] or 0.0)
    return None if whole is None else utility_of(whole, multiple * cost, worth, run.frames)


def score_tables(runs: Sequence[RunRow]) -> list[ScoreTable]:
    """Return a table for each suite in which managing systems repaired; models and other settings have own tables."""
    tables: dict[str, dict[str, list[RunRow]]] = {}
    repairing = [run for run in runs if run.task == REPAIR]
    for name, group in named_groups(repairing, by_flight=False, name_suite=False):
        title = group[0].suite + setting_label(group[0], repairing, by_flight=False)
        tables.setdefault(title.strip(), {})[name] = group
    return [
        score_table(title, systems)
        for title, systems in tables.items()
        # a table of the paper's reference rows alone says nothing
        if not all(
            (run.suite, run.manager) in TABLE_REFERENCES for group in systems.values() for run in group
        )
    ]


class _Measured(NamedTuple):
    """Utilities by experiment."""

    healthy: Figures  # the healthy IoU of `none`
    nothing: Figures  # the utility of `none`
    scored: Figures  # the gain of `oracle`, where it is enough for a score
    others: Figures  # the gain of `oracle` elsewhere
    systems: Mapping[str, Figures]
    clusters: Mapping[Experiment, Cluster]


def score_rows(systems: Systems) -> tuple[ScoreRow, ...]:
    """Return the scores of managing systems with comparable runs, from the best to the worst."""
    return _rows(systems, _measured(systems))


def score_table(title: str, systems: Systems) -> ScoreTable:
    """Return the table of managing systems with comparable runs; `title` names their suite."""
    measured = _measured(systems)
    rows = _rows(systems, measured)
    pairs = [
        (row.system, other.system)
        for row, other in combinations(rows, 2)
        if row.evidence == other.evidence or row.is_reference or other.is_reference
    ]
    return ScoreTable(
        title=title,
        example=next(iter(systems.values()))[0],
        rows=rows,
        differences=differences(measured.systems, measured.scored, measured.clusters, pairs),
        orders={multiple: _order(systems, measured, multiple) for multiple in PRICE_MULTIPLES}
        if measured.scored
        else {},
    )


def _measured(systems: Systems) -> _Measured:
    never, always = (
        [run for runs in systems.values() for run in runs if run.manager == reference and run.valid]
        for reference in SCORE_REFERENCES
    )
    worth = {run.experiment: run.metrics["iou_healthy"] for run in never}
    healthy = {key: iou for key, iou in worth.items() if iou is not None}
    nothing, everything = _utilities(never, healthy), _utilities(always, healthy)
    gains = {key: everything[key] - nothing[key] for key in nothing if key in everything}
    of_repetitions: dict[Experiment, list[float]] = {}
    for key, gain in gains.items():
        of_repetitions.setdefault(key[:-1], []).append(gain)
    scored = {key: gain for key, gain in gains.items() if fmean(of_repetitions[key[:-1]]) >= LEAST_GAIN}
    return _Measured(
        healthy,
        nothing,
        scored,
        {key: gain for key, gain in gains.items() if key not in scored},
        {name: _figures(runs, healthy, nothing, gains) for name, runs in systems.items()},
        {run.experiment: run.cluster for runs in systems.values() for run in runs},
    )


def _rows(systems: Systems, measured: _Measured) -> tuple[ScoreRow, ...]:
    rows = [_row(name, runs, measured) for name, runs in systems.items()]
    return tuple(sorted(rows, key=lambda row: _rank(row, measured.systems[row.system])))


def _row(name: str, runs: Sequence[RunRow], measured: _Measured) -> ScoreRow:
    _, nothing, scored, others, systems, clusters = measured
    known = systems[name]
    shared, harmed = ([key for key in known if key in of] for of in (scored, others))
    valid = [run for run in runs if run.valid]
    outcomes = [outcome for run in valid for outcome in run.outcomes]
    paired = {*scored, *others}
    return ScoreRow(
        system=name,
        manager=runs[0].manager,
        evidence=_evidence(runs),
        runs=len(runs),
        invalid=len(runs) - len(valid),
        missing=len(paired - {run.experiment for run in runs}),
        score=estimate_ratio(
            [known[key] - nothing[key] for key in shared],
            [scored[key] for key in shared],
            [clusters[key] for key in shared],
        ),
        harm=estimate([nothing[key] - known[key] for key in harmed], [clusters[key] for key in harmed]),
        unpaired=sum(run.experiment not in paired for run in runs),
        estimates={figure: estimate_figure(valid, figure) for figure in FIRST_FIGURES},
        faults=len(outcomes),
        cured=sum(outcome.cured is not None for outcome in outcomes),
    )


def _evidence(runs: Sequence[RunRow]) -> str:
    references = dict(zip(SCORE_REFERENCES, ("nothing", "faults"), strict=True))
    evidence = "images" if any(run.evidence == "images" for run in runs) else "symptoms"
    return references.get(runs[0].manager, evidence)


def _figures(
    runs: Sequence[RunRow],
    healthy: Figures,
    nothing: Figures,
    expected: Iterable[Experiment],
    multiple: float = 1.0,
) -> Figures:
    """Return a managing system's utilities, in invalid and missing runs the utility of `none`, or its own if lower."""
    known = _utilities(runs, healthy, multiple)
    for key in expected:
        known.setdefault(key, nothing[key])
    for run in runs:
        value = utility(run, healthy, multiple)
        if not run.valid and run.experiment in known and value is not None:
            known[run.experiment] = min(known[run.experiment], value)
    return known


def _order(systems: Systems, measured: _Measured, multiple: float) -> tuple[str, ...]:
    """Return the names of managing systems by their gain at a multiple of the prices, the best first."""
    gains = {}
    for name, runs in systems.items():
        known = _figures(runs, measured.healthy, measured.nothing, measured.scored, multiple)
        gains[name] = fsum(known[key] - measured.nothing[key] for key in measured.scored)
    return tuple(sorted(gains, key=lambda name: -gains[name]))


def _utilities(runs: Sequence[RunRow], healthy: Figures, multiple: float = 1.0) -> dict[Experiment, float]:
    """Return experiment → utility of valid runs; the mean over several runs of an experiment."""
    utilities: dict[Experiment, list[float]] = {}
    for run in runs:
        if run.valid and (value := utility(run, healthy, multiple)) is not None:
            utilities.setdefault(run.experiment, []).append(value)
    return {experiment: fmean(values) for experiment, values in utilities.items()}


def _rank(row: ScoreRow, figures: Figures) -> tuple[float, float]:
    """Return the key of rows' order, the best first: the score, or the harm of calm rows; then the utility."""
    mean = fmean(figures.values()) if figures else 0.0
    if row.is_calm and row.harm:
        return (row.harm.mean, -mean)
    return (-row.score.mean if row.score else inf, -mean)
