"""Whether a managing system gains by acting on time instead of on symptoms.

Each action is done once in a run: at a fixed moment since the managing system first saw the managed system up, for
several such moments; or at a moment that is drawn anew for every run, uniformly from the span of these. Who acts so
does nothing else (`alone`), or answers symptoms as the baseline does (`with-baseline`).

Prints, for each, the downtime and the IoU over all frames, and the paired differences to the same action at random
moments, with 95 % intervals. No two scenarios share a seed, which draws the onset. A moment
that is worth knowing would show as less downtime and more IoU than at random moments; and one that makes symptoms
unnecessary, as less downtime than the baseline's.
"""

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import sunset
from sunset.cli.progress import progress_bar
from sunset.evaluation.differences import difference
from sunset.evaluation.results import RunRow
from sunset.managing import Baseline, ManagingSystem, Symptoms
from sunset.texts.tables import aligned
from sunset_ros.seeding import generator

NODES: Final = ("camera", "sensor_fusion", "segmentation")
FIGURES: Final = MappingProxyType({"t_down_s": "t_down [s]", "iou_all": "IoU_all"})


def redeploy(manager: ManagingSystem) -> None:
    """Redeploy the nodes whose outages the suite has."""
    for node in NODES:
        manager.redeploy(node)


def restart(manager: ManagingSystem) -> None:
    """Restart the nodes whose outages the suite has."""
    for node in NODES:
        manager.restart(node)


def refocus(manager: ManagingSystem) -> None:
    """Focus the camera, and recalibrate the fusion."""
    manager.set_parameter("camera", "perform_autofocus", value=True)
    manager.set_parameter("sensor_fusion", "do_recalibration", value=True)


ACTIONS: Final[Mapping[str, Callable[[ManagingSystem], None]]] = MappingProxyType(
    {"redeploy": redeploy, "restart": restart, "refocus": refocus}
)


class ByTheClock(Baseline):
    """Acts once, at a moment of its clock."""

    def __init__(self, *, action: str, moments: tuple[float, ...], repairs: bool, **node: Any) -> None:
        self._action, self._moments, self._repairs = action, moments, repairs
        self._began = self._moment = 0.0
        super().__init__(**node)

    def adapt(self, symptoms: Symptoms) -> None:
        """Act if it is time, and answer symptoms if it does that."""
        if self._repairs:
            super().adapt(symptoms)
        now = self.get_clock().now().nanoseconds / 1e9
        self._began = self._began or now
        if not self._moment and now - self._began >= 1:
            # what was measured by then is as good as random, and the same in every process
            self._moment = float(generator(0, repr(symptoms)).uniform(self._moments[0], self._moments[-1]))
        if self._action and self._moment and now - self._began >= self._moment:
            ACTIONS[self._action](self)
            self._action = ""


def managers(actions: Sequence[str], moments: Sequence[float]) -> dict[str, Callable[..., ManagingSystem]]:
    """Return the managing systems by name: those of fixed moments, and the one of random moments."""
    spans = {f"{moment:g}": (moment,) for moment in moments} | {"random": (moments[0], moments[-1])}
    return {
        f"{action}-{how}-{when}": partial(ByTheClock, action=action, moments=span, repairs=repairs)
        for action in actions
        for how, repairs in (("alone", False), ("with-baseline", True))
        for when, span in spans.items()
    }


def print_table(rows: Sequence[RunRow], names: Sequence[str], random_one: str) -> None:
    """Print the figures of managing systems, and their differences to the one of random moments."""
    figures = {(row.manager, row.scenario, row.seed): row.metrics for row in rows if row.valid}
    runs = {(row.scenario, row.seed): row.cluster for row in rows}
    head = ["", *(text for label in FIGURES.values() for text in (label, "- random", "95 % conf."))]
    table = [head]
    for name in names:
        cells = [name]
        for figure in FIGURES:
            values = [
                [figures.get((one, *run), {}).get(figure) for run in runs] for one in (name, random_one)
            ]
            compared = difference(figure, list(zip(runs.values(), *values, strict=True)))
            found = compared.difference
            if found is None or found.low is None or found.high is None:
                raise SystemExit(f"{name}: there are too few runs for an interval.")
            interval = f"[{found.low:+.3f}, {found.high:+.3f}]"
            cells += [f"{compared.first:.3f}", f"{found.mean:+.3f}", interval]
        table.append(cells)
    print("\n".join(aligned(table)), end="\n\n")


def main() -> None:
    """Run what is not there yet, and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--out", type=Path, required=True, help="folder of the runs; what it has is not run again"
    )
    parser.add_argument("--suite", default="paper")
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--duration", type=float, default=20.0)
    parser.add_argument("--actions", default=",".join(ACTIONS))
    parser.add_argument("--moments", default="3,4,5,6,7", help="seconds since the managed system was seen up")
    parser.add_argument("--jobs", type=int)
    arguments = parser.parse_args()
    actions, moments = arguments.actions.split(","), [float(text) for text in arguments.moments.split(",")]
    made = managers(actions, moments)
    scenarios = sunset.list_scenarios(arguments.suite)
    rows: list[RunRow] = []
    with progress_bar("Scenarios") as progress:
        for number, scenario in enumerate(scenarios):
            progress(number, len(scenarios))
            results = sunset.bench(
                arguments.suite,
                {"none": "none", "baseline": "baseline", **made},
                out=arguments.out / str(number),
                scenarios=[scenario],
                references=False,
                repetitions=arguments.repetitions,
                seed=1 + number * arguments.repetitions,  # which draws the onset: another one in every run
                duration=arguments.duration,
                jobs=arguments.jobs,
            )
            rows += results.runs
    for action in actions:
        for how in ("alone", "with-baseline"):
            names = [name for name in made if name.startswith(f"{action}-{how}-")]
            print_table(rows, [*names, "none", "baseline"], names[-1])


if __name__ == "__main__":
    main()
