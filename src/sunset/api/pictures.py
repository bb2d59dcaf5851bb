"""Pictures of faults: on a frame without the fault, with it and after its cure, or over the time of a run."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Final, Unpack

import cv2
import numpy as np
import numpy.typing as npt

from sunset import experiments
from sunset.api.arguments import as_path, extended, whole_of
from sunset.api.options import run_spec_of
from sunset.calibration import Condition, effects, suite_strengths
from sunset.classes import CLASS_OF_CARLA_ID, CLASSES, COLOURS, PALETTE
from sunset.data import DEPTH_RANGE_M, Frame, default_flight, read_bag
from sunset.errors import InvalidInputError
from sunset.evaluation.figures import entropy_figure, outage_figure
from sunset.experiments import Options, RunSpec
from sunset.files.plots import check_figure, drawing, save_figure
from sunset.metrics import Samples, count_classes, image_iou
from sunset.perception import Modality, Model, Segmenter, load_model
from sunset.processes.workers import Progress, Stages
from sunset.system import ENTROPY_SIGNAL, SHARPNESS_SIGNAL, Fault, Signal, current_system, get_fault
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


OUTAGE_S: Final = 8.0
"""How much of an outage is drawn, from the injection on, if no duration is given [s]."""


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """A frame in a condition: an image for the reader (H, W, 3) uint8 in RGB, and labels (H, W) uint8, class indices.

    IoU and entropy are in [0, 1]; the IoU is NaN where the frame lacks labels.
    """

    title: str
    image: npt.NDArray[np.uint8]
    labels: npt.NDArray[np.uint8]
    iou: float
    entropy: float
    sharpness: float


def fault_picture(
    fault: str, out: str | Path, *, frame: int | None = None, **options: Unpack[Options]
) -> Path:
    """Draw the effect of a fault and of its cure, as `sunset faults show FAULT --figure FILE` does.

    A fault that degrades images is drawn on a frame: without it, with it and after its cheapest cure, with the
    network's results. An outage stops messages, so it is drawn over the time of a run that `reactive` manages.

    Args:
        fault: its name.
        out: a .png, .pdf or .svg, which is replaced.
        frame: number of the flight's frame, from 0 on; the frame in its middle if None.
        **options: as in `run`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        SunsetError: the fault or the frame does not exist, or as `run`.
    """
    preparing = options.get("preparing")
    file = as_path(out, "figure's file")
    with extended(options.get("extensions", ())):
        check_figure(file)
        drawn = get_fault(fault)
        _check_drawable(drawn, frame)
        spec = run_spec_of(drawn.name, "reactive", 1, {"duration": OUTAGE_S, **options})
        if drawn.effect is None:
            _draw_outage(drawn, file, spec, preparing)
            return file
        if preparing is not None:
            experiments.prepare_runs([spec], preparing)
            preparing("Drawing", 0, 0)
        model = load_model(spec.settings.model)
        views = _fault_views(drawn.name, model, spec.settings.bag or default_flight(), frame)
        with drawing({"font.size": 8}) as new_figure:
            figure = new_figure(figsize=(7.2, 3.7), dpi=140, layout="constrained")
            _fill(figure, views, drawn, model)
        with drawing():
            save_figure(figure, file)
    return file


def _check_drawable(fault: Fault, frame: int | None) -> None:
    if fault.effect is not None:
        return
    if fault.failure not in current_system().outages:
        raise InvalidInputError(
            f"There is nothing to draw of the fault {fault.name}: it stops no messages, and no effect on images is "
            "known."
        )
    if frame is not None:
        raise InvalidInputError(
            f"The fault {fault.name} stops messages: it is drawn over time; leave out --frame."
        )


def _draw_outage(fault: Fault, file: Path, spec: RunSpec, preparing: Stages | None) -> None:
    with tempfile.TemporaryDirectory(prefix="sunset-") as folder:
        run = experiments.run(spec, Path(folder) / "run", preparing=preparing)
    title = (
        f"{fault.description}\nEach line is a message, each bar a silence. The managing system is reactive."
    )
    topics = [failure.topic for failure in current_system().failures.values() if failure.topic]
    outage_figure(run.timeline, run.metrics.executed, file, topics=topics, title=title)


def fault_figure(
    out: str | Path, *, seed: int = 1, progress: Progress | None = None, **options: Unpack[Options]
) -> Path:
    """Draw the entropy over time without a fault and with each that shows in it, as `sunset faults figure` does.

    Args:
        out: a .png, .pdf or .svg.
        seed: of the runs.
        progress: called with (finished runs, all runs).
        **options: as in `run`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        SunsetError: as `run`.
    """
    file = as_path(out, "figure's file")
    with extended(options.get("extensions", ())):
        check_figure(file)
        _draw_entropy(file, whole_of(seed), options, progress)
    return file


def _draw_entropy(file: Path, seed: int, options: Options, progress: Progress | None) -> None:
    system = current_system()
    faults = [
        name
        for name, fault in system.faults.items()
        if system.failures[fault.failure].signal == ENTROPY_SIGNAL.name
    ]
    series, iou, threshold = {}, {}, 0.0
    with tempfile.TemporaryDirectory(prefix="sunset-") as folder:
        for done, name in enumerate(["nofault", *faults]):
            spec = run_spec_of(name, "none", seed, options)
            preparing = None if done else options.get("preparing")
            timeline = experiments.run(spec, Path(folder) / name, preparing=preparing).timeline
            label = name.replace("nofault", "no fault")
            series[label] = timeline.samples[ENTROPY_SIGNAL.name]
            iou[label] = Samples(timeline.frames.times, timeline.frames.iou)
            threshold = timeline.thresholds["entropy_threshold"]
            if progress is not None:
                progress(done + 1, len(faults) + 1)
    entropy_figure(series, threshold, file, iou=iou)


def _fault_views(fault: str, model: Model, bag: Path, frame: int | None = None) -> tuple[_View, ...]:
    """Return a frame without a fault, with the fault at the strength of the suites, and after its cheapest cure.

    The frame is resampled to the size of the model; its number counts from 0, and is the middle of the bag if None.
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
) -> _View:
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
    return _View(title, image, result.labels, iou, result.entropy, seen.sharpness)


def _fill(figure: "Figure", views: Sequence[_View], fault: Fault, model: Model) -> None:
    from matplotlib.patches import Patch  # noqa: PLC0415  an optional extra

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
    if effects()[fault.name].unit.startswith("pixels"):
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
