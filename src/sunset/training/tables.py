"""Tables: the IoU of models on towns that they were not trained on, by class, height, angle and light."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache, partial
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from sunset.classes import CLASS_OF_CARLA_ID
from sunset.data import (
    DEFAULT_FLIGHT,
    HEIGHTS_M,
    PITCHES_DEG,
    TIMES,
    WEATHERS,
    BagReader,
    Frame,
    flight_bag,
    kept_bag,
    read_bag,
    render_views,
)
from sunset.errors import InvalidInputError
from sunset.metrics import ClassCounts, class_iou, count_classes
from sunset.metrics.timeline import Counts
from sunset.perception import Modality, Model, Segmenter, find_device, load_model
from sunset.processes.workers import Progress, spread
from sunset.seeding import generator
from sunset.training.frames import TEST_TOWN, VALIDATION_TOWN

HELD_OUT: Final = (VALIDATION_TOWN, TEST_TOWN)
"""The towns that no network was trained on, beside the default flight's."""

AXES: Final[Mapping[str, Sequence[Any]]] = MappingProxyType(
    {"height": HEIGHTS_M, "angle": PITCHES_DEG, "time": TIMES, "weather": WEATHERS}
)
"""What views differ in, the fields of `Setting`, and their values in order."""

_SEED: Final = 7


@dataclass(frozen=True, slots=True)
class Setting:
    """How a view is taken: height above the ground in metres, to 10 %, and angle below the horizon in degrees, to 3."""

    height: float
    angle: float
    time: str
    weather: str


@dataclass(frozen=True, slots=True)
class Entry:
    """A column of the tables: one network of a model, by name, with its version where two have the same."""

    model: str
    modality: Modality

    def __str__(self) -> str:
        return f"{self.model} {self.modality.key}"


@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """What networks made of some frames.

    Counts (N, networks, 3, 28) are the pixels of each class in both prediction and truth, in the prediction, and in
    the truth, of every frame.
    """

    counts: Counts

    def __len__(self) -> int:
        return len(self.counts)

    def per_image(self) -> npt.NDArray[np.float64]:
        """Return the mean over frames of the mean IoU over the classes in the frame, by network."""
        iou, present = class_iou(ClassCounts(*np.moveaxis(self.counts, -2, 0)))
        means = iou.sum(axis=2) / np.maximum(present.sum(axis=2), 1)  # the IoU of what is absent is 0
        result: npt.NDArray[np.float64] = means.mean(axis=0)
        return result

    def by_class(self) -> npt.NDArray[np.float64]:
        """Return the IoU of every class over all frames (networks, 28); NaN where it is absent."""
        iou, present = class_iou(ClassCounts(*np.moveaxis(self.counts.sum(axis=0), -2, 0)))
        return np.where(present, iou, np.nan)

    def dataset(self) -> npt.NDArray[np.float64]:
        """Return the mIoU of all frames together, by network."""
        mean: npt.NDArray[np.float64] = np.nanmean(self.by_class(), axis=1)
        return mean

    def shares(self) -> npt.NDArray[np.float64]:
        """Return every class's share of the pixels (28,)."""
        truth = self.counts[:, 0, 2].sum(axis=0)
        shares: npt.NDArray[np.float64] = truth / max(int(truth.sum()), 1)
        return shares


@dataclass(frozen=True, slots=True)
class IouTables:
    """Everything that `measure_iou` found: by network, on the default flight and views of the held-out towns.

    Towns are by their numbers; the views of each are those of the settings.
    """

    networks: tuple[Entry, ...]
    views: Mapping[int, Measured]
    flight: Measured
    settings: tuple[Setting, ...]

    def places(self) -> dict[str, Measured]:
        """Return the sets of frames by name."""
        towns = {f"town {town}": measured for town, measured in self.views.items()}
        return towns | {"default flight": self.flight}

    def along(self, axis: str) -> dict[str, Measured]:
        """Return the views of all held-out towns, by the values of one of `AXES`."""
        together = Measured(np.concatenate([measured.counts for measured in self.views.values()]))
        values = [getattr(setting, axis) for setting in self.settings] * len(self.views)
        units = {"height": " m", "angle": "°"}
        return {
            f"{value:g}{units[axis]}" if axis in units else str(value): Measured(
                together.counts[[other == value for other in values]]
            )
            for value in AXES[axis]
            if value in values
        }


_SETTINGS: Final = tuple(Setting(*values) for values in product(*AXES.values()))
VIEWS: Final = 2 * len(_SETTINGS)
"""So many views of each held-out town are taken."""


def settings(count: int) -> tuple[Setting, ...]:
    """Return the settings of so many views, at least 1: all combinations in a mixed order, again and again."""
    mixed = generator(_SEED, "iou", "settings").permutation(len(_SETTINGS))
    return tuple(_SETTINGS[mixed[index % len(mixed)]] for index in range(count))


def measure_iou(
    models: Sequence[Model],
    *,
    frames: int | None = None,
    jobs: int | None = None,
    device: str = "cpu",
    progress: Progress | None = None,
    rendering: Progress | None = None,
) -> IouTables:
    """Measure models on views of the held-out towns, and on the default flight.

    Frames are rendered once and kept in the cache folder.

    Args:
        models: of one size, and each of another name or version; at least one.
        frames: views of each held-out town, and frames of the default flight, at regular distances, at least 1;
            if None, two views of every setting and the whole flight.
        jobs: processes; as many as there are processors if None. It has no influence on the result.
        device: what the networks run on, as a `Segmenter` takes it.
        progress: called with frames done and frames in all.
        rendering: called likewise while frames are rendered.

    Raises:
        InvalidInputError: models differ in size, two have the same name and version, or there is no such device.
        MissingExtraError: the device needs a package that is not installed.
        OutputError: the cache folder cannot be written.
    """
    size, names, device = _common_size(models), _names(models), find_device(device)
    taken = settings(frames or VIEWS)
    bags = [_views_bag(town, taken, size, jobs, rendering) for town in HELD_OUT]
    bags.append(flight_bag(replace(DEFAULT_FLIGHT, size=size), progress=rendering, jobs=jobs))
    flown = np.unique(np.linspace(0, DEFAULT_FLIGHT.frames - 1, frames or DEFAULT_FLIGHT.frames).astype(int))
    chosen = [*(range(len(taken)) for _ in HELD_OUT), flown.tolist()]
    looks = [(place, index) for place, indices in enumerate(chosen) for index in indices]
    work = partial(_count, tuple(model.folder for model in models), device, tuple(bags))
    _opened.cache_clear()  # what the paths name may have changed since this process measured before
    counts = np.stack(list(spread(work, looks, jobs=jobs, progress=progress)))
    *held_out, flight = np.split(counts, np.cumsum([len(indices) for indices in chosen])[:-1])
    return IouTables(
        networks=tuple(
            Entry(name, modality)
            for name, model in zip(names, models, strict=True)
            for modality in sorted(model.card.networks)
        ),
        views={town: Measured(part) for town, part in zip(HELD_OUT, held_out, strict=True)},
        flight=Measured(flight),
        settings=taken,
    )


def _common_size(models: Sequence[Model]) -> tuple[int, int]:
    sizes = {(model.card.height, model.card.width) for model in models}
    if len(sizes) != 1:
        found = ", ".join(f"{model.card.name} {model.card.width}x{model.card.height}" for model in models)
        raise InvalidInputError(
            f"The models of one table must take images of one size, got {found or 'none'}."
        )
    return sizes.pop()


def _names(models: Sequence[Model]) -> list[str]:
    names = [model.card.name for model in models]
    headings = [
        name if names.count(name) == 1 else f"{name} ({model.card.version})"
        for name, model in zip(names, models, strict=True)
    ]
    for heading in headings:
        if headings.count(heading) > 1:
            raise InvalidInputError(
                f"The models of one table must differ in name or version, got {heading} more than once."
            )
    return headings


def _views_bag(
    town: int, taken: tuple[Setting, ...], size: tuple[int, int], jobs: int | None, progress: Progress | None
) -> Path:
    facts = {"town": town, "seed": _SEED, "size": size, "settings": [asdict(setting) for setting in taken]}
    work = partial(_render, town, taken, size)
    return kept_bag(
        f"views-town{town}",
        facts,
        lambda: spread(work, range(len(taken)), jobs=jobs, progress=progress),
        [index * 100_000_000 for index in range(len(taken))],
    )


def _render(town: int, taken: Sequence[Setting], size: tuple[int, int], index: int) -> Frame:
    setting = taken[index]
    (frame,) = render_views(
        town,
        1,
        _SEED,
        heights=(setting.height,),
        pitches=(setting.angle,),
        times=(setting.time,),
        weathers=(setting.weather,),
        start=index,
        size=size,
    )
    return frame


def _count(folders: tuple[Path, ...], device: str, bags: tuple[Path, ...], look: tuple[int, int]) -> Counts:
    """Return the counts (networks, 3, 28) of a look: a bag's place and a frame's index there."""
    place, index = look
    segmenters, readers = _opened(folders, device, bags)
    frame = readers[place].frame(index)
    truth = CLASS_OF_CARLA_ID[frame.labels]
    found = (
        count_classes(segmenter.segment(modality, frame.rgb, frame.depth).labels, truth)
        for segmenter in segmenters
        for modality in sorted(segmenter.model.card.networks)
    )
    return np.array([(counts.intersection, counts.predicted, counts.truth) for counts in found])


@lru_cache(maxsize=1)
def _opened(
    folders: tuple[Path, ...], device: str, bags: tuple[Path, ...]
) -> tuple[tuple[Segmenter, ...], tuple[BagReader, ...]]:
    """Return models and bags, opened once a process."""
    segmenters = tuple(Segmenter(load_model(folder), device=device) for folder in folders)
    return segmenters, tuple(read_bag(bag) for bag in bags)
