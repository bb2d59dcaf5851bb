"""Whether live runs tell what the simulation tells: the same seeds run in both, compared in pairs."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from sunset.errors import RecordError
from sunset.evaluation.intervals import Cluster
from sunset.evaluation.paired import Difference, difference
from sunset.evaluation.results import FIGURES, Flight, RunRow, load_results
from sunset.metrics import RunMetrics, score
from sunset.processes.workers import Progress
from sunset.recording import read_timeline
from sunset.texts import shorten

TOLERANCE: Final = 0.2
"""By this share of the simulation's mean the live mean may differ."""

TOLERANCE_S: Final = 0.5
"""By so much it may differ where it is a time, whatever its share [s]."""

_Key = tuple[str, str, str, int, str, str, Flight]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """One experiment, simulated and live, with the figures that were computed from the recorded messages.

    Attributes:
        alike: the degradations by which runs are clustered, as of `RunRow`.
    """

    scenario: str
    seed: int
    sim: RunMetrics
    live: RunMetrics
    alike: str = ""

    @property
    def failures(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The failures that had an episode, in the simulation and live: `F1` … `F5`, each once."""
        sim, live = (tuple(sorted({one.failure for one in run.failures})) for run in (self.sim, self.live))
        return sim, live

    @property
    def adaptations(self) -> tuple[dict[str, int], dict[str, int]]:
        """How often which adaptation was executed, in the simulation and live: `redeploy camera` → 1."""
        sim, live = (
            Counter(f"{one.kind} {one.node}" for one in run.executed) for run in (self.sim, self.live)
        )
        return dict(sorted(sim.items())), dict(sorted(live.items()))

    @property
    def same_failures(self) -> bool:
        """Whether the same failures appeared, however often."""
        sim, live = self.failures
        return sim == live

    @property
    def same_adaptations(self) -> bool:
        """Whether the same adaptations of the same nodes were executed, each as often, in whatever order."""
        sim, live = self.adaptations
        return sim == live


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """An experiment that is not compared; the reason says which of its runs does not count, and why."""

    scenario: str
    seed: int
    reason: str


def agrees(compared: Difference) -> bool | None:
    """Return whether the means, live and of the simulation, are as close as they shall be; None if there are none.

    That is within `TOLERANCE` of the simulation's mean or, where the figure is a time, within `TOLERANCE_S`.
    """
    if compared.difference is None or compared.second is None:
        return False if compared.one_sided else None
    distance = abs(compared.difference.mean)
    is_time = compared.figure.endswith("_s")
    return distance <= TOLERANCE * abs(compared.second) or (is_time and distance <= TOLERANCE_S)


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """What a managing system's pairs say together, with live − sim of each of `FIGURES`."""

    suite: str
    manager: str
    model: str
    flight: Flight
    pairs: tuple[Pair, ...]
    left_out: tuple[LeftOut, ...]
    differences: tuple[Difference, ...]


def compare(sim: Path, live: Path, *, progress: Progress | None = None) -> list[Agreement]:
    """Return how well the runs below two folders agree, one row a suite, managing system, model and flight.

    Every figure is computed from the recorded messages. Runs are paired by scenario and seed. A pair of which a
    run is missing or invalid takes part in no figure, and is listed.

    Raises:
        RecordError: there is no such folder, no run in it, or one that is damaged.
    """
    simulated, others = _runs(sim), _runs(live)
    keys = list(dict.fromkeys([*simulated, *others]))
    groups: dict[tuple[str, str, str, Flight], tuple[list[Pair], list[LeftOut]]] = {}
    for done, key in enumerate(keys, 1):
        suite, scenario, manager, seed, model, _, flight = key
        pairs, left_out = groups.setdefault((suite, manager, model, flight), ([], []))
        one, other = simulated.get(key), others.get(key)
        reason = _reason(one, other)
        if reason or one is None or other is None:
            left_out.append(LeftOut(scenario=scenario, seed=seed, reason=reason))
        else:
            sim_figures, live_figures = (score(read_timeline(run.folder)) for run in (one, other))
            pairs.append(
                Pair(scenario=scenario, seed=seed, sim=sim_figures, live=live_figures, alike=one.alike)
            )
        if progress is not None:
            progress(done, len(keys))
    return [
        Agreement(
            suite=suite,
            manager=manager,
            model=model,
            flight=flight,
            pairs=tuple(pairs),
            left_out=tuple(left_out),
            differences=tuple(_difference(name, pairs) for name in FIGURES),
        )
        for (suite, manager, model, flight), (pairs, left_out) in groups.items()
    ]


def _runs(folder: Path) -> dict[_Key, RunRow]:
    """Return the runs below a folder by what makes two of them a pair.

    Raises:
        RecordError: as `load_results`; or two of them are the same experiment.
    """
    if not folder.is_dir():
        raise RecordError(f"There is no folder {folder}; 'sunset agree --out' makes one.")
    runs: dict[_Key, RunRow] = {}
    for row in load_results(folder):
        key = (row.suite, row.scenario, row.manager, row.seed, row.model, row.setting, row.flight)
        if key in runs:
            raise RecordError(
                f"There must be one run of {row.scenario} with seed {row.seed} below {folder}, got "
                f"{runs[key].folder} and {row.folder}, which differ."
            )
        runs[key] = row
    return runs


def _reason(sim: RunRow | None, live: RunRow | None) -> str:
    """Return why two runs are not compared; empty if they are."""
    reasons = []
    for where, run in (("simulated", sim), ("live", live)):
        if run is None:
            reasons.append(f"there is no {where} run")
        elif not run.valid:
            reasons.append(f"the {where} run is invalid: {shorten(run.reason) or 'no reason given'}")
    return "; ".join(reasons)


def _difference(name: str, pairs: Sequence[Pair]) -> Difference:
    clusters = [Cluster(pair.alike or pair.scenario, "", pair.seed) for pair in pairs]
    figures = ((getattr(pair.live, name), getattr(pair.sim, name)) for pair in pairs)
    return difference(name, [(cluster, *both) for cluster, both in zip(clusters, figures, strict=True)])
