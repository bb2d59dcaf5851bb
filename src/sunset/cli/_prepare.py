"""Preparing what runs need, with progress, and saying what is to be known of their flights."""

import sys

from sunset.cli._progress import rendering_progress
from sunset.experiments import Resources, RunSpec, flight_name, prepare_all


def prepare_flight(spec: RunSpec) -> Resources:
    """Prepare a run, as `prepare_flights`."""
    return prepare_flights([spec])[0]


def prepare_flights(specs: list[RunSpec]) -> list[Resources]:
    """Prepare runs with progress on stderr, and print there what must be known of their flights, once for each."""
    with rendering_progress() as progress:
        prepared = prepare_all(specs, progress=progress)
    for spec, resources in zip(specs, prepared, strict=True):
        if resources.warning:
            print(f"{flight_name(spec)}: {resources.warning}", file=sys.stderr)
    return prepared
