"""What a model makes of a flight: which thresholds hold there, and how well they tell healthy frames from faulty ones.

An entropy that is high on one flight is usual on another, so that thresholds belong to a model and a flight. They are
measured when the flight is first used with the model, and kept beside the flights in the cache folder.
"""

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Annotated, Final

import msgspec
import numpy as np
from msgspec import Meta

from sunset import __version__
from sunset.calibration.conditions import Condition, CurvesPlan, plan_curves
from sunset.calibration.separation import (
    SAMPLES,
    Separation,
    Values,
    chosen_frames,
    roc_auc,
    window_means,
)
from sunset.calibration.thresholds import healthy_conditions, part_entropy, part_sharpness, unsure_faults
from sunset.data import (
    DEFAULT_FLIGHT,
    BagReader,
    bag_checksum,
    flight_place,
    flights_folder,
    read_bag,
)
from sunset.errors import DataError, OutputError
from sunset.output_files import make_folder, write_text
from sunset.perception import InferenceCache, Model, ModelCard, Segmenter, load_model
from sunset.processes.workers import Progress, spread
from sunset.schemas import convert, document_text, read_json
from sunset.seeding import generator
from sunset.system import LoadedExtension, load_extension, loaded_extensions
from sunset.texts import listed

AUC: Final = 0.95
"""The least AUC of the entropy at which a fault is told from healthy operation."""
OVER: Final = 0.02
"""The largest share of healthy windows, of each network, that the threshold lets lie over it."""
MISSED: Final = 0.05
"""The largest share of the windows with a fault that should not lie over the threshold."""
CURED: Final = 0.95
"""The least share of the windows after a fault's cure that should not lie over the threshold."""

OF_CARD: Final = "thresholds of the card"
"""The key in `made_of` of thresholds that are the card's and were not measured on the flight."""

_METHOD: Final = 1
"""Grows whenever a threshold would be another one."""
_EVERY: Final = 4
"""Of so many groups of frames one is looked at with each fault; without one, all are."""
_Share = Annotated[float, Meta(ge=0, le=1)]


class FlightThresholds(msgspec.Struct, frozen=True, kw_only=True):
    """The thresholds of a model on a flight, and how well they do. A window is five consecutive frames.

    Attributes:
        entropy_threshold: F4 holds above it.
        sharpness_threshold: F5 holds below it.
        over: network → share of the windows without a fault whose entropy is over the threshold.
        auc: fault → chance that a window's entropy with it exceeds one without a fault.
        missed: fault → share of the windows with it whose entropy is not over the threshold.
        cured: fault → share of the windows after its cheapest cure whose entropy is not over the threshold.
        made_of: what they were measured with: checksums by name.
    """

    entropy_threshold: Annotated[float, Meta(ge=0, le=1)]
    sharpness_threshold: Annotated[float, Meta(ge=0)]
    over: dict[str, _Share]
    auc: dict[str, _Share]
    missed: dict[str, _Share]
    cured: dict[str, _Share]
    made_of: dict[str, str]

    def shortfalls(self) -> tuple[str, ...]:
        """Return in words what should be otherwise; nothing if healthy frames can be told from faulty ones."""
        return (
            *(
                f"{value:.0%} of the windows of {name} are over it"
                for name, value in self.over.items()
                if value > OVER
            ),
            *(f"the AUC of {fault} is {value:.2f}" for fault, value in self.auc.items() if value < AUC),
            *(
                f"{value:.0%} of the windows with {fault} are not over it"
                for fault, value in self.missed.items()
                if value > MISSED
            ),
            *(
                f"{1 - value:.0%} of the windows after the cure of {fault} are over it"
                for fault, value in self.cured.items()
                if value < CURED
            ),
        )

    def warning(self, model: str) -> str:
        """Return what a reader of runs must know, in one sentence; empty if healthy frames can be told from others."""
        shortfalls = self.shortfalls()
        if not shortfalls:
            return ""
        return (
            "No threshold of the entropy tells healthy frames of this flight from all faulty ones with the model "
            f"{model}: {listed(shortfalls)}."
        )


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a process finds what it looks at, and with what it looks.

    Attributes:
        model: its folder.
        device: that the networks run on.
        bag: its path.
        cache: the file of the inference cache; None for none, and for thresholds that are not kept.
    """

    model: Path
    device: str
    bag: Path
    cache: Path | None


def fit_to_flight(
    model: Model,
    bag: BagReader,
    *,
    device: str = "cpu",
    cache: Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> tuple[Model, FlightThresholds | None]:
    """Return a model whose card has the thresholds that hold on a flight, and how well they do.

    On the default flight the card's own hold; how well they do is not measured then, and None. The arguments are those
    of `flight_thresholds`.

    Raises:
        DataError: the bag cannot be read.
        OutputError: the cache folder cannot be written.
    """
    if _is_default(model.card, bag):
        return model, None
    found = flight_thresholds(model, bag, device=device, cache=cache, jobs=jobs, progress=progress)
    card = replace(
        model.card,
        entropy_threshold=found.entropy_threshold,
        sharpness_threshold=found.sharpness_threshold,
    )
    return replace(model, card=card), found


def flight_thresholds(
    model: Model,
    bag: BagReader,
    *,
    device: str = "cpu",
    cache: Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> FlightThresholds:
    """Return the thresholds of a model on a flight, measured on first use and kept, if a cache is used.

    On the default flight they are the card's, which were chosen on flights like it. To measure them there, too, would
    change every figure that was published for this flight.

    Args:
        model: what segments.
        bag: the frames, in the model's size.
        device: what the networks run on, as a `Segmenter` takes it.
        cache: the file of the inference cache; None for none, and for thresholds that are not kept.
        jobs: processes; as many as there are processors if None. It has no influence on the result.
        progress: called with frames done and frames in all.

    Raises:
        DataError: the bag cannot be read.
        OutputError: the cache folder cannot be written.
    """
    plan = plan_curves(model.card, grid={})
    made_of = _made_of(model.card, plan, bag_checksum(bag.path), device)
    if _is_default(model.card, bag):
        made_of[OF_CARD] = f"{model.card.entropy_threshold} {model.card.sharpness_threshold}"
    name = hashlib.sha256(repr(sorted(made_of.items())).encode()).hexdigest()[:16]
    file = flights_folder() / f"thresholds-{name}.json"
    if (known := _kept(file)) is not None and known.made_of == made_of:
        return known
    place = _Place(model.folder, device, bag.path, cache)
    values = _look_at_all(place, plan, len(bag), jobs, progress)
    found = _measured(plan, model.card, values, made_of)
    if cache is None:
        return found
    try:
        make_folder(file.parent)
        write_text(file, document_text(found))
    except OutputError as error:
        raise OutputError(
            f"The thresholds of the flight cannot be kept in {file.parent}: set SUNSET_CACHE_DIR to another folder."
        ) from error
    return found


def _is_default(card: ModelCard, bag: BagReader) -> bool:
    defaults = (DEFAULT_FLIGHT, replace(DEFAULT_FLIGHT, size=(card.height, card.width)))
    return bag.path.resolve() in [flight_place(plan).resolve() for plan in defaults]


def _made_of(card: ModelCard, plan: CurvesPlan, checksum: str, device: str) -> dict[str, str]:
    """Return all that thresholds depend on."""
    networks = sorted(card.networks.items())
    return {
        "bag": checksum,
        "conditions": hashlib.sha256(repr(_conditions(plan)).encode()).hexdigest(),
        "device": device,
        "method": f"{_METHOD}",
        "version": __version__,
        "size": f"{card.width}x{card.height}",
        **{f"network {modality.key}": network.digest for modality, network in networks},
        **{f"extension {one.name}": one.checksum for one in loaded_extensions()},
    }


def _kept(file: Path) -> FlightThresholds | None:
    """Return what a file says; None if there is none, or it is damaged."""
    with suppress(DataError):
        content = read_json(file, "The file", DataError)
        return convert(content, FlightThresholds, str(file), DataError, remedy="remove it")
    return None


def _look_at_all(
    place: _Place, plan: CurvesPlan, frames: int, jobs: int | None, progress: Progress | None
) -> Values:
    """Return entropy and sharpness (frames, conditions, 2); NaN where a frame is not looked at in a condition."""
    healthy, conditions = set(healthy_conditions(plan)), _conditions(plan)
    every = _every(frames)
    sampled = set(chosen_frames(frames, every))
    few = tuple(condition if condition in healthy else None for condition in conditions)
    chosen = [(index, conditions if index in sampled else few) for index in range(frames)]
    _opened.cache_clear()  # what the paths name may have changed since this process looked before
    rows = spread(partial(_look, place, loaded_extensions()), chosen, jobs=jobs, progress=progress)
    return np.array(list(rows))


def _every(frames: int) -> int:
    """Return of how many groups of frames one is looked at with each fault."""
    return _EVERY if frames >= _EVERY * SAMPLES else 1


def _conditions(plan: CurvesPlan) -> tuple[Condition, ...]:
    """Return all conditions that thresholds depend on, each once."""
    faults = (plan.before(fault) for fault, _ in plan.points)
    return tuple(dict.fromkeys((*healthy_conditions(plan), *faults)))


def _look(
    place: _Place, extensions: Sequence[LoadedExtension], chosen: tuple[int, Sequence[Condition | None]]
) -> Values:
    """Return entropy and sharpness of one frame in each condition; the noise depends on the frame's number only."""
    for extension in extensions:
        load_extension(extension.where, checksum=extension.checksum)
    index, conditions = chosen
    segmenter, bag = _opened(place)
    frame = bag.frame(index)
    rows = []
    for condition in conditions:
        if condition is None:
            rows.append((np.nan, np.nan))
            continue
        seen = condition.seen(frame.rgb, frame.depth, generator(0, "conditions", index))
        rows.append((segmenter.segment(condition.modality, seen.bgr, seen.depth).entropy, seen.sharpness))
    return np.array(rows)


@lru_cache(maxsize=1)
def _opened(place: _Place) -> tuple[Segmenter, BagReader]:
    """Return model and bag, opened once a process."""
    model = load_model(place.model)
    cache = None if place.cache is None else InferenceCache(place.cache)
    size = (model.card.height, model.card.width)
    return Segmenter(model, device=place.device, cache=cache), read_bag(place.bag, size=size)


def _measured(plan: CurvesPlan, card: ModelCard, values: Values, made_of: dict[str, str]) -> FlightThresholds:
    """Return the thresholds, and how well they do.

    The thresholds are the model's own on the default flight, and where all frames are alike and tell nothing.
    """
    places = {condition: place for place, condition in enumerate(_conditions(plan))}
    healthy = healthy_conditions(plan)
    every = _every(len(values))

    def means(column: int, condition: Condition) -> Values:
        found = values[:, places[condition], column]
        found = found[~np.isnan(found)]
        if len(found) < SAMPLES:  # a bag that begins again and again
            found = np.resize(found, SAMPLES)
        return window_means(found, 1 if condition in healthy else every)

    entropy, sharpness = partial(means, 0), partial(means, 1)
    edges = Separation(card.entropy_threshold, 0, 0), Separation(card.sharpness_threshold, 0, 0)
    threshold = card.entropy_threshold
    if OF_CARD not in made_of:
        with suppress(DataError):
            edges = part_entropy(plan, entropy), part_sharpness(plan, sharpness)
        least = max(float(np.quantile(entropy(one), 1 - OVER, method="higher")) for one in healthy)
        threshold = max(edges[0].threshold, least)
    nominal, unsure = entropy(healthy[0]), unsure_faults(plan)
    cures = {fault: plan.after(fault, strength) for fault, strength in plan.points}
    return FlightThresholds(
        entropy_threshold=threshold,
        sharpness_threshold=edges[1].threshold,
        over={
            network.key: float((entropy(Condition(network)) > threshold).mean()) for network in plan.networks
        },
        auc={fault: roc_auc(nominal, entropy(plan.before(fault))) for fault in unsure},
        missed={fault: float((entropy(plan.before(fault)) <= threshold).mean()) for fault in unsure},
        cured={
            fault: float((entropy(cure) <= threshold).mean())
            for fault in unsure
            if (cure := cures[fault]) is not None
        },
        made_of=made_of,
    )
