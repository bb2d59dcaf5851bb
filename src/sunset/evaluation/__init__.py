"""Tables, figures and reports of stored records; nothing is run."""

from sunset.evaluation.agreement import Agreement, LeftOut, Pair, agrees, compare
from sunset.evaluation.agreement_report import AGREEMENT_FORMATS, format_agreement
from sunset.evaluation.figure_files import WrittenFigures, write_figures
from sunset.evaluation.figures import entropy_figure, outage_figure
from sunset.evaluation.intervals import Cluster, Estimate, estimate
from sunset.evaluation.paired import Difference, PairedComparison, compare_managers
from sunset.evaluation.report import (
    FORMATS,
    RUNS_FORMATS,
    format_report,
    format_runs,
    render_report,
    render_runs,
    run_fields,
)
from sunset.evaluation.results import FIGURES, Flight, RunRow, load_results
from sunset.evaluation.scores import ScoreRow, ScoreTable, score_tables
from sunset.evaluation.summary import SystemRow, summarise
from sunset.evaluation.webpage import index_page

__all__ = [
    "AGREEMENT_FORMATS",
    "FIGURES",
    "FORMATS",
    "RUNS_FORMATS",
    "Agreement",
    "Cluster",
    "Difference",
    "Estimate",
    "Flight",
    "LeftOut",
    "Pair",
    "PairedComparison",
    "RunRow",
    "ScoreRow",
    "ScoreTable",
    "SystemRow",
    "WrittenFigures",
    "agrees",
    "compare",
    "compare_managers",
    "entropy_figure",
    "estimate",
    "format_agreement",
    "format_report",
    "format_runs",
    "index_page",
    "load_results",
    "outage_figure",
    "render_report",
    "render_runs",
    "run_fields",
    "score_tables",
    "summarise",
    "write_figures",
]
