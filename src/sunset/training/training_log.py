"""The log of a training, a line of JSON every few steps, and its figure: loss and IoU by step."""

import json
import math
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import Any, Final

from sunset.errors import DataError
from sunset.figures import BLUE, ORANGE, check_figure, drawing, save_figure
from sunset.input_files import read_text

_NO_LOSSES: Final = frozenset({"step", "learning_rate", "seconds", "iou"})
_COLOURS: Final = (BLUE, ORANGE, "#009E73", "#CC79A7")


def draw_log(log: Path, png: Path) -> None:
    """Draw the loss and the IoU on held-out frames, by step, for each network in a training's log.

    The log is `log.jsonl` of a stage of a training, finished or not.

    Raises:
        MissingExtraError: matplotlib is not installed.
        DataError: there is no such log, or the file is not one.
        OutputError: the figure cannot be written.
    """
    check_figure(png)
    lines = _read(log)
    with drawing() as new_figure:
        figure = new_figure(figsize=(8, 3), dpi=120, layout="constrained")
        losses, ious = figure.subplots(1, 2)
        names = [name for name in lines[0] if name not in _NO_LOSSES]
        measured = [line for line in lines if "iou" in line]
        for name, colour, dashes in zip(names, cycle(_COLOURS), cycle(("-", "--", "-.", ":")), strict=False):
            style = {"color": colour, "linestyle": dashes, "label": name, "linewidth": 1.2}
            steps = [(line["step"], line[name]) for line in lines]
            losses.plot(*zip(*steps, strict=True), **style)
            held_out = [(line["step"], line["iou"][name]) for line in measured if name in line["iou"]]
            if held_out:
                ious.plot(*zip(*held_out, strict=True), marker=".", **style)
        for axes, title in ((losses, "loss on training frames"), (ious, "IoU on held-out frames")):
            axes.set_title(title, fontsize=10)
            axes.set_xlabel("step")
            axes.set_ylim(bottom=0)
            axes.grid(linewidth=0.4, alpha=0.5)
            axes.spines[["top", "right"]].set_visible(False)
        losses.legend(frameon=False)
        save_figure(figure, png, make_folder=False)


def _read(log: Path) -> list[dict[str, Any]]:
    try:
        lines = [json.loads(line) for line in read_text(log).splitlines()]
    except OSError as error:
        raise DataError(f"The training log {log} cannot be read: {error.strerror}.") from error
    except ValueError as error:
        raise DataError(f"{log} is not a training log: a line is not JSON ({error}).") from error
    if not lines or not all(isinstance(line, dict) and "step" in line for line in lines):
        raise DataError(
            f"The training log {log} must have lines with a step each, as a training writes them."
        )
    return lines


def truncate_log(path: Path, step: int, learned: Sequence[str]) -> None:
    """Drop lines after a step, which a resumed run writes again, and what was being written at the end.

    What is drawn and told of a training, the losses of what is learned too, must be in every line.
    """
    try:
        text = path.read_text(encoding="utf-8") if step and path.exists() else ""
        lines = [line for line in text.splitlines(keepends=True) if line.endswith("\n")]
        read = [json.loads(line) for line in lines]
        names = {"step", "seconds", *learned}.union(*read[:1]) - {"iou"}
        for found in read:
            values = [*(found[name] for name in names), *{**found.get("iou", {})}.values()]
            if not all(map(math.isfinite, values)):
                raise ValueError(f"a number at step {found['step']} is not finite")  # noqa: TRY301
        kept = [line for line, found in zip(lines, read, strict=True) if found["step"] <= step]
    except (KeyError, OverflowError, RecursionError, TypeError, ValueError) as error:
        raise DataError(
            f"The training log {path} is damaged ({type(error).__name__}: {error}): delete its damaged lines."
        ) from error
    path.write_text("".join(kept), encoding="utf-8")
