"""A picture of a fault on a frame: the images and the segmentation without it, with it, and after its cure."""

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
from sunset.data import DEPTH_RANGE_M, Frame, read_bag
from sunset.errors import InvalidInputError
from sunset.files.plots import drawing
from sunset.metrics import count_classes, image_iou
from sunset.perception import Modality, Model, Segmenter
from sunset.system import ENTROPY_SIGNAL, SHARPNESS_SIGNAL, Signal, current_system, get_fault
from sunset_ros.seeding import generator

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_RELIEF_M: Final = 3.0
"""Depth is drawn as its difference to the mean nearby, up to so much; otherwise noise and cars would not show."""

_NEARBY: Final = (17, 17)
"""The pixels of this mean."""

_EDGES: Final = (255, 140, 0)
"""The colour of the depth image's edges in a colour image: orange."""
_LEGEND: Final = 8
"""The number of classes in the legend, those with most pixels."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A frame in a condition.

    Attributes:
        title: of the condition.
        image: for the reader, (H, W, 3) uint8 of red, green and blue.
        labels: (H, W) uint8, class indices.
        iou: of the labels, in [0, 1]; NaN where the frame lacks labels.
        entropy: of the network, in [0, 1].
        sharpness: of the camera's image.
    """

    title: str
    image: npt.NDArray[np.uint8]
    labels: npt.NDArray[np.uint8]
    iou: float
    entropy: float
    sharpness: float


def fault_views(fault: str, model: Model, bag: Path, frame: int | None = None) -> tuple[View, ...]:
    """Return a frame without a fault, with the fault at the strength of the suites, and after its cheapest cure.

    Args:
        fault: a fault with a known effect on images.
        model: for the segmentation.
        bag: of the frame, which is resampled to the model's size.
        frame: its number in the bag, from 0; the middle if None.

    Raises:
        DataError: the bag cannot be read.
        InvalidInputError: the bag lacks the frame, or the model lacks the cure's network.
    """
    with read_bag(bag, size=(model.card.height, model.card.width)) as reader:
        index = len(reader) // 2 if frame is None else frame
        if not 0 <= index < len(reader):
            raise InvalidInputError(f"The frame must be from 0 to {len(reader) - 1} in {bag}, got {index}.")
        taken = reader.frame(index)
    healthy = Condition(min(model.card.networks))
    faulty = healthy.with_faults({fault: suite_strengths()[fault]})
    cured = faulty.cured_of(fault)
    if cured.modality not in model.card.networks:
        raise InvalidInputError(
            f"The cure of {fault} needs the network {cured.modality.key!r}, which the model {model.card.name} lacks."
        )
    segmenter = Segmenter(model)
    conditions = {"without a fault": healthy, fault: faulty, "cured": cured}
    return tuple(
        _view(title, fault, condition, segmenter=segmenter, frame=taken, index=index)
        for title, condition in conditions.items()
    )


def _view(
    title: str, fault: str, condition: Condition, *, segmenter: Segmenter, frame: Frame, index: int
) -> View:
    effect = effects()[fault]
    seen = condition.seen(frame.rgb, frame.depth, generator(0, "conditions", index))
    result = segmenter.segment(condition.modality, seen.bgr, seen.depth)
    if effect.sensor == "depth" and condition.modality.needs_depth:
        image = _relief(seen.depth)
    else:
        image = np.ascontiguousarray(seen.bgr[:, :, ::-1])
        if effect.unit.startswith("pixels") and condition.modality is Modality.FUSION:
            image = _with_edges(image, seen.depth)
    iou = image_iou(count_classes(result.labels, CLASS_OF_CARLA_ID[frame.labels]))
    return View(title, image, result.labels, iou, result.entropy, seen.sharpness)


def views_figure(views: Sequence[View], fault: str, model: Model) -> "Figure":
    """Return a figure of a fault's views side by side, each above its segmentation, with the model's thresholds."""
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
        for panel in (above, below):
            panel.set(xticks=[], yticks=[])
            panel.spines[:].set_visible(False)
    axes[0][0].set_ylabel("what the network gets")
    axes[1][0].set_ylabel("what it sees in that")
    figure.suptitle(f"{fault.description}\nCure: {fault.cure_texts[0]}", fontsize=8, x=0.01, ha="left")
    frequent = np.bincount(views[0].labels.ravel(), minlength=len(CLASSES)).argsort()[::-1][:_LEGEND]
    handles = [Patch(color=np.array(COLOURS[index]) / 255, label=CLASSES[index]) for index in frequent]
    if effects()[name].unit.startswith("pixels"):
        # in place of two classes
        handles[-2:] = [Patch(color=np.array(_EDGES) / 255, label="edges in depth")]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=7)


def _compared(signal: Signal, value: float, threshold: float) -> str:
    """Return a signal's value, its threshold, and whether there is a symptom."""
    sign = "<" if value < threshold else ">"
    symptom = ": symptom" if signal.is_beyond(value, threshold) else ""
    return f"{signal.key} {value:.3f} {sign} {threshold:.3f}{symptom}"


def _relief(depth: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint8]:
    """Return depth (H, W) in counts as grey levels (H, W, 3), light where nearer than the surroundings."""
    metres = depth.astype(np.float32) * (DEPTH_RANGE_M / 65535)
    above = np.clip((cv2.blur(metres, _NEARBY) - metres) / _RELIEF_M, -1, 1)
    grey = ((above + 1) * 127.5).astype(np.uint8)
    return np.repeat(grey[:, :, None], 3, axis=2)


def _with_edges(image: npt.NDArray[np.uint8], depth: npt.NDArray[np.uint16]) -> npt.NDArray[np.uint8]:
    """Return a colour image with the edges of the depth image, which lie on its objects if both fit."""
    metres = depth.astype(np.float32) * (DEPTH_RANGE_M / 65535)
    step = np.abs(cv2.Laplacian(metres, cv2.CV_32F, ksize=1))
    marked = image.copy()
    marked[step > 0.5 * _RELIEF_M] = _EDGES
    return marked
