"""The figures of a report as a part of its page."""

from collections.abc import Iterable, Sequence
from html import escape

from sunset.evaluation.chart_drawing import looks_of, panels_as_svg, swatches
from sunset.evaluation.charts import Chart
from sunset.evaluation.panel_drawing import Looks
from sunset.figures import NEEDS_MATPLOTLIB, can_draw
from sunset.texts import printable


def charts_as_html(charts: Sequence[Chart]) -> str:
    """Return figures as a part of a page, each with its data; without matplotlib, the data only."""
    looks = looks_of(charts)
    drawn = can_draw()
    lacking = "" if drawn else f"\n<p>{escape(NEEDS_MATPLOTLIB)} Their data is here.</p>"
    figures = "\n".join(_figure(chart, looks, drawn=drawn) for chart in charts)
    return f"<h2>Figures</h2>{lacking}\n{figures}"


def _figure(chart: Chart, looks: Looks, *, drawn: bool) -> str:
    missing = _lines(f'<p class="missing">{escape(printable(text))}</p>' for text in chart.missing)
    legend = panels = data = ""
    if drawn and chart.panels:
        entries = _lines(
            f"<span>{swatch} {escape(printable(name))}</span>"
            for name, swatch in zip(chart.legend, swatches(chart, looks), strict=True)
        )
        legend = f'<div class="legend">\n{entries}</div>\n' if entries else ""
        panels = f'<div class="panels">\n{_lines(panels_as_svg(chart, looks))}</div>\n'
    if chart.lines:
        data = f"<details><summary>Data as CSV</summary><pre>{escape(printable(chart.as_csv()))}</pre></details>\n"
    return (
        f'<figure id="{chart.name}">\n<figcaption><h3>{escape(chart.title)}</h3><p>{escape(chart.meaning)}</p>\n'
        f"{missing}</figcaption>\n{legend}{panels}{data}</figure>"
    )


def _lines(texts: Iterable[str]) -> str:
    return "".join(f"{text}\n" for text in texts)
