"""The resources of runs: models, bags, and the cache."""

import hashlib
import json
import logging
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Final, cast

from sunset.calibration import fit_to_flight
from sunset.data import (
    DEFAULT_FLIGHT,
    RENDERING,
    BagReader,
    FlightPlan,
    bag_checksum,
    cache_folder,
    flight_bags,
    flight_place,
    frames_for,
    read_bag,
)
from sunset.data.bag_paths import check_bag_path
from sunset.errors import DataError, InvalidInputError, ModelError
from sunset.experiments.spec import RunSpec
from sunset.harness.confined_manager import start_server
from sunset.harness.frames import LazyFrames
from sunset.images import ImageCache, open_cache
from sunset.managing import EXTERNAL, MANAGERS, is_registered
from sunset.perception import Modality, Model, ModelCard, Segmenter, load_model
from sunset.processes.confinement.walls import missing_walls
from sunset.processes.forking import FORKING
from sunset.processes.workers import Stages
from sunset.scenarios import Scenario, with_strengths
from sunset.texts.sentences import listed

_OPEN_BAGS: Final = 16
"""How many bags are kept open: those of a panel, and some more."""

_log: Final = logging.getLogger(__name__)


@dataclass(frozen=True)
class Resources:
    """The resources of a run, loaded and checked.

    Attributes:
        model: the model; its card has the thresholds that hold on the flight.
        segmenter: runs it.
        frames: the frames that are played.
        bag_checksum: SHA-256 over the bag's files, in hexadecimal.
        scenario: the run's scenario, with the model's strengths in place of severities.
        of_flight: whether the thresholds were computed on the flight; they are the model's own if not.
        warning: a sentence of warning about the flight with this model; empty if there is none.
    """

    model: Model
    segmenter: Segmenter
    frames: LazyFrames
    bag_checksum: str
    scenario: Scenario
    of_flight: bool = False
    warning: str = ""

    @property
    def bag(self) -> BagReader:
        """The flight."""
        return self.frames.bag


def prepare(spec: RunSpec) -> Resources:
    """Prepare a single run, as `prepare_runs`."""
    return prepare_runs([spec])[0]


def prepare_runs(specs: Sequence[RunSpec], preparing: Stages | None = None) -> list[Resources]:
    """Load models, open bags, render flights and compute their thresholds, unless they are cached.

    Every network segments a frame, unless the cache has its result.

    Args:
        specs: the runs.
        preparing: called with (stage, frames done, all frames) while flights are rendered and measured. Warnings about
            the flights are logged only if it is given.

    Raises:
        ModelError: the model is missing or corrupt, lacks a network, was never calibrated, or a network fails.
        InvalidInputError: the device is unknown, or the flight is not possible.
        MissingExtraError: the device needs a package that is not installed.
        DataError: the bag is missing, corrupt or too short.
        ScenarioError: no strength of a fault is as severe for the model as the scenario says.
        OutputError: the cache folder cannot be written.
    """
    if any(not spec.settings.live and not is_registered(spec.manager) for spec in specs):
        start_server()
    with FORKING:
        models = [_usable_model(spec) for spec in specs]
        paths = _find_flights(specs, preparing)
        opened = [_open(spec, model, path) for spec, model, path in zip(specs, models, paths, strict=True)]
        total, done = sum(len(resources.bag) for resources in opened), 0
        prepared = []
        for spec, resources in zip(specs, opened, strict=True):
            prepared.append(_with_thresholds(spec, resources, preparing, done, total))
            done += len(resources.bag)
            if prepared[-1].warning and preparing is not None:
                _log.warning("%s: %s", flight_name(spec), prepared[-1].warning)
        return prepared


def warn_of_walls(specs: Sequence[RunSpec]) -> None:
    """Log which walls this system lacks, if a run has a managing system of the user's behind them."""
    if any(spec.manager not in {*MANAGERS, EXTERNAL} and not is_registered(spec.manager) for spec in specs):
        for name, reason in missing_walls().items():
            _log.warning("Managing systems run without %s on this system: %s.", name, reason)


def _usable_model(spec: RunSpec) -> Model:
    """Load the model of a run."""
    model = load_model(spec.settings.model)
    if missing := missing_networks(model):
        raise ModelError(
            f"The model {model.card.name!r} lacks {missing}, which a run needs, since the sensor fusion switches "
            f"between {listed([modality.key for modality in Modality])}: train or import a model with all three "
            "networks."
        )
    if model.card.sharpness_threshold <= 0:
        raise ModelError(
            f"The model {model.card.name!r} has no thresholds yet, without which F4 and F5 have no symptoms: "
            f"'sunset models calibrate {spec.settings.model}' gives it some."
        )
    return model


def _open(spec: RunSpec, model: Model, path: Path) -> Resources:
    scenario = with_strengths(spec.scenario, model.card.severities, model.card.name)
    cache = open_cache(cache_file()) if spec.settings.cache else None
    frames, checksum = _frames(path, (model.card.height, model.card.width), cache)
    bag, timing = frames.bag, spec.timing
    if len(bag) < timing.frames and not spec.settings.loop:
        dropped = sum(bag.dropped.values())
        lacking = f" ({dropped} images have no partner)" if dropped else ""
        raise DataError(
            f"The bag {bag.path} holds {len(bag)} frames{lacking}; an experiment needs {timing.frames} "
            f"({timing.frames * timing.period_s - timing.duration_s:g} s of warm-up at most and "
            f"{timing.duration_s:g} s that are measured): take a longer one, a shorter --duration, or --loop."
        )
    segmenter = Segmenter(model, device=spec.settings.device, cache=cache)
    frame = frames.frame(0)
    for modality in Modality:  # a broken network is noticed before the sensor fusion switches to it
        segmenter.look_up(modality, frame.rgb, frame.depth)
    return Resources(model, segmenter, frames, checksum, scenario)


def _with_thresholds(
    spec: RunSpec, resources: Resources, progress: Stages | None, before: int, total: int
) -> Resources:
    """Put the thresholds that hold on the flight into the model's card; `before` frames of `total` are measured."""

    def measuring(done: int, _: int) -> None:
        if progress is not None:
            progress("Measuring the flight", before + done, total)

    model, thresholds = fit_to_flight(
        resources.model,
        resources.bag,
        device=resources.segmenter.device,
        cache=cache_file() if spec.settings.cache else None,
        progress=measuring,
    )
    warning = "" if thresholds is None else thresholds.warning(model.card.name)
    return replace(resources, model=model, of_flight=thresholds is not None, warning=warning)


def model_checksum(card: ModelCard) -> str:
    """Return the SHA-256 of a model's card, in hexadecimal."""
    return hashlib.sha256(json.dumps(card.to_json(), sort_keys=True).encode()).hexdigest()


def missing_networks(model: Model) -> str:
    """Return which networks a run needs and a model lacks, in words; empty if it has all three."""
    lacking = [modality.key for modality in Modality if modality not in model.card.networks]
    return listed(lacking) if lacking else ""


def flight_plan(spec: RunSpec) -> FlightPlan | None:
    """Return the plan of a run's flight; None if it is a bag.

    It is as long as any seed's run of this duration needs, or as the default flight, whichever is longer. With
    `loop` it is as long as the default flight.
    """
    if spec.flight.bag is not None:
        return None
    timing, longest = spec.timing, frames_for(sys.maxsize)
    needed = 0 if spec.settings.loop else timing.frames
    if needed > longest:
        warm_up_s = needed * timing.period_s - timing.duration_s
        raise InvalidInputError(
            f"A rendered flight has at most {longest} frames; an experiment needs {needed} ({warm_up_s:g} s of warm-up "
            f"at most and {timing.duration_s:g} s that are measured): take a shorter --duration, or --loop."
        )
    return FlightPlan.of(spec.flight, frames_for(needed))


def flight_name(spec: RunSpec) -> str:
    """Return the name of a run's flight, with its length if that differs from the default flight's."""
    plan = flight_plan(spec)
    length = "" if plan is None or plan.frames == DEFAULT_FLIGHT.frames else f"-{plan.frames}frames"
    return f"{spec.flight.name}{length}"


_verified_flights: set[Path] = set()
"""The places of flights that this process has rendered or verified."""


def _find_flights(specs: Sequence[RunSpec], progress: Stages | None) -> list[Path]:
    """Return the bags of runs; missing flights are rendered, and all are verified once a process."""
    plans = [flight_plan(spec) for spec in specs]
    places = {flight_place(plan): plan for plan in plans if plan is not None}
    unknown = [place for place in places if not (place in _verified_flights and place.exists())]
    rendering = None if progress is None else partial(progress, RENDERING)
    flight_bags([places[place] for place in unknown], progress=rendering)
    _verified_flights.update(unknown)
    return [
        cast("Path", spec.flight.bag) if plan is None else flight_place(plan)
        for spec, plan in zip(specs, plans, strict=True)
    ]


def _frames(path: Path, size: tuple[int, int], cache: ImageCache | None) -> tuple[LazyFrames, str]:
    """Return a bag's frames at a size (height, width), and its checksum; a changed bag is opened again."""
    check_bag_path(path)
    checksum = bag_checksum(path)
    before = _opened.cache_info().hits
    frames = _opened(path, size, cache, checksum)
    if _opened.cache_info().hits > before:  # this process has several runs on it
        frames.keep()
    return frames, checksum


@lru_cache(maxsize=_OPEN_BAGS)
def _opened(path: Path, size: tuple[int, int], cache: ImageCache | None, _: str) -> LazyFrames:
    return LazyFrames(read_bag(path, size=size), cache)


def cache_file() -> Path:
    """Return the file of what was computed from images; it need not exist yet."""
    return cache_folder() / "images.sqlite"
