"""Whether the oracle does the best that can be done: against every plan of up to four adaptations, on 12 scenarios.

A plan is made of moves. A move is a cure of a fault of the scenario, all of its steps at once; or a setting by which
the pipeline works without a sensor while that is away, or its return to both. Each is done at most once, so long after
the fault began as one of the delays says. All combinations are run that have four adaptations at most.

Prints for each scenario how many plans there are, the utility of never repairing, of the best plan and of the oracle,
the share of what the best plan wins that the oracle wins, and the best plan. Where the best plan wins less than a score
needs, there is no share. Exits with 1 where a share is under 0.98.
"""

import argparse
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import combinations, product
from multiprocessing import get_context
from pathlib import Path
from types import MappingProxyType
from typing import Final, cast

from sunset.evaluation.scores import LEAST_GAIN
from sunset.experiments import RunSpec, Settings, Timing, run
from sunset.managing import ManagingSystem, Symptoms, register_manager
from sunset.managing.tools import request, settings_without
from sunset.recording import StoredRun
from sunset.scenarios import Scenario, load_scenario, onsets
from sunset.system import current_system, full_name
from sunset.system.vocabulary import Adaptation, AdaptationKind
from sunset.texts.tables import aligned

SCENARIOS: Final = MappingProxyType(
    {
        "camera_driver_issue": 8.0,
        "hardware_disconnect": 8.0,
        "memory_leakage+autofocus_needed": 8.0,
        "sync_issue+gpu_failure": 8.0,
        "cuda_out_of_memory+image_shift": 8.0,
        "gpu_failure+image_degradation+autofocus_needed": 8.0,
        "memory_leakage+depth_degradation": 8.0,
        "camera_driver_issue+unneeded_enhancement": 8.0,
        "depth_degradation+autofocus_needed": 8.0,
        "image_degradation+image_shift": 8.0,
        "transient/hardware_disconnect-for-2-s": 8.0,
        "cascade/driver-then-camera": 12.0,
    }
)
"""Scenario → how long is measured [s]: short, so that a repair which is late or takes long counts."""
DELAYS_S: Final = (0.05, 2.1, 4.2)
"""At once; when a fusion or segmentation is back that was redeployed at once; when a sensor is."""
MOST: Final = 4
LEAST_SHARE: Final = 0.98

Move = tuple[Adaptation, ...]


@dataclass(frozen=True)
class Step:
    """A move of a plan, and when it is done: in seconds after the measured time began."""

    time_s: float
    move: Move

    def __str__(self) -> str:
        return f"{' and '.join(map(str, self.move))} at {self.time_s:g} s"


Plan = tuple[Step, ...]


class Planned(ManagingSystem):
    """Does what it is told, when it is told.

    Attributes:
        plan: what it does.
        start_s: when the measured time begins, which a managing system does not know.
    """

    plan: Plan = ()
    start_s = 0.0

    def on_start(self) -> None:
        """Do nothing before it can tell the time."""
        self.left = list(self.plan)

    def adapt(self, symptoms: Symptoms) -> None:
        """Set an alarm for each step, at the first call."""
        del symptoms
        now_s = self.get_clock().now().nanoseconds / 1e9
        while self.left:
            step = self.left.pop()
            self.set_alarm(self.start_s + step.time_s - now_s, step.move)

    def set_alarm(self, wait_s: float, move: Move) -> None:
        """Do a move, once, in so many seconds."""

        def do() -> None:
            timer.cancel()
            for adaptation in move:
                request(self, adaptation)

        timer = self.create_timer(wait_s, do)


def moves(fault: str) -> Iterator[Move]:
    """Yield what could be done about a fault."""
    described = current_system().faults[fault]
    yield from described.cures
    topic = full_name(current_system().failures[described.failure].topic or "none")
    if topic in settings_without():
        (node, parameter), value = settings_without()[topic]
        for modality in (value, 0):
            yield (Adaptation(AdaptationKind.SET_PARAMETER, node, parameter, modality),)


def plans(scenario: Scenario, delays_s: Sequence[float]) -> list[Plan]:
    """Return all plans of a scenario, in the order of their length."""
    times: dict[Move, set[float]] = {}
    for fault, onset_s in zip(scenario.faults, onsets(scenario.faults), strict=True):
        for move in moves(fault.name):
            times.setdefault(move, set()).update(onset_s + delay_s for delay_s in delays_s)
    return [
        tuple(sorted(map(Step, chosen_s, chosen), key=lambda step: step.time_s))
        for count in range(1, min(MOST, len(times)) + 1)
        for chosen in combinations(times, count)
        if sum(map(len, chosen)) <= MOST
        for chosen_s in product(*(sorted(times[move]) for move in chosen))
    ]


def fly(name: str, manager: str, duration_s: float, folder: Path) -> StoredRun:
    """Run a scenario once."""
    settings = Settings(timing=Timing(duration_s=duration_s))
    return run(RunSpec(scenario=load_scenario(name), manager=manager, seed=1, settings=settings), folder)


def utility(stored: StoredRun) -> float:
    """Return a run's utility.

    Raises:
        RuntimeError: it does not count.
    """
    figure = stored.metrics.utility
    if not stored.record.valid or stored.record.manager_failed or figure is None:
        raise RuntimeError(stored.record.reason or stored.record.manager_failed)
    return figure


def value(name: str, duration_s: float, start_s: float, plan: Plan) -> float:
    """Return the utility of a plan."""
    Planned.plan, Planned.start_s = plan, start_s
    with tempfile.TemporaryDirectory() as folder:
        return utility(fly(name, register_manager(Planned), duration_s, Path(folder) / "run"))


def compare(pool: ProcessPoolExecutor, name: str, duration_s: float, delays_s: Sequence[float]) -> list[str]:
    """Run all plans of a scenario; return the table's row."""
    with tempfile.TemporaryDirectory() as folder:
        nothing = fly(name, "none", duration_s, Path(folder) / "none")
        oracle = utility(fly(name, "oracle", duration_s, Path(folder) / "oracle"))
    all_plans = plans(load_scenario(name), delays_s)
    values = list(
        pool.map(
            partial(value, name, duration_s, cast("int", nothing.record.start_ns) / 1e9),
            all_plans,
            chunksize=8,
        )
    )
    low = utility(nothing)
    best, plan = max(zip(values, all_plans, strict=True), key=lambda one: one[0])
    share = f"{(oracle - low) / (best - low):.3f}" if best - low >= LEAST_GAIN else "-"
    figures = [f"{one:.4f}" for one in (low, best, oracle)]
    return [name, str(len(all_plans)), *figures, share, "; ".join(map(str, plan))]


def main() -> None:
    """Search and print."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--delays", type=float, nargs="+", default=DELAYS_S)
    parser.add_argument("--scenarios", nargs="+", choices=SCENARIOS, default=list(SCENARIOS))
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    rows = []
    with ProcessPoolExecutor(arguments.jobs, mp_context=get_context("fork")) as pool:
        for name in arguments.scenarios:
            rows.append(compare(pool, name, SCENARIOS[name], arguments.delays))
            print("  ".join(rows[-1]), file=sys.stderr, flush=True)
    header = ["scenario", "plans", "none", "best", "oracle", "share", "best plan"]
    print(*aligned([header, *rows]), sep="\n")
    sys.exit(any(row[5] != "-" and float(row[5]) < LEAST_SHARE for row in rows))


if __name__ == "__main__":
    main()
