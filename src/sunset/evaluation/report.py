"""Reports and lists of the runs in a folder, in any format."""

import json
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Final

from sunset.errors import InvalidInputError
from sunset.evaluation.formats import as_html, as_latex, as_text
from sunset.evaluation.intervals import DEVIATIONS, INTERVALS, Estimate
from sunset.evaluation.layout import arrange
from sunset.evaluation.report_figures import figures_as_html
from sunset.evaluation.results import FIGURES, RunRow, load_results
from sunset.evaluation.scores import ScoreTable, score_tables
from sunset.evaluation.summary import SystemRow, named_groups, summarise
from sunset.processes.workers import Progress
from sunset.texts.sentences import csv_text
from sunset_ros.texts import printable

FORMATS: Final = ("table", "latex", "csv", "json", "html")
RUNS_FORMATS: Final = ("csv", "json")

_CSV_COLUMNS: Final = (
    *("source", "suite", "system", "other", "manager", "evidence", "is_reference", "model", "duration_s"),
    *("bag_looped", "flight", "bag_checksum", "middleware", "task", "version"),
    *("runs", "runs_invalid", "runs_missing", "runs_unpaired", "runs_failed", "runs_differing"),
    *("figure", "mean", "std", "ci_low", "ci_high", "figure_runs"),
    *("pairs_won", "p_holm", "detectable", "runs_needed"),
)


def format_runs(runs: Sequence[RunRow], form: str = "table", *, every: bool = False) -> str:
    """Return the report of runs in one of `FORMATS`; as a page with its figures.

    A table or LaTeX has only the first page, unless it has `every` figure.

    Raises:
        InvalidInputError: the format is unknown.
    """
    tables = score_tables(runs)
    figures = figures_as_html(runs, tables) if form == "html" else ""
    return format_report(summarise(runs), form, tables, figures, every=every)


def format_report(
    rows: Sequence[SystemRow],
    form: str = "table",
    scores: Sequence[ScoreTable] = (),
    figures: str = "",
    *,
    every: bool = False,
) -> str:
    """Return the report of rows and scores, as in `format_runs`; `figures` are HTML for a page."""
    match form:
        case "json":
            content = {
                "scores": [table.to_json() for table in scores],
                "rows": [_json_row(row) for row in rows],
                "method": f"{DEVIATIONS} {INTERVALS}",
                "notes": arrange(rows, scores, every=True).notes,
            }
            return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
        case "csv":
            return _as_csv(rows, scores)
        case "table":
            return as_text(arrange(rows, scores, every=every))
        case "latex":
            return as_latex(arrange(rows, scores, every=every))
        case "html":
            return as_html(arrange(rows, scores, every=True), figures=figures)
    raise InvalidInputError(f"The format of a report must be one of {', '.join(FORMATS)}, got {form!r}.")


def _json_row(row: SystemRow) -> dict[str, object]:
    run = row.example
    invalid = [(run, "reason", run.reason) for run in row.all_runs if not run.valid]
    failed = [(run, "reason", run.failed) for run in row.all_runs if run.failed]
    differing = [(run, "figures", list(run.differing)) for run in row.all_runs if run.differing]
    return {
        "system": row.system,
        **{name: getattr(run, name) for name in ("suite", "manager", "model")},
        **run.flight.to_json(),
        **{name: getattr(run, name) for name in ("middleware", "task", "version")},
        "runs": row.runs,
        **{name: estimate and estimate.to_json() for name, estimate in row.estimates.items()},
        "unresolved_rate": row.unresolved_rate,
        "cured_rate": row.cured_rate,
        "fates": row.fates,
        "runs_invalid": len(invalid),
        "runs_failed": len(failed),
        "runs_differing": len(differing),
        **{
            name: [{"scenario": run.scenario, "seed": run.seed, key: value} for run, key, value in runs]
            for name, runs in (("invalid", invalid), ("failed", failed), ("differing", differing))
        },
    }


def _as_csv(rows: Sequence[SystemRow], scores: Sequence[ScoreTable]) -> str:
    """Return a line for each figure of each score, difference and row, which the column `source` distinguishes."""
    lines = [line for table in scores for line in _lead_lines(table)]
    for row in rows:
        about = {"source": "runs", **_json_row(row)}
        rates = {"unresolved_rate": row.unresolved_rate, "cured_rate": row.cured_rate}
        figures = [_cells(name, estimate) for name, estimate in row.estimates.items() if estimate]
        figures += [{"figure": name, "mean": rate} for name, rate in rates.items() if rate is not None]
        lines += [about | figure for figure in figures]
    return csv_text([_CSV_COLUMNS, *([cells.get(name) for name in _CSV_COLUMNS] for cells in lines)])


def _lead_lines(table: ScoreTable) -> Iterator[dict[str, object]]:
    """Yield the lines of scores and of differences."""
    for row in table.rows:
        about = {"source": "score", **table.about, **row.to_json()}
        figures = {"score": row.score, "harm": row.harm}
        yield from (about | _cells(name, estimate) for name, estimate in figures.items() if estimate)
    for pair in table.differences:
        names = {"system": pair.first, "other": pair.second, "runs": pair.pairs}
        about = {"source": "difference", **table.about, **names}
        if pair.score:
            yield about | _cells("score", pair.score)
        if pair.utility:
            yield about | pair.to_json() | _cells("utility", pair.utility)


def _cells(name: str, estimate: Estimate) -> dict[str, object]:
    ends = {"ci_low": estimate.low, "ci_high": estimate.high}
    return {"figure": name, "mean": estimate.mean, "std": estimate.std, **ends, "figure_runs": estimate.runs}


def render_runs(folder: Path, form: str, *, recompute: bool = False, progress: Progress | None = None) -> str:
    """Return a row for each run below a folder, in one of `RUNS_FORMATS`; arguments as in `load_results`.

    Figures that are not applicable are null, or empty cells.

    Raises:
        InvalidInputError: the format is unknown.
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
    """Return a run's row, column by column, with its folder relative to `folder`."""
    names = ("version", "valid")
    return {
        **{name: getattr(run, name) for name in ("scenario", "suite", "manager", "seed", "model")},
        **run.flight.to_json(),
        "middleware": run.middleware,
        **run.settings,
        **{name: getattr(run, name) for name in names},
        "failed": bool(run.failed),
        "reason": run.reason,
        **{name: run.metrics[name] for name in FIGURES},
        "differing": list(run.differing),
        "digest": run.digest,
        "folder": printable(run.folder.relative_to(folder).as_posix()),
    }


def index_page(runs: Sequence[RunRow], pages: Mapping[Path, str]) -> str:
    """Return the first page: the report of runs, its figures, and a table of links to `pages` (folder → page)."""
    tables = score_tables(runs)
    figures = figures_as_html(runs, tables)
    return as_html(arrange(summarise(runs), tables, every=True), _listing(runs, pages), figures)


def _listing(runs: Sequence[RunRow], pages: Mapping[Path, str]) -> str:
    """Return a table of links with a row for each scenario, and a column for each managing system."""
    names = {run.folder: name for name, group in named_groups(runs, name_suite=False) for run in group}
    systems = list(dict.fromkeys(names[run.folder] for run in runs))
    cells: dict[str, dict[str, list[str]]] = {run.scenario: {} for run in runs}
    for run in sorted(runs, key=lambda run: run.seed):
        links = cells[run.scenario].setdefault(names[run.folder], [])
        links.append(_link(run, pages.get(run.folder)))
    heads = "".join(f'<th scope="col">{escape(system)}</th>' for system in systems)
    rows = "\n".join(
        f'<tr><th scope="row">{escape(scenario)}</th>'
        + "".join(f"<td>{', '.join(row.get(system, []))}</td>" for system in systems)
        + "</tr>"
        for scenario, row in cells.items()
    )
    return f"""<h2>The runs</h2>
<p>By scenario and managing system, each run by its seed, with its IoU over all frames. A run's page replays it.</p>
<div class="scroll">
<table class="listing">
<thead><tr><th scope="col">scenario</th>{heads}</tr></thead>
<tbody>
{rows}
</tbody>
</table>
</div>"""


def _link(run: RunRow, page: str | None) -> str:
    iou = run.metrics["iou_all"]
    figure = "N/A" if iou is None else f"{iou:.2f}"
    remarks = {"invalid": not run.valid, "managing system failed": bool(run.failed)}
    remark = ", ".join(text for text, holds in remarks.items() if holds)
    outcome = "failed" if run.is_empty else f"{figure} ({remark})" if remark else figure
    text = f"{run.seed}: {outcome}"
    reasons = " ".join(filter(None, (run.reason, run.failed)))
    reason = f' title="{escape(reasons)}"' if reasons else ""
    if page is None:
        return f"<span{reason}>{escape(text)}</span>"
    return f'<a href="{escape(page)}"{reason}>{escape(text)}</a>'
