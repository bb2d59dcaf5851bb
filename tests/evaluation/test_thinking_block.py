"""The table of what decisions have cost, where somebody said it."""

from dataclasses import replace

import pytest
from tests.evaluation.test_report import row_of, run

from sunset.evaluation.report import FORMATS, format_report
from sunset.evaluation.results import RunRow
from sunset.evaluation.summary import summarise


def rows(manager: str, *asked: str, **figures: float) -> list[RunRow]:
    """Return two runs; in the second, nothing was spent."""
    first, second = (run(manager, "timed", seed, scenario="timed/a") for seed in (1, 2))
    known = replace(first, metrics={**first.metrics, **figures}, models_asked=asked)
    return [known, replace(second, metrics={**second.metrics, **dict.fromkeys(figures)})]


def costs_of(runs: list[RunRow]) -> str:
    return (
        format_report(summarise(runs), every=True)
        .partition("The costs of thinking\n")[2]
        .partition("More about")[0]
    )


def test_costs_are_means_over_runs_with_the_models_asked() -> None:
    table = costs_of(rows("mine", "tiny", "large", tokens_in=1201, tokens_out=30, price=0.0025, think_s=1.5))
    assert row_of(table, "mine (timed)")[1:] == ["2", "0.75", "600.5", "15", "0.00125", "tiny and large"]


def test_columns_that_nobody_used_are_left_out() -> None:
    thinking = {"tokens_in": 0, "tokens_out": 0, "price": 0.0, "think_s": 1.0}
    table = costs_of([*rows("mine", **thinking), *rows("none")])
    assert "tokens" not in table
    assert "asked" not in table
    assert "none (timed)" not in table
    assert row_of(table, "mine (timed)")[1:] == ["2", "0.5"]


@pytest.mark.parametrize("form", FORMATS)
def test_without_costs_there_is_no_table(form: str) -> None:
    assert "costs of thinking" not in format_report(summarise(rows("none")), form, every=True)
