"""The runs themselves, a row each: for tables and tests of one's own."""

import csv
import io
import json
from pathlib import Path
from typing import Final

from sunset.errors import InvalidInputError
from sunset.evaluation.results import FIGURES, Progress, RunRow, load_results

__all__ = ["RUNS_FORMATS", "render_runs"]

RUNS_FORMATS: Final = ("csv", "json")


def render_runs(folder: Path, form: str, *, recompute: bool = False, progress: Progress | None = None) -> str:
    """Return a row for each run below a folder, those that do not count included.

    Figures have the names and units of a run's `metrics`; one that is not applicable is null, or an empty cell. The
    folder of a run is given relative to `folder`.

    Args:
        folder: of one run, of a campaign, or of several.
        form: one of `RUNS_FORMATS`.
        recompute: compute every figure from the recorded messages instead of reading the stored ones.
        progress: called with (runs that are read, runs in all).

    Raises:
        RecordError: there is no run, or one is damaged.
        InvalidInputError: there is no such format.
    """
    if form not in RUNS_FORMATS:
        raise InvalidInputError(
            f"The format of a list of runs must be {' or '.join(RUNS_FORMATS)}, got {form!r}; name one with --format."
        )
    rows = [_row(run, folder) for run in load_results(folder, again=recompute, progress=progress)]
    if form == "json":
        return json.dumps({"runs": rows}, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(rows[0])
    writer.writerows(
        [json.dumps(cell) if isinstance(cell, bool) else cell for cell in row.values()] for row in rows
    )
    return out.getvalue()


def _row(run: RunRow, folder: Path) -> dict[str, object]:
    return {
        "scenario": run.scenario,
        "suite": run.suite,
        "manager": run.manager,
        "seed": run.seed,
        "model": run.model,
        "middleware": run.middleware,
        "valid": run.valid,
        "failed": run.failed,
        "reason": run.reason,
        **{name: run.metrics[name] for name in FIGURES},
        "digest": run.digest,
        "folder": run.folder.relative_to(folder).as_posix(),
    }
