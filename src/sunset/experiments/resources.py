"""What a run needs besides its specification: the model, the bag, the cache of inferences."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from sunset.data import cache_folder, default_flight, read_bag
from sunset.errors import DataError
from sunset.experiments.files import make_folder
from sunset.experiments.spec import RunSpec
from sunset.perception import Model, load_model

__all__ = ["Resources", "find_resources"]


@dataclass(frozen=True)
class Resources:
    """What a run is made with, loaded and checked."""

    model: Model
    bag: Path
    frames: int
    """How many frames the bag holds."""
    cache_file: Path | None
    """Where results of inference are kept; None for nowhere."""


def find_resources(spec: RunSpec, *, progress: Callable[[int, int], None] | None = None) -> Resources:
    """Load the model, open the bag, and render the default flight if it is needed and not there.

    Args:
        spec: what is to be run.
        progress: called with (frames done, frames in all) while the flight is rendered.

    Raises:
        ModelError: there is no such model, or it is corrupt.
        DataError: there is no such bag, it is corrupt, or too short.
        OutputError: the cache folder cannot be written.
    """
    model = load_model(spec.model)
    bag = spec.bag if spec.bag is not None else _default_flight(progress)
    frames = _frames(bag)
    if frames < spec.timing.frames:
        raise DataError(
            f"The bag {bag} holds {frames} frames; an experiment needs {spec.timing.frames} "
            f"({spec.timing.warm_up_s:g} s of warm-up and {spec.timing.duration_s:g} s that are measured)."
        )
    cache_file = None
    if spec.cache:
        make_folder(cache_folder())
        cache_file = cache_folder() / "inference.sqlite"
    return Resources(model, bag, frames, cache_file)


_found_flights: dict[Path, Path] = {}


def _default_flight(progress: Callable[[int, int], None] | None) -> Path:
    """Return the default flight, rendered and verified once a process and cache folder."""
    folder = cache_folder()
    if folder not in _found_flights:
        _found_flights[folder] = default_flight(progress=progress)
    return _found_flights[folder]


@lru_cache(maxsize=4)
def _frames(bag: Path) -> int:
    with read_bag(bag) as reader:
        return len(reader)
