"""The score of managing systems: how much of what repairing can win each of them wins."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import fsum, inf
from statistics import fmean
from typing import Final

from sunset.evaluation.differences import Experiment, Figures, ManagerDifference, differences
from sunset.evaluation.estimates import Estimate, estimate, estimate_ratio
from sunset.evaluation.results import RunRow
from sunset.evaluation.summary import estimate_figure, named_groups
from sunset.metrics import Evidence, utility_of
from sunset.recording import SCORE_REFERENCES
from sunset.system import REPAIR

LEAST_GAIN: Final = 0.02
"""Where the references differ by less in the mean of seeds, there is nothing to repair: such runs count for harm."""
PRICE_MULTIPLES: Final = (0.0, 0.5, 1.0, 2.0, 4.0)
"""The multiples of the prices at which a report gives the order."""
FIRST_FIGURES: Final = ("iou_all", "t_down_s", "needless")
"""The figures that stand beside the score."""

SCORE_METHOD: Final = (
    "Score: mean(utility - none's) / mean(oracle's - none's) over the same scenarios, flights and seeds: 0 is never "
    "repairing, 1 is knowing the faults. Utility: quality less the prices of the adaptations, in frames. A run that is "
    "invalid or missing counts as none's, or as it was if worse. Harm: mean(none's - utility) where repairing wins "
    f"less than {LEAST_GAIN}."
)
"""How scores come about, in words."""

NO_SCORE: Final = (
    "There is no score: it needs runs of none and oracle with the same scenarios, flights and seeds, by one version of "
    "each, and labels."
)
"""What stands beneath a report without scores."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreRow:
    """A managing system in a suite, on all its flights.

    Attributes:
        system: what the row is called.
        manager: the managing system.
        evidence: what it looked at.
        runs: how many there are; live, without those for which the computer was too slow.
        invalid: how many of them broke a rule.
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
    evidence: Evidence
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
        example: one of the runs, which have all but managing system, scenario, flight and seed in common.
        rows: by score; by harm, where there is nothing to repair in most runs; else by the mean utility.
        differences: between every two that looked at the same, the better first.
        orders: multiple of the prices → the rows' names by the score at these prices; empty without scores.
    """

    example: RunRow
    rows: tuple[ScoreRow, ...]
    differences: tuple[ManagerDifference, ...]
    orders: Mapping[float, tuple[str, ...]]

    @property
    def suite(self) -> str:
        """The suite's name; empty for scenarios of one's own."""
        return self.example.suite

    @property
    def has_scores(self) -> bool:
        """Whether there are any."""
        return any(row.score or row.harm for row in self.rows)

    @property
    def neighbours(self) -> tuple[ManagerDifference, ...]:
        """The differences between rows that follow one another among those that looked at the same."""
        pairs = set()
        for place, row in enumerate(self.rows):
            following = [other for other in self.rows[place + 1 :] if row.is_comparable(other)]
            pairs |= {(row.system, other.system) for other in following[:1]}
            if row.is_reference:  # it is the neighbour of both kinds
                others = [other for other in following if other.evidence != following[0].evidence]
                pairs |= {(row.system, other.system) for other in others[:1]}
        return tuple(found for found in self.differences if (found.first, found.second) in pairs)

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {
            "suite": self.suite,
            "rows": [row.to_json() for row in self.rows],
            "differences": [difference.to_json() for difference in self.differences],
            "order_by_price": {f"{multiple:g}": order for multiple, order in self.orders.items()},
        }


def is_scored(run: RunRow) -> bool:
    """Return whether a run has a part in scores: also an invalid one, unless the computer may be the reason for that.

    References must be valid.
    """
    return run.valid or (run.computer_kept_up and run.manager not in SCORE_REFERENCES)


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
    tables: dict[tuple[object, ...], dict[str, list[RunRow]]] = {}
    repairing = [run for run in runs if run.task == REPAIR]
    for name, group in named_groups(repairing, by_flight=False, name_suite=False):
        first = group[0]
        flight = replace(first.flight, bag="", name="")
        key = (first.suite, first.model, flight, first.thinking_s, first.middleware, first.version)
        tables.setdefault(key, {})[name] = group
    return [_table(systems) for systems in tables.values()]


def score_rows(systems: Mapping[str, Sequence[RunRow]]) -> tuple[ScoreRow, ...]:
    """Return the scores of managing systems, from the best to the worst.

    Args:
        systems: what the row is called → runs that can be put side by side.
    """
    return _table(systems).rows


def _table(systems: Mapping[str, Sequence[RunRow]]) -> ScoreTable:
    healthy = _healthy(systems)
    nothing, scored, others = _gains(systems, healthy)
    figures = {name: _figures(runs, healthy, nothing, {*scored, *others}) for name, runs in systems.items()}
    clusters = {run.experiment: run.cluster for runs in systems.values() for run in runs}
    rows = []
    for name, runs in systems.items():
        known = figures[name]
        shared = [key for key in known if key in scored]
        harmed = [key for key in known if key in others]
        valid = [run for run in runs if run.valid]
        outcomes = [outcome for run in valid for outcome in run.outcomes]
        counted = [run for run in runs if run.valid or run.computer_kept_up]
        rows.append(
            ScoreRow(
                system=name,
                manager=runs[0].manager,
                evidence="images" if any(run.evidence == "images" for run in runs) else "symptoms",
                runs=len(counted),
                invalid=sum(not run.valid for run in counted),
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
                unpaired=sum(run.experiment not in {*scored, *others} for run in counted),
                estimates={figure: estimate_figure(valid, figure) for figure in FIRST_FIGURES},
                faults=len(outcomes),
                cured=sum(outcome.cured is not None for outcome in outcomes),
            )
        )
    rows.sort(key=lambda row: _rank(row, figures[row.system]))
    return ScoreTable(
        example=next(iter(systems.values()))[0],
        rows=tuple(rows),
        differences=differences(
            {row.system: figures[row.system] for row in rows},
            scored,
            clusters,
            [
                (row.system, other.system)
                for place, row in enumerate(rows)
                for other in rows[place + 1 :]
                if row.is_comparable(other)
            ],
        ),
        orders={multiple: _order(systems, healthy, scored, multiple) for multiple in PRICE_MULTIPLES}
        if scored
        else {},
    )


def _healthy(systems: Mapping[str, Sequence[RunRow]]) -> Figures:
    """Return the healthy IoU of never repairing, by experiment."""
    return {
        run.experiment: iou
        for runs in systems.values()
        for run in runs
        if run.manager == SCORE_REFERENCES[0]
        and run.valid
        and (iou := run.metrics["iou_healthy"]) is not None
    }


def _gains(systems: Mapping[str, Sequence[RunRow]], healthy: Figures) -> tuple[Figures, Figures, Figures]:
    """Return what never repairing gives, and what repairing wins: where that is enough for a score, and elsewhere."""
    nothing, everything = (
        next((_utilities(runs, healthy) for runs in systems.values() if runs[0].manager == reference), {})
        for reference in SCORE_REFERENCES
    )
    gains = {key: everything[key] - nothing[key] for key in nothing if key in everything}
    of_repetitions: dict[Experiment, list[float]] = {}
    for key, gain in gains.items():
        of_repetitions.setdefault(key[:-1], []).append(gain)
    scored = {key: gain for key, gain in gains.items() if fmean(of_repetitions[key[:-1]]) >= LEAST_GAIN}
    return nothing, scored, {key: gain for key, gain in gains.items() if key not in scored}


def _figures(
    runs: Sequence[RunRow],
    healthy: Figures,
    nothing: Figures,
    expected: Collection[Experiment],
    multiple: float = 1.0,
) -> Figures:
    """Return the utility of a managing system's runs; where a run is invalid or missing, that of never repairing.

    An invalid run with a lower utility keeps it.
    """
    left_out = {run.experiment for run in runs if not is_scored(run)}
    known = dict(_utilities(runs, healthy, multiple))
    for key in nothing:
        if key in expected and key not in left_out:
            known.setdefault(key, nothing[key])
    for run in runs:  # what was done before a rule was broken counts
        value = utility(run, healthy, multiple)
        if not run.valid and run.experiment in known and value is not None:
            known[run.experiment] = min(known[run.experiment], value)
    return known


def _order(
    systems: Mapping[str, Sequence[RunRow]], healthy: Figures, scored: Figures, multiple: float
) -> tuple[str, ...]:
    """Return the names of managing systems by what they win at a multiple of the prices, the best first."""
    nothing = next(
        _utilities(runs, healthy, multiple)
        for runs in systems.values()
        if runs[0].manager == SCORE_REFERENCES[0]
    )
    won = {}
    for name, runs in systems.items():
        known = _figures(runs, healthy, nothing, scored, multiple)
        won[name] = fsum(known[key] - nothing[key] for key in scored if key in known)
    return tuple(sorted(won, key=lambda name: -won[name]))


def _utilities(runs: Sequence[RunRow], healthy: Figures, multiple: float = 1.0) -> Figures:
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
