"""The agreement of live runs with the simulation, from pairs of runs with the same seed."""

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
from sunset_ros.texts import shorten

TOLERANCE: Final = 0.2
"""The tolerance of the live mean, as a share of the simulation's mean."""

TOLERANCE_S: Final = 0.5
"""The tolerance of times, whatever their share [s]."""

_Key = tuple[str, str, str, int, str, str, Flight]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """An experiment, simulated and live, with figures from the recorded messages; `alike` as of `RunRow`."""

    scenario: str
    seed: int
    sim: RunMetrics
    live: RunMetrics
    alike: str = ""

    @property
    def failures(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The failures with an episode, in the simulation and live: `F1` … `F5`, each once."""
        sim, live = (
            tuple(sorted({episode.failure for episode in run.failures})) for run in (self.sim, self.live)
        )
        return sim, live

    @property
    def adaptations(self) -> tuple[dict[str, int], dict[str, int]]:
        """The counts of executed adaptations, in the simulation and live, such as `redeploy camera` → 1."""
        sim, live = (
            Counter(sorted(f"{adaptation.kind} {adaptation.node}" for adaptation in run.executed))
            for run in (self.sim, self.live)
        )
        return dict(sim), dict(live)

    @property
    def same_failures(self) -> bool:
        """Whether the same failures appeared, however often."""
        sim, live = self.failures
        return sim == live

    @property
    def same_adaptations(self) -> bool:
        """Whether the same adaptations of the same nodes were executed, each as often, in any order."""
        sim, live = self.adaptations
        return sim == live


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """An experiment that is not compared, and the reason."""

    scenario: str
    seed: int
    reason: str


def agrees(compared: Difference) -> bool | None:
    """Return whether the live mean is within the tolerances of the simulation's mean; None without means."""
    if compared.difference is None or compared.second is None:
        return False if compared.one_sided else None
    distance = abs(compared.difference.mean)
    is_time = compared.figure.endswith("_s")
    return distance <= TOLERANCE * abs(compared.second) or (is_time and distance <= TOLERANCE_S)


@dataclass(frozen=True, slots=True, kw_only=True)
class Agreement:
    """The pairs of a managing system, with the differences live − sim of each of `FIGURES`."""

    suite: str
    manager: str
    model: str
    flight: Flight
    pairs: tuple[Pair, ...]
    left_out: tuple[LeftOut, ...]
    differences: tuple[Difference, ...]


def compare(sim: Path, live: Path, *, progress: Progress | None = None) -> list[Agreement]:
    """Return the agreement of the runs below two folders, for each suite, managing system, model and flight.

    Every figure is computed from the recorded messages. Runs are paired by scenario and seed. Pairs with a missing or
    invalid run are left out, and listed.

    Raises:
        RecordError: a folder is missing or without runs, or a run is damaged.
    """
    simulated, others = _runs(sim), _runs(live)
    keys = list(dict.fromkeys([*simulated, *others]))
    groups: dict[tuple[str, str, str, Flight], tuple[list[Pair], list[LeftOut]]] = {}
    for done, key in enumerate(keys, 1):
        suite, scenario, manager, seed, model, _, flight = key
        pairs, left_out = groups.setdefault((suite, manager, model, flight), ([], []))
        pair = simulated.get(key), others.get(key)
        if reason := _reason(*pair):
            left_out.append(LeftOut(scenario=scenario, seed=seed, reason=reason))
        else:
            sim_figures, live_figures = (score(read_timeline(run.folder)) for run in pair if run)
            alike = simulated[key].alike
            pairs.append(Pair(scenario=scenario, seed=seed, sim=sim_figures, live=live_figures, alike=alike))
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
    """Return the runs below a folder by experiment."""
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
