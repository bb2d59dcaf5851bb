"""Lists of what can be chosen, and flights and figures that need no managing system."""

import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Unpack

from sunset import data, experiments
from sunset.api.options import (
    Options,
    as_path,
    check_progress,
    count_of,
    extended,
    settings_of,
    whole_of,
)
from sunset.data import (
    BagStatistics,
    FlightPlan,
    default_flight,
    flight_bag,
    read_bag,
    write_bag,
)
from sunset.errors import InvalidInputError
from sunset.evaluation import entropy_figure
from sunset.experiments import RunSpec, Settings
from sunset.figures import check_figure
from sunset.managing import MANAGERS, ManagingSystem
from sunset.metrics import Samples
from sunset.perception import list_models as installed_models
from sunset.processes.workers import Progress
from sunset.scenarios import load_scenario, load_suite, suite_names
from sunset.system import ENTROPY_SIGNAL, Fault, current_system


def list_suites() -> tuple[str, ...]:
    """Return the names of the suites."""
    return suite_names()


def list_scenarios(suite: str | Path | None = None) -> tuple[str, ...]:
    """Return the names of the scenarios of a suite, or of a folder of scenario files; of all suites if it is None.

    Raises:
        ScenarioError: there is no such suite, or it is not usable.
    """
    chosen = (
        suite_names() if suite is None else (suite if isinstance(suite, str) else as_path(suite, "suite"),)
    )
    return tuple(scenario.name for one in chosen for scenario in load_suite(one))


def list_faults() -> tuple[Fault, ...]:
    """Return the catalogue of faults."""
    return tuple(current_system().faults.values())


def list_managers() -> Mapping[str, type[ManagingSystem]]:
    """Return the managing systems that come with SUNSET, by name."""
    return MANAGERS


def list_models() -> tuple[str, ...]:
    """Return the names of the segmentation models that are installed."""
    return tuple(installed_models())


def render_flight(
    out: str | Path | None = None,
    plan: FlightPlan | None = None,
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Path:
    """Render a flight over a made-up town, as `sunset data render` does, and return the bag's folder.

    It is kept in the user's cache folder, so that it is rendered once.

    Args:
        out: the folder of a new bag, which is a copy; None for the one that is kept.
        plan: of the flight; the default one if it is None.
        jobs: processes that render; as many as there are processors, at most 8, if None.
        progress: called with (frames done, frames in all).

    Raises:
        InvalidInputError: nothing can be flown as planned.
        OutputError: the bag cannot be written, or not kept.
    """
    check_progress(progress)
    chosen = FlightPlan() if plan is None else plan
    if not isinstance(chosen, FlightPlan):
        raise InvalidInputError(f"The plan of a flight must be a FlightPlan, got {chosen!r}.")
    workers = count_of(jobs, "jobs")
    if out is None:
        return flight_bag(chosen, progress=progress, jobs=workers)

    def frames() -> Iterator[data.Frame]:  # when it is sure that there can be a new bag
        with read_bag(flight_bag(chosen, progress=progress, jobs=workers)) as reader:
            yield from map(reader.frame, range(len(reader)))

    return write_bag(as_path(out, "bag's folder"), frames(), chosen.stamps_ns())


def bag_statistics(bag: str | Path | None = None, *, progress: Progress | None = None) -> BagStatistics:
    """Return what a bag holds, as `sunset data info` does; of the default flight if it is None.

    Raises:
        DataError: there is no such bag, or it is damaged.
    """
    check_progress(progress)
    path = default_flight() if bag is None else as_path(bag, "bag")
    with read_bag(path) as reader:
        return data.bag_statistics(reader, progress=progress)


def fault_figure(
    out: str | Path, *, seed: int = 1, progress: Progress | None = None, **options: Unpack[Options]
) -> Path:
    """Run without a fault and with each that shows in the entropy, and draw it, as `sunset faults figure` does.

    Args:
        out: a .png, .pdf or .svg.
        seed: of the runs.
        progress: called with (runs that are done, runs in all).
        **options: those of `sunset.Options`, as of `run`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        SunsetError: as `run`.
    """
    check_progress(progress)
    file = as_path(out, "figure's file")
    with extended(options.get("extensions", ())):
        draw_fault_figure(file, settings_of(options), whole_of(seed), progress)
    return file


def draw_fault_figure(file: Path, settings: Settings, seed: int, progress: Progress | None) -> None:
    """Run without a fault and with each that shows in the entropy, and draw it; as `fault_figure`."""
    check_figure(file)
    system = current_system()
    faults = [
        name
        for name, fault in system.faults.items()
        if system.failures[fault.failure].signal == ENTROPY_SIGNAL.name
    ]
    series, iou, threshold = {}, {}, 0.0
    with tempfile.TemporaryDirectory(prefix="sunset-") as folder:
        for done, name in enumerate(["nofault", *faults]):
            spec = RunSpec(scenario=load_scenario(name), manager="none", seed=seed, settings=settings)
            timeline = experiments.run(spec, Path(folder) / name).timeline
            label = name.replace("nofault", "no fault")
            series[label] = timeline.samples[ENTROPY_SIGNAL.name]
            iou[label] = Samples(timeline.frames.times, timeline.frames.iou)
            threshold = timeline.thresholds["entropy_threshold"]
            if progress is not None:
                progress(done + 1, len(faults) + 1)
    entropy_figure(series, threshold, file, iou=iou)
