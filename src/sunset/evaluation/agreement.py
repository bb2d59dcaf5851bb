"""The agreement of live runs with the simulation, from pairs of runs with the same seed, and its report."""

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NamedTuple

from sunset.errors import InvalidInputError, RecordError
from sunset.evaluation.differences import Difference, difference
from sunset.evaluation.formats import wrapped
from sunset.evaluation.intervals import NO_INTERVAL, Cluster
from sunset.evaluation.results import FIGURES, Flight, RunRow, load_results
from sunset.metrics import RunMetrics, score
from sunset.processes.workers import Progress
from sunset.recording import read_timeline
from sunset.texts.sentences import counted
from sunset.texts.tables import aligned, table_width
from sunset_ros.texts import shorten

AGREEMENT_FORMATS: Final = ("table", "json")

TOLERANCE: Final = 0.2
"""The tolerance of the live mean, as a share of the simulation's mean."""
TOLERANCE_S: Final = 0.5
"""The tolerance of times, whatever their share [s]."""

_METHOD: Final = (
    "Differences are live − sim, of pairs with the same scenario and seed; their mean with its 95 % confidence "
    "interval from the components of variance of crossed random effects: pairs with the same degradations, and of the "
    "same seed, are alike."
)
_RULE: Final = (
    f"A figure agrees if the live mean is within {100 * TOLERANCE:g} % of the simulation's or, of a time, within "
    f"{TOLERANCE_S:g} s."
)
_COLUMNS: Final = ("figure", "sim", "live", "live − sim", "95 % interval", "pairs", "agrees")

_Key = tuple[str, str, str, int, str, str, Flight]


@dataclass(frozen=True, slots=True, kw_only=True)
class Pair:
    """An experiment, simulated and live, with figures from the recorded messages; `alike` as in `RunRow`."""

    scenario: str
    seed: int
    sim: RunMetrics
    live: RunMetrics
    alike: str = ""

    def figures(self, name: str) -> tuple[Cluster, float | None, float | None]:
        """Return its levels, and a figure live and in the simulation."""
        levels = Cluster(self.alike or self.scenario, "", self.seed)
        return (levels, getattr(self.live, name), getattr(self.sim, name))

    @property
    def failures(self) -> tuple[tuple[str, ...], ...]:
        """The failures with an episode, in the simulation and live: `F1` … `F5`, each once."""
        return tuple(tuple(sorted({each.failure for each in run.failures})) for run in (self.sim, self.live))

    @property
    def adaptations(self) -> tuple[dict[str, int], ...]:
        """The counts of executed adaptations, in the simulation and live, such as `redeploy camera` → 1."""
        names = [sorted(f"{each.kind} {each.node}" for each in run.executed) for run in (self.sim, self.live)]
        return tuple(dict(Counter(executed)) for executed in names)

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


class LeftOut(NamedTuple):
    """An experiment that is not compared, and the reason."""

    scenario: str
    seed: int
    reason: str


@dataclass(frozen=True, slots=True)
class Agreement:
    """The pairs of a managing system, with the differences live − sim of each of `FIGURES`."""

    suite: str
    manager: str
    model: str
    flight: Flight
    pairs: tuple[Pair, ...]
    left_out: tuple[LeftOut, ...]
    differences: tuple[Difference, ...]


def agrees(compared: Difference) -> bool | None:
    """Return whether the live mean is within the tolerances of the simulation's mean; None without means."""
    if compared.difference is None or compared.second is None:
        return False if compared.one_sided else None
    distance = abs(compared.difference.mean)
    is_time = compared.figure.endswith("_s")
    return distance <= TOLERANCE * abs(compared.second) or (is_time and distance <= TOLERANCE_S)


def compare(sim: Path, live: Path, *, progress: Progress | None = None) -> list[Agreement]:
    """Return the agreement of the runs below two folders, for each suite, managing system, model and flight.

    Every figure is computed from the recorded messages. Runs are paired by scenario and seed. Pairs with a missing or
    invalid run are left out, and listed. It raises as `load_results`.
    """
    simulated, others = _runs(sim), _runs(live)
    keys = list(dict.fromkeys([*simulated, *others]))
    groups: dict[tuple[str, str, str, Flight], tuple[list[Pair], list[LeftOut]]] = {}
    for done, key in enumerate(keys, 1):
        suite, scenario, manager, seed, model, _, flight = key
        pairs, left_out = groups.setdefault((suite, manager, model, flight), ([], []))
        pair = simulated.get(key), others.get(key)
        if reason := _reason(*pair):
            left_out.append(LeftOut(scenario, seed, reason))
        else:
            sim_figures, live_figures = (score(read_timeline(run.folder)) for run in pair if run)
            alike = simulated[key].alike
            pairs.append(Pair(scenario=scenario, seed=seed, sim=sim_figures, live=live_figures, alike=alike))
        if progress is not None:
            progress(done, len(keys))
    agreements = []
    for group, (pairs, left_out) in groups.items():
        compared = tuple(difference(name, [pair.figures(name) for pair in pairs]) for name in FIGURES)
        agreements.append(Agreement(*group, tuple(pairs), tuple(left_out), compared))
    return agreements


def _runs(folder: Path) -> dict[_Key, RunRow]:
    """Return the runs below a folder by experiment."""
    if not folder.is_dir():
        raise RecordError(f"There is no folder {folder}; 'sunset agree --out' makes one.")
    return {
        (row.suite, row.scenario, row.manager, row.seed, row.model, row.setting, row.flight): row
        for row in load_results(folder)
    }


def _reason(sim: RunRow | None, live: RunRow | None) -> str:
    """Return why two runs are not compared; empty if they are."""
    reasons = []
    for where, run in (("simulated", sim), ("live", live)):
        if run is None:
            reasons.append(f"there is no {where} run")
        elif not run.valid:
            reasons.append(f"the {where} run is invalid: {shorten(run.reason) or 'no reason given'}")
    return "; ".join(reasons)


def format_agreement(agreements: Sequence[Agreement], form: str = "table") -> str:
    """Return the agreement report in one of `AGREEMENT_FORMATS`.

    Raises:
        InvalidInputError: the format is unknown.
    """
    match form:
        case "table":
            several = len({agreement.flight.bag for agreement in agreements}) > 1
            parts = ["\n".join([*_text(agreement, bag=several), ""]) for agreement in agreements]
            estimates = [compared.difference for each in agreements for compared in each.differences]
            lacking = any(estimate and estimate.lacks_interval for estimate in estimates)
            notes = (_METHOD, *((NO_INTERVAL,) if lacking else ()), _RULE)
            return "\n".join([*parts, *map(wrapped, notes)]) + "\n"
        case "json":
            content = {"rows": [*map(_json, agreements)], "method": _METHOD, "rule": _RULE}
            return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    known = " or ".join(AGREEMENT_FORMATS)
    raise InvalidInputError(f"The format of an agreement report must be {known}, got {form!r}.")


def _text(agreement: Agreement, *, bag: bool) -> Iterator[str]:
    """Yield the lines about a managing system."""
    pairs = agreement.pairs
    model = f"{agreement.model}{agreement.flight.label(bag=bag)}"
    yield (
        f"{agreement.manager} on {agreement.suite or 'scenarios of no suite'}, model {model}: "
        f"{counted(len(pairs), 'pair')}, {len(agreement.left_out)} left out"
    )
    yield ""
    if pairs:
        rows = [_COLUMNS, *map(_cells, agreement.differences)]
        head, *lines = aligned(rows, left=(0, len(_COLUMNS) - 1))
        yield from (head, "─" * table_width(rows), *lines, "")
        yield from (
            f"Only one of the two runs has {compared.figure} in {counted(compared.one_sided, 'more pair')}."
            for compared in agreement.differences
            if compared.one_sided
        )
        failures, adaptations = (
            _share(pairs, [pair for pair in pairs if not getattr(pair, same)])
            for same in ("same_failures", "same_adaptations")
        )
        yield f"The same failures appeared in {failures}."
        yield f"The same adaptations were executed in {adaptations}."
        if differing := [line for pair in pairs for line in _differing(pair)]:
            yield from ("Where they differ (sim → live):", *differing)
    if agreement.left_out:
        yield "Left out:"
        yield from (_item(run, run.reason) for run in agreement.left_out)


def _differing(pair: Pair) -> Iterator[str]:
    """Yield the lines about a pair that differs in its failures or adaptations."""
    if not pair.same_failures:
        sim, live = (" ".join(failures) or "none" for failures in pair.failures)
        yield _item(pair, f"failures {sim} → {live}")
    if not pair.same_adaptations:
        before, after = pair.adaptations
        changes = [(name, before.get(name, 0), after.get(name, 0)) for name in sorted(before | after)]
        yield _item(pair, ", ".join(f"{name} {a} → {b}" for name, a, b in changes if a != b))


def _item(run: Pair | LeftOut, text: str) -> str:
    return wrapped(f"  {run.scenario}, seed {run.seed}: {text}", "    ")


def _cells(compared: Difference) -> tuple[str, ...]:
    verdict = {True: "yes", False: "no", None: "N/A"}[agrees(compared)]
    estimate = compared.difference
    if estimate is None:
        return (compared.figure, "N/A", "N/A", "N/A", "", "0", verdict)
    interval = "[{:+.3f}, {:+.3f}]".format(*estimate.interval) if estimate.interval else ""
    means = (f"{compared.second:.3f}", f"{compared.first:.3f}", f"{estimate.mean:+.3f}")
    return (compared.figure, *means, interval, str(compared.pairs), verdict)


def _share(pairs: Sequence[Pair], broken: Sequence[Pair]) -> str:
    """Return in how many pairs, and in all pairs of how many scenarios, a condition holds."""
    every, others = ({pair.scenario for pair in each} for each in (pairs, broken))
    return (
        f"{len(pairs) - len(broken)} of {counted(len(pairs), 'pair')}, "
        f"throughout in {len(every) - len(others)} of {counted(len(every), 'scenario')}"
    )


def _json(agreement: Agreement) -> dict[str, object]:
    return {
        "manager": agreement.manager,
        "suite": agreement.suite,
        "model": agreement.model,
        **agreement.flight.to_json(),
        "pairs": len(agreement.pairs),
        "figures": {
            compared.figure: {
                "sim": compared.second,
                "live": compared.first,
                "difference": compared.difference and compared.difference.to_json(),
                "pairs": compared.pairs,
                "one_sided": compared.one_sided,
                "agrees": agrees(compared),
            }
            for compared in agreement.differences
        },
        "scenarios": [
            {
                **{
                    name: getattr(pair, name)
                    for name in ("scenario", "seed", "same_failures", "same_adaptations")
                },
                "failures": dict(zip(("sim", "live"), pair.failures, strict=True)),
                "adaptations": dict(zip(("sim", "live"), pair.adaptations, strict=True)),
            }
            for pair in agreement.pairs
        ],
        "left_out": [run._asdict() for run in agreement.left_out],
    }
