"""From stored records to tables, figures and reports; nothing is run."""

from sunset.evaluation.estimates import METHOD, Estimate, estimate
from sunset.evaluation.figures import check_figure, entropy_figure
from sunset.evaluation.report import FORMATS, format_report, render_report
from sunset.evaluation.results import FIGURES, RunRow, load_results, recompute
from sunset.evaluation.summary import PUBLISHED, PUBLISHED_SOURCE, SystemRow, summarise

__all__ = [
    "FIGURES",
    "FORMATS",
    "METHOD",
    "PUBLISHED",
    "PUBLISHED_SOURCE",
    "Estimate",
    "RunRow",
    "SystemRow",
    "check_figure",
    "entropy_figure",
    "estimate",
    "format_report",
    "load_results",
    "recompute",
    "render_report",
    "summarise",
]
