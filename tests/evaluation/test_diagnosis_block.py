"""The table of diagnoses, and how runs of the task to diagnose are kept apart."""

import json
from dataclasses import replace

import pytest
from tests.evaluation.test_report import row_of, run

from sunset.evaluation import FORMATS, RunRow, format_report, score_tables, summarise

FIGURES = {
    "diagnoses": 5,
    "faults_injected": 2,
    "faults_detected": 2,
    "faults_located": 2,
    "faults_identified": 1,
    "faults_top1": 0,
    "t_detected_s": 1.0,
    "false_alarms": 1,
    "faultless_s": 30.0,
    "brier": 0.1,
}


def rows(manager: str, task: str = "repair", **figures: float) -> list[RunRow]:
    """Return two runs, with 4 faults and 60 s without a fault; in the second, fewer were detected."""
    found = FIGURES | figures
    first = run(manager, "timed", 1, scenario="timed/a", **found)
    second = run(manager, "timed", 2, scenario="timed/a", **(found | {"faults_detected": 1, "brier": 0.2}))
    return [replace(one, task=task) for one in (first, second)]


def diagnoses_of(runs: list[RunRow]) -> str:
    return format_report(summarise(runs)).partition("Diagnosis\n\n")[2].partition("\n\n")[0]


def test_the_table_adds_up_faults_and_time() -> None:
    assert row_of(diagnoses_of(rows("mine")), "mine (timed)")[1:] == [
        *("2", "3/4 (75%)", "4/4 (100%)", "2/4 (50%)", "0/4 (0%)"),
        *("1.00 ± 0.00", "N/A", "N/A", "2.00", "0.150"),
    ]


@pytest.mark.parametrize("form", FORMATS)
def test_the_table_is_printed_only_where_a_run_published_diagnoses(form: str) -> None:
    silent = format_report(summarise(rows("none", diagnoses=0)), form)
    told = format_report(summarise([*rows("none", diagnoses=0), *rows("mine")]), form)
    if form not in {"csv", "json"}:
        assert "identified" not in silent
        assert "identified" in told


def test_none_stands_in_the_table_and_others_that_say_nothing_do_not() -> None:
    runs = [*rows("none", diagnoses=0), *rows("silent", diagnoses=0), *rows("mine")]
    table = diagnoses_of(runs)
    assert row_of(table, "none (timed)")
    assert "silent" not in table


def test_runs_that_only_diagnose_have_rows_of_their_own_and_no_score() -> None:
    runs = [*rows("none", "diagnose"), *rows("oracle", "diagnose"), *rows("mine", "diagnose"), *rows("mine")]
    found = summarise(runs)
    assert [row.system for row in found] == [
        *("none (timed) [diagnose]", "oracle (timed) [diagnose]", "mine (timed) [diagnose]", "mine (timed)"),
    ]
    assert score_tables(runs) == []
    text = format_report(found)
    paper = text.partition("The paper's figures\n\n")[2].partition("\n\n")[0]
    assert "mine (timed)" in paper
    assert "[diagnose]" not in paper
    told = {row["system"]: row["task"] for row in json.loads(format_report(found, "json"))["rows"]}
    assert (told["mine (timed)"], told["mine (timed) [diagnose]"]) == ("repair", "diagnose")
