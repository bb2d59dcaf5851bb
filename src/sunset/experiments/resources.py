"""What a run needs besides its specification: the model, the bag, the cache of inferences."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from sunset.data import BagReader, cache_folder, default_flight, read_bag
from sunset.errors import DataError
from sunset.experiments.files import make_folder
from sunset.experiments.spec import RunSpec
from sunset.perception import InferenceCache, Model, Segmenter, load_model

__all__ = ["Resources", "find_resources"]


@dataclass(frozen=True)
class Resources:
    """What a run is made with, loaded and checked."""

    model: Model
    segmenter: Segmenter
    bag: BagReader


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
    bag = _reader(spec.bag if spec.bag is not None else _default_flight(progress))
    if len(bag) < spec.timing.frames:
        raise DataError(
            f"The bag {bag.path} holds {len(bag)} frames; an experiment needs {spec.timing.frames} "
            f"({spec.timing.warm_up_s:g} s of warm-up and {spec.timing.duration_s:g} s that are measured)."
        )
    cache = _inference_cache(cache_folder()) if spec.cache else None
    return Resources(model, Segmenter(model, cache=cache), bag)


_found_flights: dict[Path, Path] = {}


def _default_flight(progress: Callable[[int, int], None] | None) -> Path:
    """Return the default flight, rendered and verified once a process and cache folder."""
    folder = cache_folder()
    if folder not in _found_flights:
        _found_flights[folder] = default_flight(progress=progress)
    return _found_flights[folder]


def _reader(path: Path) -> BagReader:
    """Return an open bag; it is opened and checked once, unless its files have changed since."""
    files = sorted(path.iterdir()) if path.is_dir() else [path] if path.exists() else []
    states = [(file.name, file.stat()) for file in files]
    return _opened(path, tuple((name, state.st_size, state.st_mtime_ns) for name, state in states))


@lru_cache(maxsize=2)
def _opened(path: Path, state: tuple[tuple[str, int, int], ...]) -> BagReader:
    del state
    return read_bag(path)


@cache
def _inference_cache(folder: Path) -> InferenceCache:
    make_folder(folder)
    return InferenceCache(folder / "inference.sqlite")
