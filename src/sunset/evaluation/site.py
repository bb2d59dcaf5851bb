"""The first page of a site of stored runs: the report, and a table of links to runs."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from sunset.evaluation.figure_files import figures_as_html
from sunset.evaluation.layout import arrange
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import score_tables
from sunset.evaluation.summary import named_groups, summarise
from sunset.evaluation.webpage import as_html


def index_page(runs: Sequence[RunRow], pages: Mapping[Path, str]) -> str:
    """Return the first page: the report of runs, its figures, and a table of links to `pages` (folder → page)."""
    tables = score_tables(runs)
    figures = figures_as_html(runs, tables)
    return as_html(arrange(summarise(runs), tables, every=True), _listing(runs, pages), figures)


def _listing(runs: Sequence[RunRow], pages: Mapping[Path, str]) -> str:
    """Return a table of links with a row for each scenario, and a column for each managing system."""
    names = {run.folder: name for name, group in named_groups(runs, name_suite=False) for run in group}
    cells: dict[str, dict[str, list[RunRow]]] = {}
    for run in runs:
        cells.setdefault(run.scenario, {}).setdefault(names[run.folder], []).append(run)
    systems = list(dict.fromkeys(system for row in cells.values() for system in row))
    heads = "".join(f'<th scope="col">{escape(system)}</th>' for system in systems)
    rows = "\n".join(
        f'<tr><th scope="row">{escape(scenario)}</th>'
        + "".join(f"<td>{_links(row.get(system, []), pages)}</td>" for system in systems)
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


def _links(runs: Sequence[RunRow], pages: Mapping[Path, str]) -> str:
    return ", ".join(_link(run, pages.get(run.folder)) for run in sorted(runs, key=lambda run: run.seed))


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
