"""Preparing what runs need, with progress, and warning of their flights and of missing walls."""

import sys
from collections.abc import Iterable

from sunset.cli._progress import rendering_progress
from sunset.confinement import missing_walls
from sunset.experiments import Resources, RunSpec, flight_name, prepare_all
from sunset.managing import EXTERNAL, MANAGERS


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


def warn_of_walls(managers: Iterable[str]) -> None:
    """Print on stderr which walls around managing systems this system lacks, if one of them is the user's own."""
    if any(manager not in {*MANAGERS, EXTERNAL} for manager in managers):
        for name, text in missing_walls().items():
            print(f"Managing systems run without {name} on this system: {text}.", file=sys.stderr)
