"""Measurements of models: curves, thresholds on flights, and tables of IoU.

The functions raise a `SunsetError` where a model, bag or flight cannot be used.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from sunset.api.options import (
    Extensions,
    as_path,
    check_progress,
    chosen_flights,
    count_of,
    extended,
    number_of,
)
from sunset.api.training import as_model
from sunset.calibration import FlightThresholds, fit_to_flight, flight_thresholds
from sunset.data import DEFAULT_FLIGHT, RENDERING, FlightPlan, flight_bag, flight_bags, read_bag
from sunset.errors import InvalidInputError
from sunset.experiments import inference_file
from sunset.flights import FlightSpec, parse_flights
from sunset.perception import Model, find_device, list_models
from sunset.processes.workers import Progress, Stages
from sunset.texts import shown

if TYPE_CHECKING:
    from sunset.training.curves import Curves
    from sunset.training.tables import IouTables


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
        model: its name or folder, or a loaded model.
        bag: with the frames; the default flight in the model's size if it is None.
        every: use a group of five consecutive frames in so many.
        strengths: by fault, in place of the suites'.
        jobs: worker processes; one a core if None.
        device: what networks run on: `cpu`, `cuda` or `auto`.
        progress: called with (frames done, frames in all).
        rendering: called likewise while the flight is rendered, once.
        extensions: of the managed system, whose faults are measured, too.
    """
    from sunset.training.curves import measure_curves as measure  # noqa: PLC0415  takes long to import

    check_progress(progress)
    check_progress(rendering)
    loaded, device, jobs = as_model(model), find_device(device), count_of(jobs, "jobs")
    groups, size = count_of(every, "groups of frames"), (loaded.card.height, loaded.card.width)
    with extended(extensions):
        path = _default_bag(size, jobs, rendering) if bag is None else as_path(bag, "bag")
        with read_bag(path, size=size) as reader:
            fitted, _ = fit_to_flight(loaded, reader, device=device, cache=_cache(device), jobs=jobs)
        chosen = _strengths_of(strengths)
        return measure(
            fitted, path, every=groups or 1, strengths=chosen, jobs=jobs, device=device, progress=progress
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
    """Return the thresholds of a model on flights and their quality, as `sunset models flights` prints them.

    They are measured when a flight is first used with the model, and kept in the user's cache folder. On the default
    flight they are the card's.

    Args:
        model: its name or folder, or a loaded model.
        flights: as in `bench`.
        jobs: worker processes; one a core if None.
        device: what networks run on: `cpu`, `cuda` or `auto`.
        progress: called with (title, frames done, frames in all).
        extensions: of the managed system, whose faults are used, too.
    """
    check_progress(progress)
    loaded, device, jobs = as_model(model), find_device(device), count_of(jobs, "jobs")
    chosen = parse_flights(chosen_flights(flights))
    size = (loaded.card.height, loaded.card.width)
    thresholds = {}
    with extended(extensions):
        for number, (flight, path) in enumerate(_bags(chosen, jobs, progress).items(), 1):
            title = f"Measuring the flight {flight.name} ({number} of {len(chosen)})"
            with read_bag(path, size=size) as bag:
                thresholds[flight.name] = flight_thresholds(
                    loaded,
                    bag,
                    device=device,
                    cache=_cache(device),
                    jobs=jobs,
                    progress=None if progress is None else partial(progress, title),
                )
    return thresholds


def _bags(flights: Sequence[FlightSpec], jobs: int | None, progress: Stages | None) -> dict[FlightSpec, Path]:
    """Return the bags of flights, which are rendered if necessary."""
    plans = [FlightPlan.of(flight, DEFAULT_FLIGHT.frames) for flight in flights if flight.bag is None]
    rendering = None if progress is None else partial(progress, RENDERING)
    rendered = iter(flight_bags(plans, progress=rendering, jobs=jobs))
    return {flight: next(rendered) if flight.bag is None else flight.bag for flight in flights}


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
        models: a model or several, by name or folder, or loaded; all installed models by default.
        frames: views of each held-out town, and frames of the default flight; if None, two views of every setting, and
            the whole flight.
        jobs: worker processes; one a core if None.
        device: what networks run on: `cpu`, `cuda` or `auto`.
        progress: called with (frames done, frames in all).
        rendering: called likewise while frames are rendered, once.
    """
    from sunset.training.tables import measure_iou as measure  # noqa: PLC0415  takes long to import

    check_progress(progress)
    check_progress(rendering)
    listed = [models] if isinstance(models, str | Path | Model) else models
    if not isinstance(listed, list | tuple):
        raise InvalidInputError(f"The models must be a list of names or folders, got {shown(models)}.")
    return measure(
        list({model.folder: model for model in map(as_model, listed or list_models())}.values()),
        frames=count_of(frames, "frames"),
        jobs=count_of(jobs, "jobs"),
        device=device,
        progress=progress,
        rendering=rendering,
    )


def _default_bag(size: tuple[int, int], jobs: int | None, progress: Progress | None) -> Path:
    return flight_bag(replace(DEFAULT_FLIGHT, size=size), progress=progress, jobs=jobs)


def _cache(device: str) -> Path | None:
    """Return the file of the inference cache, which is for the processor only."""
    return inference_file() if device == "cpu" else None


def _strengths_of(strengths: Mapping[str, float] | None) -> dict[str, float] | None:
    if strengths is None:
        return None
    numbers = isinstance(strengths, Mapping) and {name: number_of(value) for name, value in strengths.items()}
    if not isinstance(numbers, dict) or not all(type(number) is float for number in numbers.values()):
        raise InvalidInputError(
            f"The strengths must be numbers by fault, such as {{'image_shift': 8}}, got {shown(strengths)}."
        )
    return numbers
