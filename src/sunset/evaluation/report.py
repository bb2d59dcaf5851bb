"""From a folder of runs to a report, in the format that is asked for."""

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Final

from sunset.errors import InvalidInputError
from sunset.evaluation.differences import DIFFERENCE_METHOD
from sunset.evaluation.estimates import METHOD, Estimate
from sunset.evaluation.figure_files import figures_as_html
from sunset.evaluation.latex import as_latex
from sunset.evaluation.layout import arrange
from sunset.evaluation.results import FIGURES, RunRow, load_results
from sunset.evaluation.scores import SCORE_METHOD, ScoreTable, score_tables
from sunset.evaluation.summary import PUBLISHED, PUBLISHED_SOURCE, SystemRow, published_names, summarise
from sunset.evaluation.text import as_text
from sunset.evaluation.treatments import TimeToCure, cured_rate, fates, times_to_cure
from sunset.evaluation.webpage import as_html
from sunset.texts import csv_text
from sunset.workers import Progress

_PARTS: Final = ("mean", "std", "ci_low", "ci_high", "runs")
FORMATS: Final = ("table", "latex", "csv", "json", "html")

_LEAD_COLUMNS: Final = (
    *(f"{name}_{part}" for name in ("score", "harm") for part in _PARTS),
    *("runs_unpaired", "is_reference", "other", "a12", "p_holm", "told", "runs_needed"),
)
"""Columns of the lines that scores and differences have in CSV, beside those of the table."""


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
    runs = load_results(folder, again=recompute, progress=progress)
    return format_runs(runs, form)


def format_runs(runs: Sequence[RunRow], form: str = "table") -> str:
    """Return the report of runs in one of `FORMATS`; a page has figures.

    Raises:
        InvalidInputError: there is no such format.
    """
    tables = score_tables(runs)
    figures = figures_as_html(runs, tables) if form == "html" else ""
    return format_report(summarise(runs), form, tables, figures)


def format_report(
    rows: Sequence[SystemRow],
    form: str = "table",
    scores: Sequence[ScoreTable] = (),
    figures: str = "",
) -> str:
    """Return the report of a table's rows in one of `FORMATS`.

    Args:
        rows: those of the table.
        form: one of `FORMATS`.
        scores: what it leads with.
        figures: those of a page, as HTML.

    Raises:
        InvalidInputError: there is no such format.
    """
    match form:
        case "json":
            return _as_json(rows, scores)
        case "csv":
            return _as_csv(rows, scores)
        case "table":
            return as_text(arrange(rows, scores))
        case "latex":
            return as_latex(arrange(rows, scores))
        case "html":
            return as_html(arrange(rows, scores), figures=figures)
    raise InvalidInputError(f"The format of a report must be one of {', '.join(FORMATS)}, got {form!r}.")


def _as_json(rows: Sequence[SystemRow], scores: Sequence[ScoreTable]) -> str:
    published = [
        {"system": name}
        | {figure: {"mean": mean, "std": std} for figure, (mean, std) in PUBLISHED[name].items()}
        for name in published_names(rows)
    ]
    content: dict[str, object] = {
        "scores": [table.to_json() for table in scores],
        "rows": [_json_row(row) for row in rows],
        "published": {"source": PUBLISHED_SOURCE, "rows": published},
        "method": METHOD,
        "notes": arrange(rows, scores).notes,
    }
    if scores:
        content |= {"score_method": SCORE_METHOD, "difference_method": DIFFERENCE_METHOD}
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
        "cured_rate": cured_rate(row),
        "time_to_cure": {failure: found.to_json() for failure, found in _times(row).items()},
        "fates": {fault: dict(found) for fault, found in fates(row.outcomes).items()},
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
        "by_paper_script": row.by_paper_script and row.by_paper_script.to_json(),
    }


def _as_csv(rows: Sequence[SystemRow], scores: Sequence[ScoreTable]) -> str:
    """Return a line for each score, difference and row, then the paper's; a cell is empty where there is no figure.

    The column `source` says what a line is: `score`, `difference`, `ours` or `published`.
    """
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
    failures = sorted({failure for row in rows for failure in _times(row)})
    names = [*head, *columns, "unresolved_rate", "cured_rate", *map(_time_column, failures), *_LEAD_COLUMNS]
    lines: list[dict[str, object]] = [line for table in scores for line in _lead_lines(table)]
    for row in rows:
        cells: dict[str, object] = {
            **_described(row),
            "source": "ours",
            "runs_invalid": len(row.invalid),
            "runs_failed": len(row.failed),
            "runs_differing": len(row.differing),
            "unresolved_rate": row.unresolved_rate,
            "cured_rate": cured_rate(row),
            **{_time_column(failure): found.mean_s for failure, found in _times(row).items()},
        }
        for name, found in row.estimates.items():
            if found is not None:
                cells |= _cells(name, found)
        lines.append(cells)
    for name in published_names(rows):
        cells = {"system": name, "source": "published"}
        for figure, pair in PUBLISHED[name].items():
            cells |= dict(zip(_parts(figure)[:2], pair, strict=True))
        lines.append(cells)
    return csv_text([names, *([cells.get(name) for name in names] for cells in lines)])


def _times(row: SystemRow) -> Mapping[str, TimeToCure]:
    return times_to_cure(row.outcomes, row.flight.duration_s)


def _time_column(failure: str) -> str:
    return f"t_cure_{failure}_s"


def _lead_lines(table: ScoreTable) -> Iterator[dict[str, object]]:
    """Give the lines of scores and of differences."""
    for row in table.rows:
        line = {"system": row.system, "source": "score", "suite": table.suite, "manager": row.manager}
        yield line | {
            "runs": row.runs,
            "runs_invalid": row.invalid,
            **_cells("score", row.score),
            **_cells("harm", row.harm),
            "runs_unpaired": row.unpaired,
            "is_reference": row.is_reference,
        }
    for difference in table.differences:
        line = {
            "system": difference.first,
            "source": "difference",
            "suite": table.suite,
            "other": difference.second,
        }
        yield line | {
            "runs": difference.pairs,
            **_cells("score", difference.score),
            **_cells("iou_net", difference.iou_net),
            "a12": difference.a12,
            "p_holm": difference.p,
            "told": difference.told,
            "runs_needed": difference.runs_needed,
        }


def _cells(name: str, found: Estimate | None) -> dict[str, object]:
    if found is None:
        return {}
    parts = (found.mean, found.std, found.low, found.high, found.runs)
    return dict(zip(_parts(name), parts, strict=True))


def _parts(name: str) -> tuple[str, ...]:
    return tuple(f"{name}_{part}" for part in _PARTS)
