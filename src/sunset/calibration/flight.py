"""The thresholds of a model on a flight, and how well they separate healthy from faulty frames, also as text.

An entropy that is high on one flight is usual on another; thresholds therefore belong to a model and a flight. They are
measured when a flight is first used with a model, and kept beside the flights in the cache folder.
"""

import hashlib
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Annotated, Final

import msgspec
import numpy as np
from msgspec import Meta

from sunset import __version__
from sunset.calibration.conditions import Condition, CurvesPlan, plan_curves
from sunset.calibration.thresholds import (
    Means,
    Values,
    chosen_frames,
    healthy_conditions,
    part_entropy,
    part_sharpness,
    roc_auc,
    unsure_faults,
    window_means,
)
from sunset.data import (
    DEFAULT_FLIGHT,
    BagReader,
    bag_checksum,
    flight_place,
    flights_folder,
    read_bag,
)
from sunset.errors import DataError, OutputError
from sunset.files.outputs import make_folder, write_text
from sunset.files.schemas import convert, document_text, read_json
from sunset.images import open_cache
from sunset.perception import Model, ModelCard, Segmenter, load_model
from sunset.processes.workers import Progress, spread
from sunset.system import SAMPLES, LoadedExtension, load_extension, loaded_extensions
from sunset.texts.sentences import listed
from sunset.texts.tables import aligned
from sunset_ros.seeding import generator

AUC: Final = 0.95
"""The least AUC of the entropy for a detectable fault."""
OVER: Final = 0.02
"""The largest share of each network's healthy windows above the threshold."""
MISSED: Final = 0.05
"""The largest acceptable share of windows with a fault that are not above the threshold."""
CURED: Final = 0.95
"""The least acceptable share of windows after a cure that are not above the threshold."""

OF_CARD: Final = "thresholds of the card"
"""The key in `made_of` for thresholds of the card, not of the flight."""

_METHOD: Final = 1
"""Increased whenever thresholds would change."""
_EVERY: Final = 4
"""With faults, a group of frames in so many is used; without faults, all groups."""
_Opening = Callable[[], tuple[Segmenter, BagReader]]
_Share = Annotated[float, Meta(ge=0, le=1)]


class FlightThresholds(msgspec.Struct, frozen=True, kw_only=True):
    """The thresholds of a model on a flight, and their quality. A window is five consecutive frames.

    Attributes:
        entropy_threshold: F4 holds above it.
        sharpness_threshold: F5 holds below it.
        over: network → share of the windows without a fault with an entropy above the threshold.
        auc: fault → chance that a window's entropy exceeds the entropy of a window without a fault.
        missed: fault → share of the windows with an entropy not above the threshold.
        cured: fault → share of the windows after its cheapest cure with an entropy not above the threshold.
        made_of: the checksums of everything that they depend on, by name.
    """

    entropy_threshold: Annotated[float, Meta(ge=0, le=1)]
    sharpness_threshold: Annotated[float, Meta(ge=0)]
    over: dict[str, _Share]
    auc: dict[str, _Share]
    missed: dict[str, _Share]
    cured: dict[str, _Share]
    made_of: dict[str, str]

    def shortfalls(self) -> tuple[str, ...]:
        """Return the reasons why healthy and faulty frames cannot be separated, in words."""
        over = (
            (share, f"{share:.0%} of the windows of {name} are over it") for name, share in self.over.items()
        )
        low = ((auc, f"the AUC of {fault} is {auc:.2f}") for fault, auc in self.auc.items())
        missed = (
            (share, f"{share:.0%} of the windows with {fault} are not over it")
            for fault, share in self.missed.items()
        )
        cured = (
            (share, f"{1 - share:.0%} of the windows after the cure of {fault} are over it")
            for fault, share in self.cured.items()
        )
        return (
            *(text for share, text in over if share > OVER),
            *(text for auc, text in low if auc < AUC),
            *(text for share, text in missed if share > MISSED),
            *(text for share, text in cured if share < CURED),
        )

    def warning(self, model: str) -> str:
        """Return a sentence about the shortfalls; empty without any."""
        shortfalls = self.shortfalls()
        if not shortfalls:
            return ""
        return (
            "No threshold of the entropy tells healthy frames of this flight from all faulty ones with the model "
            f"{model}: {listed(shortfalls)}."
        )


def fit_to_flight(
    model: Model,
    bag: BagReader,
    *,
    device: str = "cpu",
    cache: Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> tuple[Model, FlightThresholds | None]:
    """Return a model with the thresholds of a flight, and their quality; the arguments are as in `flight_thresholds`.

    On the default flight the card's thresholds hold; their quality is not measured, and None.
    """
    if _is_default(model.card, bag):
        return model, None
    thresholds = flight_thresholds(model, bag, device=device, cache=cache, jobs=jobs, progress=progress)
    card = replace(
        model.card,
        entropy_threshold=thresholds.entropy_threshold,
        sharpness_threshold=thresholds.sharpness_threshold,
    )
    return replace(model, card=card), thresholds


def flight_thresholds(
    model: Model,
    bag: BagReader,
    *,
    device: str = "cpu",
    cache: Path | None = None,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> FlightThresholds:
    """Return the thresholds of a model on a flight, measured on first use and kept if a cache is used.

    On the default flight they are the card's, which were chosen on similar flights; other thresholds would change every
    published figure of this flight.

    Args:
        model: the model.
        bag: the frames, in the model's size.
        device: as a `Segmenter` takes it.
        cache: the file of the cache; None for none, and to keep no thresholds.
        jobs: processes; as many as there are processors if None. The result does not depend on it.
        progress: called with (frames done, frames in all).
    """
    plan = plan_curves(model.card, grid={})
    made_of = _made_of(model.card, plan, bag_checksum(bag.path), device)
    if _is_default(model.card, bag):
        made_of[OF_CARD] = f"{model.card.entropy_threshold} {model.card.sharpness_threshold}"
    name = hashlib.sha256(repr(sorted(made_of.items())).encode()).hexdigest()[:16]
    file = flights_folder() / f"thresholds-{name}.json"
    if (known := _kept(file)) is not None and known.made_of == made_of:
        return known
    opening = partial(_opened, model.folder, device, bag.path, cache)
    values = _look_at_all(opening, plan, len(bag), jobs, progress)
    thresholds = _thresholds(plan, model.card, values, made_of)
    if cache is not None:
        _keep(file, thresholds)
    return thresholds


def _keep(file: Path, thresholds: FlightThresholds) -> None:
    try:
        make_folder(file.parent)
        write_text(file, document_text(thresholds))
    except OutputError as error:
        raise OutputError(
            f"The thresholds of the flight cannot be kept in {file.parent}: set SUNSET_CACHE_DIR to another folder."
        ) from error


def _is_default(card: ModelCard, bag: BagReader) -> bool:
    defaults = (DEFAULT_FLIGHT, replace(DEFAULT_FLIGHT, size=(card.height, card.width)))
    return bag.path.resolve() in [flight_place(plan).resolve() for plan in defaults]


def _made_of(card: ModelCard, plan: CurvesPlan, checksum: str, device: str) -> dict[str, str]:
    networks = sorted(card.networks.items())
    return {
        "bag": checksum,
        "conditions": hashlib.sha256(repr(_conditions(plan)).encode()).hexdigest(),
        "device": device,
        "method": f"{_METHOD}",
        "version": __version__,
        "size": f"{card.width}x{card.height}",
        **{f"network {modality.key}": network.digest for modality, network in networks},
        **{f"extension {extension.name}": extension.checksum for extension in loaded_extensions()},
    }


def _kept(file: Path) -> FlightThresholds | None:
    """Return the content of a file; None if it is missing or damaged."""
    with suppress(DataError):
        content = read_json(file, "The file", DataError)
        return convert(content, FlightThresholds, str(file), DataError, remedy="remove it")
    return None


def _look_at_all(
    opening: _Opening, plan: CurvesPlan, frames: int, jobs: int | None, progress: Progress | None
) -> Values:
    """Return entropy and sharpness (frames, conditions, 2); NaN where a frame is not used in a condition."""
    healthy, conditions = set(healthy_conditions(plan)), _conditions(plan)
    every = _every(frames)
    sampled = set(chosen_frames(frames, every))
    few = tuple(condition if condition in healthy else None for condition in conditions)
    chosen = [(index, conditions if index in sampled else few) for index in range(frames)]
    _opened.cache_clear()  # the files may have changed since this process opened them
    rows = spread(partial(_look, opening, loaded_extensions()), chosen, jobs=jobs, progress=progress)
    return np.array(list(rows))


def _every(frames: int) -> int:
    """Return the number of groups of frames of which a single group is used with each fault."""
    return _EVERY if frames >= _EVERY * SAMPLES else 1


def _conditions(plan: CurvesPlan) -> tuple[Condition, ...]:
    faults = (plan.before(fault) for fault, _ in plan.points)
    return tuple(dict.fromkeys((*healthy_conditions(plan), *faults)))


def _look(
    opening: _Opening, extensions: Sequence[LoadedExtension], chosen: tuple[int, Sequence[Condition | None]]
) -> Values:
    """Return entropy and sharpness of a frame in each condition; the noise depends on the frame's number only."""
    for extension in extensions:
        load_extension(extension.where, checksum=extension.checksum)
    index, conditions = chosen
    segmenter, bag = opening()
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
def _opened(folder: Path, device: str, path: Path, cache: Path | None) -> tuple[Segmenter, BagReader]:
    """Return a model's segmenter and a bag, opened once in each process."""
    model = load_model(folder)
    answers = None if cache is None else open_cache(cache)
    bag = read_bag(path, size=(model.card.height, model.card.width))
    return Segmenter(model, device=device, cache=answers), bag


def _thresholds(
    plan: CurvesPlan, card: ModelCard, values: Values, made_of: dict[str, str]
) -> FlightThresholds:
    """Return the thresholds and their quality.

    They are the model's own on the default flight, and where all frames are alike.
    """
    places = {condition: place for place, condition in enumerate(_conditions(plan))}
    healthy = healthy_conditions(plan)
    every = _every(len(values))

    def means(column: int, condition: Condition) -> Values:
        known = values[:, places[condition], column]
        known = known[~np.isnan(known)]
        if len(known) < SAMPLES:  # a short bag is repeated
            known = np.resize(known, SAMPLES)
        return window_means(known, 1 if condition in healthy else every)

    entropy, sharpness = partial(means, 0), partial(means, 1)
    edges = card.entropy_threshold, card.sharpness_threshold
    if OF_CARD not in made_of:
        with suppress(DataError):
            edges = part_entropy(plan, entropy).threshold, part_sharpness(plan, sharpness).threshold
        least = max(float(np.quantile(entropy(each), 1 - OVER, method="higher")) for each in healthy)
        edges = max(edges[0], least), edges[1]
    return FlightThresholds(
        entropy_threshold=edges[0],
        sharpness_threshold=edges[1],
        made_of=made_of,
        **_quality(plan, entropy, edges[0]),
    )


def _quality(plan: CurvesPlan, entropy: Means, threshold: float) -> dict[str, dict[str, float]]:
    """Return `over`, `auc`, `missed` and `cured` of a threshold."""
    unsure = unsure_faults(plan)
    nominal = entropy(Condition(plan.networks[0]))
    cures = {fault: plan.after(fault, strength) for fault, strength in plan.points if fault in unsure}

    def under(condition: Condition) -> float:
        return float((entropy(condition) <= threshold).mean())

    return {
        "over": {
            network.key: float((entropy(Condition(network)) > threshold).mean()) for network in plan.networks
        },
        "auc": {fault: roc_auc(nominal, entropy(plan.before(fault))) for fault in unsure},
        "missed": {fault: under(plan.before(fault)) for fault in unsure},
        "cured": {fault: under(cure) for fault, cure in cures.items() if cure is not None},
    }


def flights_text(model: str, flights: Mapping[str, FlightThresholds], held_out: Collection[str]) -> str:
    """Return tables of thresholds, of healthy windows above them, and of each fault and its cure.

    Args:
        model: its name.
        flights: flight → its thresholds; at least one.
        held_out: the names of flights that neither a training nor a calibration used.
    """
    thresholds = [
        (
            name,
            "yes" if name in held_out else "no",
            f"{each.entropy_threshold:.4f}",
            f"{each.sharpness_threshold:.4f}",
        )
        for name, each in flights.items()
    ]
    parts = [
        "\n".join(aligned([("flight", "held out", "entropy", "sharpness"), *thresholds])),
        _table("windows without a fault over the threshold, by network", flights, lambda each: each.over),
        _table("AUC of the entropy, by fault", flights, lambda each: each.auc),
        _table("windows with a fault that are not over the threshold", flights, lambda each: each.missed),
        _table("windows after the cheapest cure that are not over it", flights, lambda each: each.cured),
        "\n".join(_verdicts(model, flights)),
    ]
    return "\n\n".join(parts) + "\n"


def _table(
    title: str,
    flights: Mapping[str, FlightThresholds],
    shares: Callable[[FlightThresholds], Mapping[str, float]],
) -> str:
    names = list(dict.fromkeys(name for each in flights.values() for name in shares(each)))
    rows = [
        (flight, *(f"{shares(each)[name]:.3f}" if name in shares(each) else "N/A" for name in names))
        for flight, each in flights.items()
    ]
    return "\n".join([f"{title}:", *aligned([("flight", *names), *rows])])


def _verdicts(model: str, flights: Mapping[str, FlightThresholds]) -> Iterator[str]:
    yield (
        f"On each flight at most {OVER:.0%} of the windows without a fault should be over the threshold, the AUC of "
        f"each fault {AUC} or more, at most {MISSED:.0%} of the windows with it not over the threshold, and "
        f"{CURED:.0%} or more of those after its cure."
    )
    own = [flight for flight, each in flights.items() if OF_CARD in each.made_of]
    if own:
        yield (
            f"On {listed(own)} runs have the thresholds of the model's card, which were not found on this flight."
        )
    beyond = {flight: each.shortfalls() for flight, each in flights.items() if each.shortfalls()}
    for flight, texts in beyond.items():
        yield f"Beyond {model} is {flight}: {listed(texts)}."
    if not beyond:
        yield f"All of it holds for {model}."
