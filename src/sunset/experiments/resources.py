"""What a run needs besides its specification: the model, the bag, the cache of inferences."""

import hashlib
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from pathlib import Path

from sunset.data import BagReader, cache_folder, default_flight, read_bag
from sunset.errors import DataError, ModelError
from sunset.experiments.spec import RunSpec
from sunset.input_files import file_digest
from sunset.isolation import FORKING
from sunset.managing import MANAGERS
from sunset.perception import InferenceCache, Modality, Model, Segmenter, load_model
from sunset.scenarios import Scenario, with_strengths
from sunset.texts import listed
from sunset.workers import Progress


@dataclass(frozen=True)
class Resources:
    """What a run is made with, loaded and checked.

    Attributes:
        model: the model.
        segmenter: runs it.
        bag: the frames.
        bag_checksum: SHA-256 over the bag's files, in hexadecimal.
        scenario: that of the run, with the model's strengths in place of severities.
    """

    model: Model
    segmenter: Segmenter
    bag: BagReader
    bag_checksum: str
    scenario: Scenario


def prepare(spec: RunSpec, *, progress: Progress | None = None) -> Resources:
    """Load the model, open the bag, and render the default flight if it is needed and not there.

    Every network is run on a frame, unless the cache knows what it answers.

    Args:
        spec: what is to be run.
        progress: called with (frames done, frames in all) while the flight is rendered.

    Raises:
        ModelError: there is no such model, it is corrupt, lacks a network, was never calibrated, or a network fails.
        InvalidInputError: there is no such device.
        MissingExtraError: the device needs a package that is not installed.
        DataError: there is no such bag, it is corrupt, or too short.
        ScenarioError: no strength of a fault is as severe for the model as the scenario says.
        OutputError: the cache folder cannot be written.
    """
    with FORKING:
        return _prepare(spec, progress)


def _prepare(spec: RunSpec, progress: Progress | None) -> Resources:
    model = load_model(spec.settings.model)
    if missing := missing_networks(model):
        raise ModelError(
            f"The model {model.card.name!r} lacks {missing}, which a run needs, since the sensor fusion switches "
            f"between {listed([one.key for one in Modality])}: train or import a model with all three networks."
        )
    if model.card.sharpness_threshold <= 0:
        raise ModelError(
            f"The model {model.card.name!r} has no thresholds yet, without which F4 and F5 have no symptoms: "
            f"'sunset models calibrate {spec.settings.model}' gives it some."
        )
    scenario = with_strengths(spec.scenario, model.card.severities, model.card.name)
    path = spec.settings.bag if spec.settings.bag is not None else _default_flight(progress)
    bag, checksum = _reader(path, (model.card.height, model.card.width))
    timing = spec.timing
    if len(bag) < timing.frames and not spec.settings.loop:
        dropped = sum(bag.dropped.values())
        lacking = f" ({dropped} images have no partner)" if dropped else ""
        raise DataError(
            f"The bag {bag.path} holds {len(bag)} frames{lacking}; an experiment needs {timing.frames} "
            f"({timing.frames * timing.period_s - timing.duration_s:g} s of warm-up at most and {timing.duration_s:g} s "
            "that are measured): take a longer one, a shorter --duration, or --loop."
        )
    cache = _inference_cache(cache_folder()) if spec.settings.cache else None
    segmenter = Segmenter(model, device=spec.settings.device, cache=cache)
    frame = bag.frame(0)
    for modality in Modality:  # what is wrong with a network is found before the sensor fusion turns to it
        segmenter.segment(modality, frame.rgb, frame.depth)
    return Resources(model, segmenter, bag, checksum, scenario)


def own_cache(resources: Resources, spec: RunSpec, checksum: str) -> Resources:
    """Return what a run of a managing system is made with, such that it leaves nothing that others look up.

    Those that come with SUNSET write answers of networks where all runs find them. One of the user's, which may do
    anything to the process that it shares with the networks, reads there too, but writes into a file of its own.
    `checksum` is that of its files.
    """
    if not spec.settings.cache or spec.manager in MANAGERS:
        return resources
    folder = cache_folder()
    cache = InferenceCache(folder / f"inference-{checksum[:16]}.sqlite", base=_inference_cache(folder))
    return replace(resources, segmenter=Segmenter(resources.model, device=spec.settings.device, cache=cache))


def missing_networks(model: Model) -> str:
    """Return which networks a run needs and a model has not, in words; empty if it has all three."""
    lacking = [modality.key for modality in Modality if modality not in model.card.networks]
    return listed(lacking) if lacking else ""


_found_flights: dict[Path, Path] = {}


def _default_flight(progress: Progress | None) -> Path:
    """Return the default flight, rendered and verified once a process and cache folder, as long as it is there."""
    folder = cache_folder()
    if folder not in _found_flights or not _found_flights[folder].exists():
        _found_flights[folder] = default_flight(progress=progress)
    return _found_flights[folder]


def _reader(path: Path, size: tuple[int, int]) -> tuple[BagReader, str]:
    """Return a bag, read at a size (height, width), and its checksum.

    It is opened and checked once, unless its files have changed since.
    """
    files = sorted(path.iterdir()) if path.is_dir() else [path]
    states = [(file, file.stat()) for file in files if file.is_file()]
    return _opened(path, size, tuple((file, state.st_size, state.st_mtime_ns) for file, state in states))


@lru_cache(maxsize=2)
def _opened(
    path: Path, size: tuple[int, int], state: tuple[tuple[Path, int, int], ...]
) -> tuple[BagReader, str]:
    digests = b"".join(bytes.fromhex(file_digest(file)) for file, _, _ in state)
    return read_bag(path, size=size), hashlib.sha256(digests).hexdigest()


@cache
def _inference_cache(folder: Path) -> InferenceCache:
    return InferenceCache(folder / "inference.sqlite")
