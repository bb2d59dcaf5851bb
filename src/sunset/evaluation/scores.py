"""The score of managing systems: how much of what repairing can win each of them wins."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import fsum, inf
from statistics import fmean
from typing import Final, NamedTuple, TypeAlias

from sunset.evaluation.differences import Experiment, Figures, ManagerDifference, differences
from sunset.evaluation.estimates import Estimate, estimate, estimate_ratio
from sunset.evaluation.intervals import Cluster
from sunset.evaluation.results import RunRow
from sunset.evaluation.summary import estimate_figure, named_groups, setting_label
from sunset.metrics import utility_of
from sunset.recording import SCORE_REFERENCES, TABLE_REFERENCES
from sunset.system import REPAIR

Systems: TypeAlias = Mapping[str, Sequence[RunRow]]
"""The runs of managing systems by name; none is empty."""
LEAST_GAIN: Final = 0.02
"""Where the references differ by less in the mean of seeds, there is nothing to repair: such runs count for harm."""
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
"""How scores and harm come about, in words."""

NO_SCORE: Final = (
    "There is no score: it needs a flight with labels, and runs of none and oracle with the same scenarios, flights "
    "and seeds, each of the two in one version."
)
"""What stands beneath a report without scores."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreRow:
    """A managing system in a suite, on all its flights.

    Attributes:
        system: what the row is called.
        manager: the managing system.
        evidence: what it looked at, in a word.
        runs: how many there are.
        invalid: how many of them are invalid.
        missing: how many others of the table have that this one has not.
        score: over the runs in which there is something to repair; None where there is none.
        harm: what utility loses against never repairing, over the others; None likewise.
        unpaired: how many have no valid counterpart of both references, and count for neither.
        estimates: figure → estimate over the valid runs.
        faults: how many there were in the valid runs.
        cured: how many of them were cured.
    """

    system: str
    manager: str
    evidence: str
    runs: int
    invalid: int
    missing: int
    score: Estimate | None
    harm: Estimate | None
    unpaired: int
    estimates: Mapping[str, Estimate | None]
    faults: int
    cured: int

    @property
    def is_reference(self) -> bool:
        """Whether it is one of the two that scores are measured between."""
        return self.manager in SCORE_REFERENCES

    @property
    def is_calm(self) -> bool:
        """Whether most of its runs had nothing to repair, so that its harm says more than its score."""
        return self.harm is not None and 2 * self.harm.runs > self.runs

    def is_comparable(self, other: "ScoreRow") -> bool:
        """Return whether both looked at the same; the references are compared with all."""
        return self.evidence == other.evidence or self.is_reference or other.is_reference

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {
            "system": self.system,
            "manager": self.manager,
            "evidence": self.evidence,
            "is_reference": self.is_reference,
            "runs": self.runs,
            "runs_invalid": self.invalid,
            "runs_missing": self.missing,
            "runs_unpaired": self.unpaired,
            "score": self.score and self.score.to_json(),
            "harm": self.harm and self.harm.to_json(),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreTable:
    """The managing systems of a suite, on all its flights, from the best to the worst.

    Attributes:
        title: the suite and, where others of the report have the same one, what tells them apart.
        example: one of the runs, which have all but managing system, scenario, flight and seed in common.
        rows: by score; by harm, where there is nothing to repair in most runs; else by the mean utility.
        differences: between every two that looked at the same, the better first.
        orders: multiple of the prices → the rows' names by the score at these prices; empty without scores.
    """

    title: str
    example: RunRow
    rows: tuple[ScoreRow, ...]
    differences: tuple[ManagerDifference, ...]
    orders: Mapping[float, tuple[str, ...]]

    @property
    def has_scores(self) -> bool:
        """Whether there are any."""
        return any(row.score or row.harm for row in self.rows)

    @property
    def classes(self) -> Mapping[str, tuple[str, ...]]:
        """What managing systems looked at → the names of those that did, and of the references, the best first."""
        found = {row.evidence for row in self.rows if not row.is_reference} or {"symptoms"}
        return {
            evidence: tuple(row.system for row in self.rows if row.is_reference or row.evidence == evidence)
            for evidence in sorted(found, reverse=True)
        }

    @property
    def neighbours(self) -> tuple[ManagerDifference, ...]:
        """The differences between rows that follow one another among those that looked at the same."""
        pairs = {pair for names in self.classes.values() for pair in pairwise(names)}
        return tuple(found for found in self.differences if (found.first, found.second) in pairs)

    def orders_of(self, evidence: str) -> dict[float, tuple[str, ...]]:
        """Return the orders of those that looked at the same, by the multiple of the prices."""
        names = self.classes[evidence]
        return {
            multiple: tuple(name for name in order if name in names)
            for multiple, order in self.orders.items()
        }

    @property
    def about(self) -> dict[str, object]:
        """What its runs have in common, as JSON values."""
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
    """Return a run's utility at a multiple of the prices; None where no frame has labels.

    Args:
        run: the run.
        healthy: the healthy IoU of never repairing, by experiment: what is done in the warm-up changes no price.
        multiple: of the prices.
    """
    whole, cost = run.metrics["iou_all"], run.metrics["cost_frames"] or 0.0
    worth = healthy.get(run.experiment, run.metrics["iou_healthy"] or 0.0)
    return None if whole is None else utility_of(whole, multiple * cost, worth, run.frames)


def score_tables(runs: Sequence[RunRow]) -> list[ScoreTable]:
    """Return a table for each suite in which managing systems repaired.

    Runs of different models, durations, middlewares, thinking times or versions of the package are never put together;
    those on different flights are, since a score is of pairs.
    """
    tables: dict[str, dict[str, list[RunRow]]] = {}
    repairing = [run for run in runs if run.task == REPAIR]
    for name, group in named_groups(repairing, by_flight=False, name_suite=False):
        title = group[0].suite + setting_label(group[0], repairing, by_flight=False)
        tables.setdefault(title.strip(), {})[name] = group
    return [
        _table(title, systems)
        for title, systems in tables.items()
        # a table of none alone that the paper's table refers to would say nothing
        if not all(
            (run.suite, run.manager) in TABLE_REFERENCES for group in systems.values() for run in group
        )
    ]


class _Measured(NamedTuple):
    """Utilities, and what they are measured against.

    Attributes:
        healthy: the healthy IoU of never repairing, by experiment.
        nothing: the utility of never repairing.
        scored: what repairing wins, where that is enough for a score.
        others: what it wins elsewhere.
        systems: the utilities of each managing system, by name.
        clusters: what each run has in common with others.
    """

    healthy: Figures
    nothing: Figures
    scored: Figures
    others: Figures
    systems: Mapping[str, Figures]
    clusters: Mapping[Experiment, Cluster]


def score_rows(systems: Systems) -> tuple[ScoreRow, ...]:
    """Return the scores of managing systems, from the best to the worst.

    Args:
        systems: what the row is called → runs that can be put side by side.
    """
    return _rows(systems, _measured(systems))


def _table(title: str, systems: Systems) -> ScoreTable:
    measured = _measured(systems)
    rows = _rows(systems, measured)
    pairs = [(row, other) for place, row in enumerate(rows) for other in rows[place + 1 :]]
    return ScoreTable(
        title=title,
        example=next(iter(systems.values()))[0],
        rows=rows,
        differences=differences(
            {row.system: measured.systems[row.system] for row in rows},
            measured.scored,
            measured.clusters,
            [(row.system, other.system) for row, other in pairs if row.is_comparable(other)],
        ),
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
    nothing, scored, others, clusters = measured.nothing, measured.scored, measured.others, measured.clusters
    rows = []
    for name, runs in systems.items():
        known = measured.systems[name]
        shared, harmed = ([key for key in known if key in of] for of in (scored, others))
        valid = [run for run in runs if run.valid]
        outcomes = [outcome for run in valid for outcome in run.outcomes]
        rows.append(
            ScoreRow(
                system=name,
                manager=runs[0].manager,
                evidence=_evidence(runs),
                runs=len(runs),
                invalid=len(runs) - len(valid),
                missing=len({*scored, *others} - {run.experiment for run in runs}),
                score=estimate_ratio(
                    [known[key] - nothing[key] for key in shared],
                    [scored[key] for key in shared],
                    [clusters[key] for key in shared],
                )
                if shared
                else None,
                harm=estimate(
                    [nothing[key] - known[key] for key in harmed], [clusters[key] for key in harmed]
                ),
                unpaired=sum(run.experiment not in {*scored, *others} for run in runs),
                estimates={figure: estimate_figure(valid, figure) for figure in FIRST_FIGURES},
                faults=len(outcomes),
                cured=sum(outcome.cured is not None for outcome in outcomes),
            )
        )
    return tuple(sorted(rows, key=lambda row: _rank(row, measured.systems[row.system])))


def _evidence(runs: Sequence[RunRow]) -> str:
    """Return what a managing system looked at: the references at nothing, and at the faults."""
    known = dict(zip(SCORE_REFERENCES, ("nothing", "faults"), strict=True))
    looked = "images" if any(run.evidence == "images" for run in runs) else "symptoms"
    return known.get(runs[0].manager, looked)


def _figures(
    runs: Sequence[RunRow],
    healthy: Figures,
    nothing: Figures,
    expected: Iterable[Experiment],
    multiple: float = 1.0,
) -> Figures:
    """Return the utility of a managing system's runs; where a run is invalid or missing, that of never repairing.

    An invalid run with a lower utility keeps it.
    """
    known = _utilities(runs, healthy, multiple)
    for key in expected:
        known.setdefault(key, nothing[key])
    for run in runs:  # what was done before a rule was broken counts
        value = utility(run, healthy, multiple)
        if not run.valid and run.experiment in known and value is not None:
            known[run.experiment] = min(known[run.experiment], value)
    return known


def _order(systems: Systems, measured: _Measured, multiple: float) -> tuple[str, ...]:
    """Return the names of managing systems by what they win at a multiple of the prices, the best first."""
    won = {}
    for name, runs in systems.items():
        known = _figures(runs, measured.healthy, measured.nothing, measured.scored, multiple)
        won[name] = fsum(known[key] - measured.nothing[key] for key in measured.scored)
    return tuple(sorted(won, key=lambda name: -won[name]))


def _utilities(runs: Sequence[RunRow], healthy: Figures, multiple: float = 1.0) -> dict[Experiment, float]:
    """Return the utility of valid runs by experiment; the mean of several that one managing system has made unlike."""
    found: dict[Experiment, list[float]] = {}
    for run in runs:
        if run.valid and (value := utility(run, healthy, multiple)) is not None:
            found.setdefault(run.experiment, []).append(value)
    return {experiment: fmean(values) for experiment, values in found.items()}


def _rank(row: ScoreRow, figures: Figures) -> tuple[float, float]:
    """Return what rows are sorted by, the best first: the score, or the harm if most runs give that; then utility."""
    mean = fmean(figures.values()) if figures else 0.0
    if row.is_calm and row.harm:
        return (row.harm.mean, -mean)
    return (-row.score.mean if row.score else inf, -mean)
