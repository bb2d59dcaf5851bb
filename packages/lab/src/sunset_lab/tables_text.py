"""Tables of IoU as Markdown, CSV and JSON, with a check of the project's claims."""

from collections.abc import Callable, Iterable, Iterator
from typing import Final

import numpy as np

from sunset.classes import CLASSES
from sunset.perception import Modality
from sunset.texts.sentences import csv_text
from sunset.texts.tables import markdown_table
from sunset_lab.evaluate import Measured
from sunset_lab.tables import AXES, Entry, IouTables

_COMMON: Final = 0.005
_LEARNED: Final = 0.3


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
    return markdown_table(
        [
            ["", "frames", *map(str, tables.networks)],
            *([name, str(len(measured)), *map(_cell, mean(measured))] for name, measured in rows.items()),
        ]
    )


def _classes(tables: IouTables, measured: Measured) -> str:
    iou, shares = measured.by_class(), measured.shares()
    seen = np.flatnonzero(~np.isnan(iou).all(axis=0))
    return markdown_table(
        [
            ["class", "share of pixels", *map(str, tables.networks)],
            *([CLASSES[index], f"{shares[index]:.2%}", *map(_cell, iou[:, index])] for index in seen),
        ]
    )


def _cell(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.3f}"


def claims(tables: IouTables) -> Iterator[str]:
    """Yield a sentence for each claim about the models, with its verdict."""
    for name, measured in tables.places().items():
        means = dict(zip(tables.networks, measured.per_image(), strict=True))
        for entry, value in means.items():
            if entry.modality is Modality.FUSION:
                for modality, least in ((Modality.RGB, 0.01), (Modality.DEPTH, 0.05)):
                    other = means.get(Entry(entry.model, modality))
                    if other is not None:
                        yield (
                            f"{_verdict(value >= other + least)}: {name}, {entry.model}: fusion {value:.3f} ≥ "
                            f"{modality.key} {other:.3f} + {least}"
                        )
        yield from _weak_classes(tables, name, measured)
        yield from _order(tables, name, means)


def _verdict(holds: bool) -> str:
    return "holds" if holds else "does not hold"


def _flying(tables: IouTables) -> dict[str, Entry]:
    """Return the first network of each model, which runs use: the fusion, if there is one."""
    flying: dict[str, Entry] = {}
    for entry in tables.networks:
        flying.setdefault(entry.model, entry)
    return flying


def _weak_classes(tables: IouTables, name: str, measured: Measured) -> Iterator[str]:
    shares, iou = measured.shares(), measured.by_class()
    for entry in _flying(tables).values():
        row = iou[tables.networks.index(entry)]
        weak = [
            f"{CLASSES[index]} {row[index]:.3f}"
            for index in np.flatnonzero((shares >= _COMMON) & (np.nan_to_num(row) < _LEARNED))
        ]
        yield (
            f"{_verdict(not weak)}: {name}, {entry}: every class with {_COMMON:.1%} of the pixels or more has an IoU "
            f"of {_LEARNED} or more{': not ' + ', '.join(weak) if weak else ''}"
        )


def _order(tables: IouTables, name: str, means: dict[Entry, float]) -> Iterator[str]:
    flying = sorted(_flying(tables).values(), key=lambda entry: -means[entry])
    if len(flying) > 1:
        yield f"best on {name}: " + ", then ".join(f"{entry} {means[entry]:.3f}" for entry in flying)


def iou_csv(tables: IouTables) -> str:
    """Return the figures as CSV, a figure in each row."""
    rows: list[list[object]] = [
        ["frames", "count", "measure", "class", "share_of_pixels", "model", "modality", "iou"]
    ]
    for name, measured in _groups(tables).items():
        shares = measured.shares()
        for place, entry in enumerate(tables.networks):
            network = [entry.model, entry.modality.key]
            for measure, values in (
                ("mean over frames", measured.per_image()),
                ("mIoU", measured.dataset()),
            ):
                rows.append([name, len(measured), measure, "", "", *network, f"{values[place]:.6g}"])
            for index, iou in _present(measured, place):
                share = f"{shares[index]:.6g}"
                rows.append([name, len(measured), "class IoU", CLASSES[index], share, *network, f"{iou:.6g}"])
    return csv_text(rows)


def _present(measured: Measured, place: int) -> list[tuple[int, float]]:
    """Return the classes present with a network, by index, and their IoU."""
    return [(index, float(iou)) for index, iou in enumerate(measured.by_class()[place]) if not np.isnan(iou)]


def _groups(tables: IouTables) -> dict[str, Measured]:
    """Return all sets of frames by name."""
    along = {f"{axis} {value}": measured for axis in AXES for value, measured in tables.along(axis).items()}
    return tables.places() | along


def iou_json(tables: IouTables) -> dict[str, object]:
    """Return all figures and claims as a JSON object."""
    return {
        "frames": {name: _object(tables, measured) for name, measured in _groups(tables).items()},
        "claims": list(claims(tables)),
    }


def _object(tables: IouTables, measured: Measured) -> dict[str, object]:
    return {
        "count": len(measured),
        "share_of_pixels": dict(zip(CLASSES, measured.shares().tolist(), strict=True)),
        "networks": {
            str(entry): {
                "mean_over_frames": float(measured.per_image()[place]),
                "miou": float(measured.dataset()[place]),
                "classes": {CLASSES[index]: iou for index, iou in _present(measured, place)},
            }
            for place, entry in enumerate(tables.networks)
        },
    }
