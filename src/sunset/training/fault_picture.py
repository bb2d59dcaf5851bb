"""A picture of a fault on one frame: what the segmentation gets and makes of it, before, with it and after its cure."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Final

import cv2
import numpy as np
import numpy.typing as npt

from sunset.calibration import Condition, effects, suite_strengths
from sunset.classes import CLASS_OF_CARLA_ID, CLASSES, COLOURS, PALETTE
from sunset.data import read_bag
from sunset.errors import InvalidInputError
from sunset.figures import drawing
from sunset.metrics import count_classes, image_iou
from sunset.perception import Modality, Model, Segmenter
from sunset.seeding import generator
from sunset.system import ENTROPY_SIGNAL, SHARPNESS_SIGNAL, Signal, current_system, get_fault
from sunset.training.inputs import FAR_PLANE_M

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RELIEF_M: Final = 3.0
"""Depths are drawn less their mean nearby, from minus to plus so much; else noise and cars do not show."""

_NEARBY: Final = (17, 17)
"""Pixels of that mean."""

_EDGES: Final = (255, 140, 0)
"""The colour of the depth image's edges in a colour image: orange."""
_LEGEND: Final = 8
"""So many classes are named, those with most pixels."""

_Labels = npt.NDArray[np.uint8]


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """One frame in one condition.

    Attributes:
        title: of the condition.
        image: what the segmentation gets, to look at: (H, W, 3) uint8 of red, green and blue.
        labels: (H, W) uint8, class indices.
        iou: of the labels, in [0, 1]; NaN where the frame lacks a truth.
        entropy: of the network, in [0, 1].
        sharpness: of the camera's image.
    """

    title: str
    image: npt.NDArray[np.uint8]
    labels: _Labels
    iou: float
    entropy: float
    sharpness: float


def fault_views(fault: str, model: Model, bag: Path, frame: int | None = None) -> tuple[View, ...]:
    """Return a frame without a fault, with the fault at the strength of the suites, and after its cheapest cure.

    Args:
        fault: one of which it is known what it does to images.
        model: what segments.
        bag: of the frame; frames of another size are resampled to the model's.
        frame: its number in the bag, from 0 on; the one in the middle if None.

    Raises:
        DataError: the bag is not usable.
        InvalidInputError: the bag has no such frame, or the model lacks the network that the cure needs.
    """
    with read_bag(bag, size=(model.card.height, model.card.width)) as reader:
        index = len(reader) // 2 if frame is None else frame
        if not 0 <= index < len(reader):
            raise InvalidInputError(f"The frame must be from 0 to {len(reader) - 1} in {bag}, got {index}.")
        taken = reader.frame(index)
    truth = CLASS_OF_CARLA_ID[taken.labels]
    healthy = Condition(min(model.card.networks))
    faulty = healthy.with_faults({fault: suite_strengths()[fault]})
    cured = faulty.cured_of(fault)
    if cured.modality not in model.card.networks:
        raise InvalidInputError(
            f"The cure of {fault} needs the network {cured.modality.key!r}, which the model {model.card.name} lacks."
        )
    segmenter = Segmenter(model)
    sensor, titles = effects()[fault].sensor, ("without a fault", fault, "cured")
    views = []
    for title, condition in zip(titles, (healthy, faulty, cured), strict=True):
        seen = condition.seen(taken.rgb, taken.depth, generator(0, "conditions", index))
        found = segmenter.segment(condition.modality, seen.bgr, seen.depth)
        if sensor == "depth" and condition.modality.needs_depth:
            image = _relief(seen.depth)
        else:
            image = np.ascontiguousarray(seen.bgr[:, :, ::-1])
            if effects()[fault].unit.startswith("pixels") and condition.modality is Modality.FUSION:
                image = _with_edges(image, seen.depth)
        iou = image_iou(count_classes(found.labels, truth))
        views.append(View(title, image, found.labels, iou, found.entropy, seen.sharpness))
    return tuple(views)


def views_figure(views: Sequence[View], fault: str, model: Model) -> "Figure":
    """Return a figure of a frame's views side by side, and below each what the network makes of it.

    Args:
        views: as of `fault_views`.
        fault: its name.
        model: whose thresholds are named.
    """
    with drawing({"font.size": 8}) as new_figure:
        figure = new_figure(figsize=(7.2, 3.7), dpi=140, layout="constrained")
        _fill(figure, views, fault, model)
    return figure


def _fill(figure: "Figure", views: Sequence[View], name: str, model: Model) -> None:
    from matplotlib.patches import Patch  # noqa: PLC0415  an optional extra

    fault = get_fault(name)
    blurs = current_system().failures[fault.failure].signal == SHARPNESS_SIGNAL.name
    axes = figure.subplots(2, len(views))
    for column, view in enumerate(views):
        above, below = axes[0][column], axes[1][column]
        above.imshow(view.image, interpolation="nearest")
        above.set_title(view.title, fontweight="bold")
        below.imshow(PALETTE[view.labels], interpolation="nearest")
        signal = (
            _compared(SHARPNESS_SIGNAL, view.sharpness, model.card.sharpness_threshold)
            if blurs
            else _compared(ENTROPY_SIGNAL, view.entropy, model.card.entropy_threshold)
        )
        below.set_xlabel(f"IoU {'N/A' if isnan(view.iou) else f'{view.iou:.2f}'}\n{signal}")
        for one in (above, below):
            one.set(xticks=[], yticks=[])
            one.spines[:].set_visible(False)
    axes[0][0].set_ylabel("what the network gets")
    axes[1][0].set_ylabel("what it sees in that")
    figure.suptitle(f"{fault.description}\nCure: {fault.cure_texts[0]}", fontsize=8, x=0.01, ha="left")
    frequent = np.bincount(views[0].labels.ravel(), minlength=len(CLASSES)).argsort()[::-1][:_LEGEND]
    handles = [Patch(color=np.array(COLOURS[index]) / 255, label=CLASSES[index]) for index in frequent]
    if effects()[name].unit.startswith("pixels"):
        handles[-2:] = [
            Patch(color=np.array(_EDGES) / 255, label="edges in depth")
        ]  # where two classes had room
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=7)


def _compared(signal: Signal, value: float, threshold: float) -> str:
    """Return a signal's value, and what a threshold says of it."""
    sign = "<" if value < threshold else ">"
    symptom = ": symptom" if signal.is_beyond(value, threshold) else ""
    return f"{signal.key} {value:.3f} {sign} {threshold:.3f}{symptom}"


def _relief(depth: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint8]:
    """Return a depth image (H, W) in counts as grey levels (H, W, 3): what is nearer than its surroundings is light."""
    metres = depth.astype(np.float32) * (FAR_PLANE_M / 65535)
    above = np.clip((cv2.blur(metres, _NEARBY) - metres) / _RELIEF_M, -1, 1)
    grey = ((above + 1) * 127.5).astype(np.uint8)
    return np.repeat(grey[:, :, None], 3, axis=2)


def _with_edges(image: npt.NDArray[np.uint8], depth: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint8]:
    """Return a colour image with the edges of the depth image, which are on those of things if both fit."""
    metres = depth.astype(np.float32) * (FAR_PLANE_M / 65535)
    step = np.abs(cv2.Laplacian(metres, cv2.CV_32F, ksize=1))
    marked = image.copy()
    marked[step > 0.5 * _RELIEF_M] = _EDGES
    return marked
