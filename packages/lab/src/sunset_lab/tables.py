"""Tables: the IoU of models on held-out towns, by class, height, angle and light, with a check of the claims."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Final, Unpack

import numpy as np

from sunset.classes import CLASSES
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
from sunset.perception import Modality, Model
from sunset.processes.workers import Progress, spread
from sunset.texts.sentences import csv_text
from sunset.texts.tables import markdown_table
from sunset_lab.frames import TEST_TOWN, VALIDATION_TOWN
from sunset_lab.measuring import LookOptions, Measured, measure
from sunset_ros.seeding import generator

HELD_OUT: Final = (VALIDATION_TOWN, TEST_TOWN)
"""The towns on which no network was trained, beside the default flight's."""

AXES: Final[Mapping[str, Sequence[float | str]]] = {
    "height": HEIGHTS_M,
    "angle": PITCHES_DEG,
    "time": TIMES,
    "weather": WEATHERS,
}
"""The fields of `Setting`, and their values in order."""

_SEED: Final = 7
_COMMON: Final = 0.005
_LEARNED: Final = 0.3
"""A class with this share of the pixels should have this IoU."""


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


_SETTINGS: Final = tuple(Setting(*values) for values in product(HEIGHTS_M, PITCHES_DEG, TIMES, WEATHERS))
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
    rendering: Progress | None = None,
    **options: Unpack[LookOptions],
) -> IouTables:
    """Measure models of the same size, with distinct names or versions, as `sunset.measure_iou`.

    The frames of the default flight are at regular distances. The progress counts each frame once for every model.
    Rendered frames are kept in the cache folder.
    """
    size, names, jobs = _common_size(models), _names(models), options.get("jobs")
    taken = settings(frames or VIEWS)
    flown = np.unique(np.linspace(0, DEFAULT_FLIGHT.frames - 1, frames or DEFAULT_FLIGHT.frames).astype(int))
    flight = flight_bag(replace(DEFAULT_FLIGHT, size=size), progress=rendering, jobs=jobs)
    places = [(_views_bag(town, taken, size, jobs, rendering), range(len(taken))) for town in HELD_OUT]
    parts = _measure_places(models, [*places, (flight, flown.tolist())], options)
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
    models: Sequence[Model], places: Sequence[tuple[Path, Sequence[int]]], options: LookOptions
) -> list[Measured]:
    """Measure all models on the chosen frames of each bag."""
    done, total = 0, len(models) * sum(len(chosen) for _, chosen in places)
    progress = options.get("progress")

    def note(part: int, _: int) -> None:
        if progress is not None:
            progress(done + part, total)

    noted: LookOptions = {**options, "progress": note}
    parts = []
    for bag, chosen in places:
        counts = []
        for model in models:
            counts.append(measure(model, bag, chosen, **noted).counts)
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


def iou_markdown(tables: IouTables) -> str:
    """Return all tables, and the claims, as Markdown."""
    frames = ", ".join(f"{len(measured)} of {name}" for name, measured in tables.places().items())
    parts = [
        f"# IoU on frames that no network was trained on\n\nFrames: {frames}.",
        "## Mean over frames\n\nOf each frame, the mean IoU over the classes in its prediction or truth.\n\n"
        + _means(tables, tables.places(), Measured.per_image),
        "## Of all frames together\n\nThe mean over classes of the IoU of all frames' pixels (mIoU).\n\n"
        + _means(tables, tables.places(), Measured.dataset),
    ]
    for axis in AXES:
        text = f"## By {axis}\n\nViews of the held-out towns, mean over frames.\n\n"
        parts.append(text + _means(tables, tables.along(axis), Measured.per_image))
    for name, measured in tables.places().items():
        parts.append(f"## By class: {name}\n\n" + _classes(tables, measured))
    parts.append("## Claims\n\n" + "\n".join(f"- {line}" for line in claims(tables)))
    return "\n\n".join(parts) + "\n"


def _means(tables: IouTables, rows: dict[str, Measured], mean: Callable[[Measured], Iterable[float]]) -> str:
    head = ["", "frames", *map(str, tables.networks)]
    cells = ([name, str(len(measured)), *map(_cell, mean(measured))] for name, measured in rows.items())
    return markdown_table([head, *cells])


def _classes(tables: IouTables, measured: Measured) -> str:
    rows = [["class", "share of pixels", *map(str, tables.networks)]]
    for name, share, ious in zip(CLASSES, measured.shares(), measured.by_class().T, strict=True):
        if not np.isnan(ious).all():
            rows.append([name, f"{share:.2%}", *map(_cell, ious)])
    return markdown_table(rows)


def _cell(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.3f}"


def claims(tables: IouTables) -> Iterator[str]:
    """Yield a sentence for each claim about the models, with its verdict."""
    flying: dict[str, Entry] = {}  # each model's first network, which runs use: the fusion, if there is one
    for entry in tables.networks:
        flying.setdefault(entry.model, entry)
    for place, measured in tables.places().items():
        means = {entry: mean for entry, mean, _, _ in _figures(tables, measured)}
        for entry in tables.networks:
            for modality, least in ((Modality.RGB, 0.01), (Modality.DEPTH, 0.05)):
                other = means.get(Entry(entry.model, modality))
                if entry.modality is Modality.FUSION and other is not None:
                    yield (
                        f"{_verdict(means[entry] >= other + least)}: {place}, {entry.model}: fusion "
                        f"{means[entry]:.3f} ≥ {modality.key} {other:.3f} + {least}"
                    )
        yield from _weak_classes(tables, place, measured, [*flying.values()])
        if len(flying) > 1:
            order = sorted(flying.values(), key=lambda entry: -means[entry])
            yield f"best on {place}: " + ", then ".join(f"{entry} {means[entry]:.3f}" for entry in order)


def _verdict(holds: bool) -> str:
    return "holds" if holds else "does not hold"


def _weak_classes(
    tables: IouTables, place: str, measured: Measured, networks: Sequence[Entry]
) -> Iterator[str]:
    shares = dict(zip(CLASSES, measured.shares(), strict=True))
    for entry, _, _, ious in _figures(tables, measured):
        if entry in networks:
            weak = [
                f"{name} {iou:.3f}"
                for name, iou in ious.items()
                if shares[name] >= _COMMON and iou < _LEARNED
            ]
            yield (
                f"{_verdict(not weak)}: {place}, {entry}: every class with {_COMMON:.1%} of the pixels or more has an "
                f"IoU of {_LEARNED} or more{': not ' + ', '.join(weak) if weak else ''}"
            )


def iou_csv(tables: IouTables) -> str:
    """Return the figures as CSV, a figure in each row."""
    rows: list[list[object]] = [
        ["frames", "count", "measure", "class", "share_of_pixels", "model", "modality", "iou"]
    ]
    for name, measured in _groups(tables).items():
        shares = dict(zip(CLASSES, measured.shares(), strict=True))
        for entry, mean, miou, ious in _figures(tables, measured):
            figures = [("mean over frames", "", "", mean), ("mIoU", "", "", miou)]
            figures += [("class IoU", key, f"{shares[key]:.6g}", iou) for key, iou in ious.items()]
            for *labels, iou in figures:
                network = (entry.model, entry.modality.key)
                rows.append([name, len(measured), *labels, *network, f"{iou:.6g}"])
    return csv_text(rows)


def _figures(tables: IouTables, measured: Measured) -> Iterator[tuple[Entry, float, float, dict[str, float]]]:
    """Yield each network with its mean IoU over frames, its mIoU, and the IoU of the classes that are there."""
    columns = (measured.per_image(), measured.dataset(), measured.by_class())
    for entry, mean, miou, row in zip(tables.networks, *columns, strict=True):
        ious = {name: float(iou) for name, iou in zip(CLASSES, row, strict=True) if not np.isnan(iou)}
        yield entry, float(mean), float(miou), ious


def _groups(tables: IouTables) -> dict[str, Measured]:
    """Return all sets of frames by name."""
    along = {f"{axis} {value}": measured for axis in AXES for value, measured in tables.along(axis).items()}
    return tables.places() | along


def iou_json(tables: IouTables) -> dict[str, object]:
    """Return all figures and claims as a JSON object."""
    frames = {
        name: {
            "count": len(measured),
            "share_of_pixels": dict(zip(CLASSES, measured.shares().tolist(), strict=True)),
            "networks": {
                str(entry): {"mean_over_frames": mean, "miou": miou, "classes": ious}
                for entry, mean, miou, ious in _figures(tables, measured)
            },
        }
        for name, measured in _groups(tables).items()
    }
    return {"frames": frames, "claims": list(claims(tables))}
