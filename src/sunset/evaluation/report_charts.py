"""The figures of a report."""

from collections.abc import Sequence

from sunset.evaluation.chart_runs import setups
from sunset.evaluation.charts import Chart
from sunset.evaluation.comparison_charts import costs_chart, differences_chart, profiles_chart, scores_chart
from sunset.evaluation.fault_charts import fates_chart
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import ScoreTable


def report_charts(runs: Sequence[RunRow], tables: Sequence[ScoreTable]) -> tuple[Chart, ...]:
    """Return the figures of a report, in their order; what one of them cannot show stands in it.

    Args:
        runs: all of them.
        tables: their scores.
    """
    found = setups(runs, tables)
    charts = (differences_chart, scores_chart, profiles_chart, fates_chart, costs_chart)
    return tuple(chart(found) for chart in charts)
