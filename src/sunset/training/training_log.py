"""The log of a training: a line of JSON every few steps."""

import json
import math
from collections.abc import Sequence
from pathlib import Path

from sunset.errors import DataError


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
