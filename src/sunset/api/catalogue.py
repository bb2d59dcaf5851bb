"""What there is to choose from, and what is prepared and measured without a managing system."""

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

from sunset import data, experiments
from sunset.api.options import (
    Extensions,
    Options,
    as_path,
    check_progress,
    chosen_flights,
    count_of,
    extended,
    number_of,
    settings_of,
    whole_of,
)
from sunset.calibration import FlightThresholds, fit_to_flight, flight_thresholds
from sunset.data import (
    DEFAULT_FLIGHT,
    RENDERING,
    BagStatistics,
    FlightPlan,
    default_flight,
    flight_bag,
    flight_bags,
    read_bag,
    write_bag,
)
from sunset.errors import InvalidInputError
from sunset.evaluation import entropy_figure
from sunset.experiments import RunSpec, Settings, inference_file
from sunset.figures import check_figure
from sunset.flights import parse_flights
from sunset.managing import MANAGERS, ManagingSystem
from sunset.metrics import Samples
from sunset.perception import Model, find_device, load_model
from sunset.perception import list_models as installed_models
from sunset.processes.workers import Progress, Stages
from sunset.scenarios import load_scenario, load_suite, suite_names
from sunset.system import ENTROPY_SIGNAL, Fault, current_system
from sunset.texts import shown

if TYPE_CHECKING:
    from sunset.training.curves import Curves
    from sunset.training.tables import IouTables


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


def calibrate_model(
    model: str | Path | Model,
    bag: str | Path | None = None,
    *,
    out: str | Path | None = None,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Callable[..., None] | None = None,
    extensions: Extensions = (),
) -> Model:
    """Set a model's temperatures and thresholds, as `sunset models calibrate` does, and return it.

    Args:
        model: its name or folder, or what `load_model` returned.
        bag: with the frames to go by; flights over a held-out town if it is None.
        out: a new folder for the calibrated model; the model's own is changed if it is None.
        jobs: worker processes; one a core if None.
        device: what networks run on: `cpu`, `cuda` or `auto`.
        progress: called with (what is done, how much of it, how much in all).
        extensions: whose faults are looked at, too.

    Raises:
        SunsetError: the model or the bag is not usable, or the result cannot be written.
    """
    from sunset.training.recalibrate import calibrate_model as calibrate  # noqa: PLC0415  takes long to import
    from sunset.training.recalibrate import check_target, frames_of_bag, validation_flight  # noqa: PLC0415

    check_progress(progress)
    loaded, target = _loaded(model), None if out is None else as_path(out, "model's folder")
    check_target(loaded, target)
    device, jobs = find_device(device), count_of(jobs, "jobs")
    size = (loaded.card.height, loaded.card.width)
    if bag is None:
        frames = validation_flight(size, jobs=jobs, progress=progress)
        source = "flights over town 7"
    else:
        path = as_path(bag, "bag")
        frames = frames_of_bag(path, size)
        source = f"the bag {os.fsencode(path.resolve().name).decode('utf-8', 'replace')}"  # as the card can hold it
    with extended(extensions):
        return calibrate(loaded, frames, target, source=source, jobs=jobs, device=device, progress=progress)


def measure_curves(
    model: str | Path | Model,
    bag: str | Path | None = None,
    *,
    every: int = 1,
    strengths: Mapping[str, float] | None = None,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
    rendering: Progress | None = None,
    extensions: Extensions = (),
) -> "Curves":
    """Measure a model by fault and strength, as `sunset models curves` does.

    Args:
        model: its name or folder, or what `load_model` returned.
        bag: with the frames; the default flight in the model's size if it is None.
        every: of so many groups of five consecutive frames, one is looked at.
        strengths: by fault, those to measure at in place of the suites'.
        jobs: worker processes; one a core if None.
        device: what networks run on: `cpu`, `cuda` or `auto`.
        progress: called with (frames done, frames in all).
        rendering: called likewise while the flight is rendered, once.
        extensions: whose faults are measured, too.

    Raises:
        SunsetError: the model or the bag is not usable, or there is no such fault or strength.
    """
    from sunset.training.curves import measure_curves as measure  # noqa: PLC0415  takes long to import

    check_progress(progress)
    check_progress(rendering)
    loaded, device, jobs = _loaded(model), find_device(device), count_of(jobs, "jobs")
    groups = count_of(every, "groups of frames")
    with extended(extensions):
        if bag is None:
            plan = replace(DEFAULT_FLIGHT, size=(loaded.card.height, loaded.card.width))
            path = flight_bag(plan, progress=rendering, jobs=jobs)
        else:
            path = as_path(bag, "bag")
        with read_bag(path, size=(loaded.card.height, loaded.card.width)) as reader:
            fitted, _ = fit_to_flight(loaded, reader, device=device, cache=_cache(device), jobs=jobs)
        return measure(
            fitted,
            path,
            every=groups or 1,
            strengths=None if strengths is None else _strengths_of(strengths),
            jobs=jobs,
            device=device,
            progress=progress,
        )


def measure_flights(
    model: str | Path | Model = "lite",
    flights: str | Path | list[str | Path] | tuple[str | Path, ...] = "panel",
    *,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Stages | None = None,
    extensions: Extensions = (),
) -> dict[str, FlightThresholds]:
    """Return the thresholds of a model on flights and how well they do, as `sunset models flights` prints them.

    They are found when a flight is first used with the model, and kept in the user's cache folder.

    Args:
        model: its name or folder, or what `load_model` returned.
        flights: as of `bench`.
        jobs: worker processes; one a core if None.
        device: what networks run on: `cpu`, `cuda` or `auto`.
        progress: called with (what is done, frames done, frames in all).
        extensions: whose faults are looked at, too.

    Returns:
        The flights' names → the thresholds of runs there. On the default flight they are those of the model's card.

    Raises:
        SunsetError: the model or a flight is not usable.
    """
    check_progress(progress)
    loaded, device, jobs = _loaded(model), find_device(device), count_of(jobs, "jobs")
    chosen = parse_flights(chosen_flights(flights))
    with extended(extensions):
        plans = [FlightPlan.of(one, DEFAULT_FLIGHT.frames) for one in chosen if one.bag is None]
        rendering = None if progress is None else partial(progress, RENDERING)
        kept = iter(flight_bags(plans, progress=rendering, jobs=jobs))
        paths = [next(kept) if one.bag is None else one.bag for one in chosen]
        size = (loaded.card.height, loaded.card.width)
        found = {}
        for number, (flight, path) in enumerate(zip(chosen, paths, strict=True), 1):
            what = f"Measuring the flight {flight.name} ({number} of {len(chosen)})"
            with read_bag(path, size=size) as bag:
                found[flight.name] = flight_thresholds(
                    loaded,
                    bag,
                    device=device,
                    cache=_cache(device),
                    jobs=jobs,
                    progress=None if progress is None else partial(progress, what),
                )
        return found


def measure_iou(
    models: str | Path | Model | Sequence[str | Path | Model] = (),
    *,
    frames: int | None = None,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
    rendering: Progress | None = None,
) -> "IouTables":
    """Measure models on held-out towns, as `sunset models iou` does.

    Args:
        models: one or several, each by name or folder or as `load_model` returned it; all that are installed if there
            are none.
        frames: views of each held-out town, and frames of the default flight; if None, two views of every setting, and
            the whole flight.
        jobs: worker processes; one a core if None.
        device: what networks run on: `cpu`, `cuda` or `auto`.
        progress: called with (frames done, frames in all).
        rendering: called likewise while frames are rendered, once.

    Raises:
        SunsetError: a model is not usable.
    """
    from sunset.training.tables import measure_iou as measure  # noqa: PLC0415  takes long to import

    check_progress(progress)
    check_progress(rendering)
    listed = [models] if isinstance(models, str | Path | Model) else models
    if not isinstance(listed, list | tuple):
        raise InvalidInputError(f"The models must be a list of names or folders, got {shown(models)}.")
    return measure(
        list({model.folder: model for model in map(_loaded, listed or installed_models())}.values()),
        frames=count_of(frames, "frames"),
        jobs=count_of(jobs, "jobs"),
        device=device,
        progress=progress,
        rendering=rendering,
    )


def _cache(device: str) -> Path | None:
    """Return the file of the inference cache, which is of the processor only."""
    return inference_file() if device == "cpu" else None


def _strengths_of(strengths: Mapping[str, float]) -> dict[str, float]:
    numbers = isinstance(strengths, Mapping) and {name: number_of(one) for name, one in strengths.items()}
    if not isinstance(numbers, dict) or not all(type(number) is float for number in numbers.values()):
        raise InvalidInputError(
            f"The strengths must be numbers by fault, such as {{'image_shift': 8}}, got {shown(strengths)}."
        )
    return numbers


def _loaded(model: str | Path | Model) -> Model:
    return model if isinstance(model, Model) else load_model(model)
