"""Pictures of faults."""

import tempfile
from pathlib import Path
from typing import Any, Final, Unpack

from sunset import experiments
from sunset.api.arguments import as_path, check_progress, extended, whole_of
from sunset.api.options import run_spec_of
from sunset.data import default_flight
from sunset.errors import InvalidInputError
from sunset.evaluation.figures import entropy_figure, outage_figure
from sunset.experiments import Options, RunSpec, Settings
from sunset.files.plots import check_figure, drawing, save_figure
from sunset.metrics import Samples
from sunset.perception import load_model
from sunset.processes.workers import Progress, Stages
from sunset.system import ENTROPY_SIGNAL, Fault, current_system, get_fault

OUTAGE_S: Final = 8.0
"""How much of an outage is drawn, from the injection on, if no duration is given [s]."""


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
        **options: as of `run`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        SunsetError: the fault or the frame does not exist, or as `run`.
    """
    preparing = options.get("preparing")
    check_progress(preparing)
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
        _draw_effect(drawn, file, spec.settings, frame)
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


def _draw_effect(fault: Fault, file: Path, settings: Settings, frame: int | None) -> None:
    from sunset.api.frame_pictures import fault_views, views_figure  # noqa: PLC0415  slow

    model = load_model(settings.model)
    views = fault_views(fault.name, model, settings.bag or default_flight(), frame)
    figure = views_figure(views, fault.name, model)
    with drawing():
        save_figure(figure, file)


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
        **options: as of `run`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        SunsetError: as `run`.
    """
    check_progress(progress, options.get("preparing"))
    file = as_path(out, "figure's file")
    with extended(options.get("extensions", ())):
        check_figure(file)
        _draw_entropy(file, whole_of(seed), options, progress)
    return file


def _draw_entropy(file: Path, seed: int, options: Any, progress: Progress | None) -> None:
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
