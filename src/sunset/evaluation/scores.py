"""The score of managing systems: how much of what repairing can win each of them wins."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from statistics import fmean
from typing import Final

from sunset.evaluation.differences import Experiment, Figures, ManagerDifference, differences
from sunset.evaluation.estimates import Estimate, estimate, estimate_ratio
from sunset.evaluation.results import RunRow
from sunset.evaluation.summary import named_groups
from sunset.recording import SCORE_REFERENCES
from sunset.system import REPAIR

LEAST_GAIN: Final = 0.02
"""Where the references differ by less in the mean of seeds, there is nothing to repair: such runs count for harm."""

SCORE_METHOD: Final = (
    "Score: mean(IoU_net - none) / mean(oracle - none) over runs with the same scenario, flight and seed; 0 is never "
    "repairing, 1 is being told the faults. IoU_net is IoU_all, in which a frame that never came counts as 0, less a "
    "frame's share for each adaptation that treats no fault. Harm: mean(none - IoU_net) over the runs in which there "
    f"is nothing to repair, oracle - none being under {LEAST_GAIN} in the mean of seeds. An invalid run of the "
    "simulation counts as that of none, or as it was if that is worse, so that breaking a rule hides no run that goes "
    "badly."
)
"""How scores come about, in words."""

NO_SCORE: Final = (
    "There is no score: it needs runs of none and oracle with the same scenarios, flights and seeds, by one version of "
    "each, and labels."
)
"""What stands beneath a report without scores."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreRow:
    """The score of a managing system.

    Attributes:
        system: what the row is called.
        runs: how many there are; live, only valid ones.
        invalid: how many of them are not valid; such a run counts as that of none, or as it was if that is worse.
        score: over those in which there is something to repair; None where there is none, or none has a counterpart.
        harm: what IoU_net loses against never repairing, over the others; None likewise.
        unpaired: how many have no valid counterpart of both references, and count for neither.
    """

    system: str
    manager: str
    runs: int
    invalid: int
    score: Estimate | None
    harm: Estimate | None
    unpaired: int

    @property
    def is_reference(self) -> bool:
        """Whether it is one of the two that scores are measured between."""
        return self.manager in SCORE_REFERENCES

    @property
    def is_calm(self) -> bool:
        """Whether most of its runs had nothing to repair, so that its harm tells more of it than its score."""
        return self.harm is not None and 2 * self.harm.runs > self.runs

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {
            "system": self.system,
            "manager": self.manager,
            "is_reference": self.is_reference,
            "runs": self.runs,
            "runs_invalid": self.invalid,
            "score": self.score and self.score.to_json(),
            "harm": self.harm and self.harm.to_json(),
            "runs_unpaired": self.unpaired,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class ScoreTable:
    """The managing systems of a suite, on all its flights, from the best to the worst.

    Attributes:
        suite: empty for scenarios of one's own.
        rows: by score; by harm, where there is nothing to repair in most runs; else by the mean of IoU_net.
        differences: between every two of them, the better first.
    """

    suite: str
    rows: tuple[ScoreRow, ...]
    differences: tuple[ManagerDifference, ...]

    @property
    def has_scores(self) -> bool:
        """Whether there are any."""
        return any(row.score or row.harm for row in self.rows)

    @property
    def runs_counted(self) -> tuple[int, ...]:
        """How many runs of each row count for its score or harm; without scores, for its differences."""
        return tuple(row.runs - row.unpaired * self.has_scores for row in self.rows)

    @property
    def neighbours(self) -> tuple[ManagerDifference, ...]:
        """The differences between rows that follow one another."""
        names = [row.system for row in self.rows]
        places = {name: place for place, name in enumerate(names)}
        return tuple(
            difference
            for difference in self.differences
            if places[difference.second] - places[difference.first] == 1
        )

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {
            "suite": self.suite,
            "rows": [row.to_json() for row in self.rows],
            "differences": [difference.to_json() for difference in self.differences],
        }


def is_scored(run: RunRow) -> bool:
    """Return whether a run has a part in scores: also an invalid one, unless the computer may be the reason for that.

    References must be valid.
    """
    return run.valid or (run.computer_kept_up and run.manager not in SCORE_REFERENCES)


def score_tables(runs: Sequence[RunRow]) -> list[ScoreTable]:
    """Return a table for each suite of which several managing systems were run to repair.

    Runs of different models, durations, middlewares, thinking times or versions of the package are never put together;
    those on different flights are, since a score is of pairs.
    """
    tables: dict[tuple[object, ...], dict[str, list[RunRow]]] = {}
    for name, group in named_groups([run for run in runs if run.task == REPAIR], by_flight=False):
        first = group[0]
        flight = replace(first.flight, bag="", name="")
        key = (first.suite, first.model, flight, first.thinking_s, first.middleware, first.version)
        scored = [run for run in group if is_scored(run)]
        if scored:
            tables.setdefault(key, {})[name] = scored
    return [_table(systems) for systems in tables.values() if len(systems) > 1]


def score_rows(systems: Mapping[str, Sequence[RunRow]]) -> tuple[ScoreRow, ...]:
    """Return the scores of managing systems, from the best to the worst.

    Args:
        systems: what the row is called → runs that have a part in scores, that can be put side by side.
    """
    nothing, scored, others = _gains(systems)
    rows, figures = [], _figures(systems, nothing)
    for name, runs in systems.items():
        known = figures[name]
        clusters = {run.experiment: run.cluster for run in runs}
        shared = [key for key in known if key in scored]
        harmed = [key for key in known if key in others]
        rows.append(
            ScoreRow(
                system=name,
                manager=runs[0].manager,
                runs=len(runs),
                invalid=sum(not run.valid for run in runs),
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
                unpaired=sum(run.experiment not in scored.keys() | others.keys() for run in runs),
            )
        )
    return tuple(sorted(rows, key=lambda row: _rank(row, figures[row.system])))


def _table(systems: Mapping[str, Sequence[RunRow]]) -> ScoreTable:
    rows, (nothing, scored, _) = score_rows(systems), _gains(systems)
    figures = _figures(systems, nothing)
    return ScoreTable(
        suite=next(iter(systems.values()))[0].suite,
        rows=rows,
        differences=differences(
            {row.system: figures[row.system] for row in rows},
            scored,
            {run.experiment: run.cluster for runs in systems.values() for run in runs},
        ),
    )


def _gains(systems: Mapping[str, Sequence[RunRow]]) -> tuple[Figures, Figures, Figures]:
    """Return what never repairing gives, and what repairing wins: where that is enough for a score, and elsewhere."""
    nothing, everything = (
        next((_iou_net(runs) for runs in systems.values() if runs[0].manager == reference), {})
        for reference in SCORE_REFERENCES
    )
    gains = {key: everything[key] - nothing[key] for key in nothing if key in everything}
    of_repetitions: dict[Experiment, list[float]] = {}
    for key, gain in gains.items():
        of_repetitions.setdefault(key[:-1], []).append(gain)
    scored = {key: gain for key, gain in gains.items() if fmean(of_repetitions[key[:-1]]) >= LEAST_GAIN}
    return nothing, scored, {key: gain for key, gain in gains.items() if key not in scored}


def _figures(systems: Mapping[str, Sequence[RunRow]], nothing: Figures) -> Mapping[str, Figures]:
    """Return IoU_net of the runs of managing systems, as their scores are computed from it.

    Args:
        systems: the runs by row.
        nothing: what never repairing gives.
    """
    figures = {}
    for name, runs in systems.items():
        known = dict(_iou_net(runs))
        for run in runs:
            if not run.valid and run.experiment in nothing:
                iou = run.metrics["iou_net"]
                least = nothing[run.experiment]
                known.setdefault(run.experiment, least if iou is None else min(iou, least))
        figures[name] = known
    return figures


def _iou_net(runs: Sequence[RunRow]) -> Figures:
    """Return IoU_net of valid runs by experiment; the mean of several that one managing system has made unlike."""
    found: dict[Experiment, list[float]] = {}
    for run in runs:
        if run.valid and (iou := run.metrics["iou_net"]) is not None:
            found.setdefault(run.experiment, []).append(iou)
    return {experiment: fmean(values) for experiment, values in found.items()}


def _rank(row: ScoreRow, figures: Figures) -> tuple[float, float]:
    """Return what rows are sorted by, the best first: the score, or the harm if most runs tell that; then IoU_net."""
    mean = fmean(figures.values()) if figures else 0.0
    if row.is_calm and row.harm:
        return (row.harm.mean, -mean)
    return (-row.score.mean if row.score else inf, -mean)
