"""The report as a self-contained HTML page, also with links to the pages of its runs."""

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Final

from sunset.evaluation.blocks import PAPER_LABEL, Block, Report
from sunset.evaluation.layout import arrange
from sunset.evaluation.report_figures import figures_as_html
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import score_tables
from sunset.evaluation.summary import named_groups, summarise

_STYLE: Final = """
:root { color-scheme: light dark; --ink: #1b1b1b; --soft: #666; --line: #ccc; --paper: #fff; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8e8; --soft: #a0a0a0; --line: #444; --paper: #16181a; }
}
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  max-width: 68rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2.5rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .35rem .5rem; text-align: left; white-space: nowrap; }
thead th { border-bottom: 2px solid var(--ink); vertical-align: bottom; }
tbody { border-bottom: 1px solid var(--line); }
tbody th { font-weight: 600; min-width: 11rem; white-space: normal; overflow-wrap: anywhere; }
td.runs, th.runs { text-align: right; }
.listing tbody th { font-weight: 400; }
a { color: inherit; }
dt { font-weight: 600; } dd { margin: 0 0 .5rem 1.5rem; }
li { margin-bottom: .35rem; overflow-wrap: anywhere; }
figure { margin: 0 0 2.5rem; } figcaption h3 { font-size: 1rem; margin-bottom: .25rem; }
figcaption p { margin: .25rem 0; max-width: 50rem; overflow-wrap: anywhere; } .missing { color: var(--soft); }
figure svg { width: 100%; min-width: 42rem; height: auto; }
figure svg.column { min-width: 21rem; max-width: 33rem; }
figure pre { overflow: auto; max-height: 20rem; font-size: .8rem; }
@media print {
  :root { color-scheme: light; --ink: #1b1b1b; --soft: #666; --line: #ccc; --paper: #fff; }
  body { max-width: none; margin: 0; padding: 0; font-size: 10pt; } .scroll { overflow: visible; }
  table { font-size: 8pt; } th, td { padding: .2rem .4rem; }
  tr, figure { break-inside: avoid; }
  h2, h3, figcaption, dt { break-after: avoid; } details { display: none; }
}
"""


def as_html(report: Report, more: str = "", figures: str = "") -> str:
    """Return a report as a page of HTML, with `more` HTML behind its tables, and `figures` before the paper's."""
    parts = [_table(block) for block in report.blocks]
    labels = [block.label for block in report.blocks]
    parts.insert(labels.index(PAPER_LABEL) if PAPER_LABEL in labels else len(parts), figures)
    tables = "\n".join(filter(None, parts))
    columns = dict.fromkeys(column for block in report.blocks for column in block.columns)
    meanings = "\n".join(f"<dt>{escape(text)}</dt><dd>{escape(meaning)}</dd>" for text, meaning in columns)
    notes = "\n".join(f"<li>{escape(note)}</li>" for note in report.notes)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'">
<title>SUNSET: comparison of managing systems</title>
<style>{_STYLE}</style>
</head>
<body>
<h1>SUNSET: comparison of managing systems</h1>
{tables}
{more}
<h2>Notes</h2>
<ul>
{notes}
</ul>
<h2>The columns</h2>
<dl>
{meanings}
</dl>
</body>
</html>
"""


def _table(block: Block) -> str:
    heads = "".join(
        f'<th scope="col" title="{escape(column.meaning)}">{escape(column.text)}</th>'
        for column in block.columns
    )
    body = "\n".join(
        f'<tr><th scope="row">{label}</th><td class="runs">{runs}</td>'
        + "".join(f"<td>{cell}</td>" for cell in cells)
        + "</tr>"
        for label, runs, *cells in (map(escape, row) for row in block.rows())
    )
    return (
        f'<h2>{escape(block.title)}</h2>\n<div class="scroll">\n<table>\n<thead><tr>'
        f'<th scope="col">system</th><th scope="col" class="runs">runs</th>{heads}</tr></thead>'
        f"\n<tbody>\n{body}\n</tbody>\n</table>\n</div>"
    )


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
