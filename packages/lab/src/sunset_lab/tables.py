"""Tables: the IoU of models on held-out towns, by class, height, angle and light."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from sunset.data import (
    DEFAULT_FLIGHT,
    HEIGHTS_M,
    PITCHES_DEG,
    TIMES,
    WEATHERS,
    Frame,
    flight_bag,
    kept_bag,
    render_views,
)
from sunset.errors import InvalidInputError
from sunset.perception import Modality, Model, find_device
from sunset.processes.workers import Progress, spread
from sunset_lab.evaluate import Measured, measure
from sunset_lab.frames import TEST_TOWN, VALIDATION_TOWN
from sunset_ros.seeding import generator

HELD_OUT: Final = (VALIDATION_TOWN, TEST_TOWN)
"""The towns on which no network was trained, beside the default flight's."""

AXES: Final[Mapping[str, Sequence[Any]]] = MappingProxyType(
    {"height": HEIGHTS_M, "angle": PITCHES_DEG, "time": TIMES, "weather": WEATHERS}
)
"""The fields of `Setting`, and their values in order."""

_SEED: Final = 7


@dataclass(frozen=True, slots=True)
class Setting:
    """How a view is taken: the height above ground in m (± 10 %), and the angle below the horizon in degrees (± 3)."""

    height: float
    angle: float
    time: str
    weather: str


@dataclass(frozen=True, slots=True)
class Entry:
    """A column of the tables: a network of a model, by name, with its version where names repeat."""

    model: str
    modality: Modality

    def __str__(self) -> str:
        return f"{self.model} {self.modality.key}"


@dataclass(frozen=True, slots=True)
class IouTables:
    """The results of `measure_iou`, by network, on views of the held-out towns and on the default flight.

    Towns are named by their numbers. The views of every town are in the same settings.
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
        """Return the views of all held-out towns by the values of an axis of `AXES`."""
        together = np.concatenate([measured.counts for measured in self.views.values()])
        values = [getattr(setting, axis) for setting in self.settings] * len(self.views)
        units = {"height": " m", "angle": "°"}
        return {
            f"{value:g}{units[axis]}" if axis in units else str(value): Measured(
                together[[other == value for other in values]]
            )
            for value in AXES[axis]
            if value in values
        }


_SETTINGS: Final = tuple(Setting(*values) for values in product(*AXES.values()))
VIEWS: Final = 2 * len(_SETTINGS)
"""The number of views of each held-out town."""


def settings(count: int) -> tuple[Setting, ...]:
    """Return `count` settings: all combinations in a mixed order, repeated."""
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

    Args:
        models: of the same size, with distinct names or versions.
        frames: of each held-out town, and of the default flight, at regular distances; if None, two views of every
            setting and the whole flight.
        jobs: as in `over_frames`.
        device: as a `Segmenter` takes it.
        progress: called with (frames done, frames in all), where every model counts its own.
        rendering: called likewise while frames are rendered, once; they are kept in the cache folder.
    """
    size, names, device = _common_size(models), _names(models), find_device(device)
    taken = settings(frames or VIEWS)
    bags = [_views_bag(town, taken, size, jobs, rendering) for town in HELD_OUT]
    bags.append(flight_bag(replace(DEFAULT_FLIGHT, size=size), progress=rendering, jobs=jobs))
    flown = np.unique(np.linspace(0, DEFAULT_FLIGHT.frames - 1, frames or DEFAULT_FLIGHT.frames).astype(int))
    places = list(zip(bags, [*(range(len(taken)) for _ in HELD_OUT), flown.tolist()], strict=True))
    parts = _measure_places(models, places, device, jobs, progress)
    return IouTables(
        networks=tuple(
            Entry(name, modality)
            for name, model in zip(names, models, strict=True)
            for modality in sorted(model.card.networks)
        ),
        views=dict(zip(HELD_OUT, parts, strict=False)),
        flight=parts[-1],
        settings=taken,
    )


def _measure_places(
    models: Sequence[Model],
    places: Sequence[tuple[Path, Sequence[int]]],
    device: str,
    jobs: int | None,
    progress: Progress | None,
) -> list[Measured]:
    """Measure all models on the chosen frames of each bag."""
    done, total = 0, len(models) * sum(len(chosen) for _, chosen in places)

    def note(part: int, _: int) -> None:
        if progress is not None:
            progress(done + part, total)

    parts = []
    for bag, chosen in places:
        counts = []
        for model in models:
            counts.append(measure(model, bag, chosen, device=device, jobs=jobs, progress=note).counts)
            done += len(chosen)
        parts.append(Measured(np.concatenate(counts, axis=1)))
    return parts


def _common_size(models: Sequence[Model]) -> tuple[int, int]:
    sizes = {(model.card.height, model.card.width) for model in models}
    if len(sizes) != 1:
        given = ", ".join(f"{model.card.name} {model.card.width}x{model.card.height}" for model in models)
        raise InvalidInputError(
            f"The models of one table must take images of one size, got {given or 'none'}."
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
