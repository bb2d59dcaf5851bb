"""The runs themselves, a row each: for tables and tests of one's own."""

import json
from pathlib import Path
from typing import Final

from sunset.errors import InvalidInputError
from sunset.evaluation.results import FIGURES, RunRow, load_results
from sunset.processes.workers import Progress
from sunset.texts import csv_text, printable

RUNS_FORMATS: Final = ("csv", "json")


def render_runs(folder: Path, form: str, *, recompute: bool = False, progress: Progress | None = None) -> str:
    """Return a row for each run below a folder, those that do not count included.

    Figures have the names and units of a run's `metrics`; one that is not applicable is null, or an empty cell. Those
    that were computed again and are stored otherwise are named as `differing`. The folder of a run is given relative to
    `folder`. The arguments are those of `render_report`, and the formats `RUNS_FORMATS`.

    Raises:
        RecordError: there is no run, or one is damaged.
        InvalidInputError: there is no such format.
    """
    if form not in RUNS_FORMATS:
        raise InvalidInputError(
            f"The format of a list of runs must be {' or '.join(RUNS_FORMATS)}, got {form!r}; name one with --format."
        )
    rows = [run_fields(run, folder) for run in load_results(folder, again=recompute, progress=progress)]
    if form == "json":
        return json.dumps({"runs": rows}, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    cells = (
        [" ".join(value) if isinstance(value, list) else value for value in row.values()] for row in rows
    )
    return csv_text([rows[0], *cells])


def run_fields(run: RunRow, folder: Path) -> dict[str, object]:
    """Return a run's row, column by column; its folder relative to `folder`."""
    names = ("middleware", "task", "thinking_s", "version", "valid")
    return {
        **{name: getattr(run, name) for name in ("scenario", "suite", "manager", "seed", "model")},
        **run.flight.to_json(),
        **{name: getattr(run, name) for name in names},
        "failed": bool(run.failed),
        "reason": run.reason,
        **{name: run.metrics[name] for name in FIGURES},
        "differing": list(run.differing),
        "digest": run.digest,
        "folder": printable(run.folder.relative_to(folder).as_posix()),
    }
