"""Flights: rendered, imported, looked into and measured."""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path

from sunset import data
from sunset.api.arguments import (
    Extensions,
    as_path,
    chosen_flights,
    count_of,
    extended,
    optional_path,
)
from sunset.calibration import FlightThresholds, flight_thresholds
from sunset.calibration.flight import flights_text as thresholds_text
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
from sunset.experiments import cache_file
from sunset.flights import HELD_OUT, parse_flights
from sunset.perception import Model, find_device, load_model
from sunset.processes.workers import Progress, Stages


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
        out: the folder of a new bag, which is a copy; None for the bag in the cache folder.
        plan: of the flight; the default flight's if it is None.
        jobs: processes that render; as many as there are processors, at most 8, if None.
        progress: called with (frames done, all frames).

    Raises:
        InvalidInputError: the plan is not possible.
        OutputError: the bag cannot be written, or not kept.
    """
    chosen = FlightPlan() if plan is None else plan
    if not isinstance(chosen, FlightPlan):
        raise InvalidInputError(f"The plan of a flight must be a FlightPlan, got {chosen!r}.")
    workers = count_of(jobs, "jobs")
    if out is None:
        return flight_bag(chosen, progress=progress, jobs=workers)

    def frames() -> Iterator[data.Frame]:  # rendered when it is sure that the bag can be written
        with read_bag(flight_bag(chosen, progress=progress, jobs=workers)) as reader:
            yield from map(reader.frame, range(len(reader)))

    return write_bag(as_path(out, "bag's folder"), frames(), chosen.stamps_ns())


def bag_statistics(bag: str | Path | None = None, *, progress: Progress | None = None) -> BagStatistics:
    """Return the contents of a bag, as `sunset data info` prints them; of the default flight if it is None.

    Raises:
        DataError: the bag is missing or damaged.
    """
    with read_bag(optional_path(bag, "bag") or default_flight()) as reader:
        return data.bag_statistics(reader, progress=progress)


def measure_flights(
    model: str | Path | Model = "lite",
    flights: str | Path | list[str | Path] | tuple[str | Path, ...] = "panel",
    *,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Stages | None = None,
    extensions: Extensions = (),
) -> dict[str, FlightThresholds]:
    """Return the thresholds of a model and their quality by flight, as `sunset models flights` prints them.

    They are computed once for a flight and a model, and kept in the user's cache folder. The default flight has
    the thresholds of the model's card.

    Args:
        model: its name or folder, or a model of `load_model`.
        flights: as in `bench`.
        jobs: worker processes; a process per core if None.
        device: where networks run: `cpu`, `cuda` or `auto`.
        progress: called with (stage, frames done, all frames).
        extensions: whose faults are looked at, too.

    Raises:
        SunsetError: the model or a flight is not usable.
    """
    loaded = model if isinstance(model, Model) else load_model(model)
    device, jobs = find_device(device), count_of(jobs, "jobs")
    cache = cache_file() if device == "cpu" else None
    with extended(extensions):
        chosen = parse_flights(chosen_flights(flights))
        plans = [FlightPlan.of(flight, DEFAULT_FLIGHT.frames) for flight in chosen if flight.bag is None]
        rendering = None if progress is None else partial(progress, RENDERING)
        rendered = iter(flight_bags(plans, progress=rendering, jobs=jobs))
        thresholds = {}
        for number, flight in enumerate(chosen, 1):
            stage = f"Measuring the flight {flight.name} ({number} of {len(chosen)})"
            measuring = None if progress is None else partial(progress, stage)
            path = next(rendered) if flight.bag is None else flight.bag
            with read_bag(path, size=(loaded.card.height, loaded.card.width)) as reader:
                thresholds[flight.name] = flight_thresholds(
                    loaded, reader, device=device, cache=cache, jobs=jobs, progress=measuring
                )
        return thresholds


def flights_text(model: str, thresholds: Mapping[str, FlightThresholds]) -> str:
    """Return the thresholds of a model on flights, by their names, as tables of text."""
    return thresholds_text(model, thresholds, {flight.name for flight in HELD_OUT})
