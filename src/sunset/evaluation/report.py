"""From a folder of runs to a report, in the format that is asked for."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from sunset.errors import InvalidInputError
from sunset.evaluation.estimates import METHOD
from sunset.evaluation.latex import as_latex
from sunset.evaluation.layout import arrange
from sunset.evaluation.results import FIGURES, load_results
from sunset.evaluation.summary import PUBLISHED, PUBLISHED_SOURCE, SystemRow, published_names, summarise
from sunset.evaluation.text import as_text
from sunset.evaluation.webpage import as_html
from sunset.texts import csv_text
from sunset.workers import Progress

FORMATS: Final = ("table", "latex", "csv", "json", "html")


def render_report(
    folder: Path, form: str = "table", *, recompute: bool = False, progress: Progress | None = None
) -> str:
    """Return the report of all runs below a folder.

    Args:
        folder: of one run, of a campaign, or of several.
        form: one of `FORMATS`.
        recompute: compute every figure from the recorded messages instead of reading the stored ones.
        progress: called with (runs that are read, runs in all).

    Raises:
        RecordError: there is no run, or one is damaged.
        InvalidInputError: there is no such format.
    """
    return format_report(summarise(load_results(folder, again=recompute, progress=progress)), form)


def format_report(rows: Sequence[SystemRow], form: str = "table") -> str:
    """Return the report of a table's rows in one of `FORMATS`.

    Raises:
        InvalidInputError: there is no such format.
    """
    match form:
        case "json":
            return _as_json(rows)
        case "csv":
            return _as_csv(rows)
        case "table":
            return as_text(arrange(rows))
        case "latex":
            return as_latex(arrange(rows))
        case "html":
            return as_html(arrange(rows))
    raise InvalidInputError(f"The format of a report must be one of {', '.join(FORMATS)}, got {form!r}.")


def _as_json(rows: Sequence[SystemRow]) -> str:
    published = [
        {"system": name}
        | {figure: {"mean": mean, "std": std} for figure, (mean, std) in PUBLISHED[name].items()}
        for name in published_names(rows)
    ]
    content = {
        "rows": [_json_row(row) for row in rows],
        "published": {"source": PUBLISHED_SOURCE, "rows": published},
        "method": METHOD,
    }
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _described(row: SystemRow) -> dict[str, object]:
    """Return what a row is about."""
    return {
        "system": row.system,
        "suite": row.suite,
        "manager": row.manager,
        "model": row.model,
        **row.flight.to_json(),
        "middleware": row.middleware,
        "version": row.version,
        "runs": row.runs,
    }


def _json_row(row: SystemRow) -> dict[str, object]:
    return {
        **_described(row),
        **{name: found and found.to_json() for name, found in row.estimates.items()},
        "unresolved_rate": row.unresolved_rate,
        "runs_invalid": len(row.invalid),
        "runs_failed": len(row.failed),
        "invalid": [
            {"scenario": run.scenario, "seed": run.seed, "reason": run.reason} for run in row.invalid
        ],
        "failed": [{"scenario": run.scenario, "seed": run.seed, "reason": run.failed} for run in row.failed],
        "differing": [
            {"scenario": run.scenario, "seed": run.seed, "figures": list(run.differing)}
            for run in row.differing
        ],
        "published": row.published,
    }


def _as_csv(rows: Sequence[SystemRow]) -> str:
    """Return one line a row, then the paper's rows; a cell is empty where a figure is not applicable."""
    head = [
        "system",
        "source",
        "suite",
        "manager",
        "model",
        "duration_s",
        "bag_looped",
        "flight",
        "bag_checksum",
    ]
    head += ["middleware", "version", "runs", "runs_invalid", "runs_failed", "runs_differing"]
    columns = [part for name in FIGURES for part in _parts(name)]
    names = [*head, *columns, "unresolved_rate"]
    lines: list[dict[str, object]] = []
    for row in rows:
        cells: dict[str, object] = {
            **_described(row),
            "source": "ours",
            "runs_invalid": len(row.invalid),
            "runs_failed": len(row.failed),
            "runs_differing": len(row.differing),
            "unresolved_rate": row.unresolved_rate,
        }
        for name, found in row.estimates.items():
            if found is not None:
                parts = (found.mean, found.std, found.low, found.high, found.runs)
                cells |= dict(zip(_parts(name), parts, strict=True))
        lines.append(cells)
    for name in published_names(rows):
        cells = {"system": name, "source": "published"}
        for figure, pair in PUBLISHED[name].items():
            cells |= dict(zip(_parts(figure)[:2], pair, strict=True))
        lines.append(cells)
    return csv_text([names, *([cells.get(name) for name in names] for cells in lines)])


def _parts(name: str) -> tuple[str, ...]:
    return tuple(f"{name}_{part}" for part in ("mean", "std", "ci_low", "ci_high", "runs"))
