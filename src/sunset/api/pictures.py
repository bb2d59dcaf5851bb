"""Pictures of single faults."""

import tempfile
from pathlib import Path
from typing import Final, Unpack

from sunset import experiments
from sunset.api.options import Options, as_path, extended, settings_of
from sunset.data import default_flight
from sunset.errors import InvalidInputError
from sunset.evaluation import outage_figure
from sunset.experiments import RunSpec, Settings
from sunset.figures import check_figure, drawing, save_figure
from sunset.perception import load_model
from sunset.scenarios import load_scenario
from sunset.system import current_system, get_fault

OUTAGE_S: Final = 8.0
"""How much of an outage is drawn, from the injection on, unless another duration is asked for."""


def fault_picture(
    fault: str, out: str | Path, *, frame: int | None = None, **options: Unpack[Options]
) -> Path:
    """Draw what one fault does and what cures it, as `sunset faults show FAULT --figure FILE` does.

    A fault that degrades images is drawn on one frame: without it, with it and after its cheapest cure, with what the
    network makes of that. An outage stops messages, so that it is drawn over the time of a run that `reactive` manages.

    Args:
        fault: its name.
        out: a .png, .pdf or .svg, which is replaced.
        frame: which one of the flight, from 0 on; the one in its middle if None.
        **options: those of `sunset.Options`, as of `run`.

    Raises:
        MissingExtraError: matplotlib is not installed.
        SunsetError: there is no such fault or frame, or as `run`.
    """
    file = as_path(out, "figure's file")
    with extended(options.get("extensions", ())):
        options.setdefault("duration", OUTAGE_S)
        draw_fault_picture(fault, file, settings_of(options), frame)
    return file


def draw_fault_picture(name: str, file: Path, settings: Settings, frame: int | None) -> None:
    """Draw one fault; as `fault_picture`."""
    check_figure(file)
    fault = get_fault(name)
    if fault.effect is not None:
        from sunset.api.frame_pictures import fault_views, views_figure  # noqa: PLC0415  takes long to import

        model = load_model(settings.model)
        views = fault_views(name, model, settings.bag or default_flight(), frame)
        figure = views_figure(views, name, model)
        with drawing():
            save_figure(figure, file)
    elif fault.failure in current_system().outages:
        if frame is not None:
            raise InvalidInputError(
                f"The fault {name} stops messages: it is drawn over time; leave out --frame."
            )
        spec = RunSpec(scenario=load_scenario(name), manager="reactive", settings=settings)
        with tempfile.TemporaryDirectory(prefix="sunset-") as folder:
            run = experiments.run(spec, Path(folder) / "run")
        title = f"{fault.description}\nEach line is a message, each bar a silence. The managing system is reactive."
        topics = [failure.topic for failure in current_system().failures.values() if failure.topic]
        outage_figure(run.timeline, run.metrics.executed, file, topics=topics, title=title)
    else:
        raise InvalidInputError(
            f"There is nothing to draw of the fault {name}: it stops no messages, and no effect on images is known."
        )
