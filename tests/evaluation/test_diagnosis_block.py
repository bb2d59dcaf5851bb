"""The table of diagnoses, and how runs of the task to diagnose are kept apart."""

import json
from dataclasses import replace

import pytest
from tests.evaluation.test_report import row_of, run

from sunset.evaluation.report import FORMATS, format_report
from sunset.evaluation.results import RunRow
from sunset.evaluation.scores import score_tables
from sunset.evaluation.summary import summarise
from sunset.recording import SETTINGS

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
    first, second = (run(manager, "timed", seed, scenario="timed/a") for seed in (1, 2))
    pairs = ((first, found), (second, found | {"faults_detected": 1, "brier": 0.2}))
    return [
        replace(one, settings={**SETTINGS, "task": task}, metrics={**one.metrics, **figures})
        for one, figures in pairs
    ]


def diagnoses_of(runs: list[RunRow]) -> str:
    return format_report(summarise(runs), every=True).partition("Diagnosis\n")[2].partition("More about")[0]


def test_the_table_adds_up_faults_and_time() -> None:
    assert row_of(diagnoses_of(rows("mine")), "mine (timed)")[1:] == [
        *("2", "3/4, 1.00 s", "4/4", "2/4", "0/4", "2.00", "0.150"),
    ]


def test_the_moment_before_a_fault_at_0_gives_no_rate_of_false_alarms() -> None:
    assert row_of(diagnoses_of(rows("mine", faultless_s=0.0005)), "mine (timed)")[-2:] == ["N/A", "0.150"]
    assert row_of(diagnoses_of(rows("mine", faultless_s=0.5)), "mine (timed)")[-2:] == ["120.00", "0.150"]


@pytest.mark.parametrize("form", FORMATS)
def test_the_table_is_printed_only_where_a_run_published_diagnoses(form: str) -> None:
    silent = format_report(summarise(rows("none", diagnoses=0)), form, every=True)
    told = format_report(summarise([*rows("none", diagnoses=0), *rows("mine")]), form, every=True)
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
    assert [row.system for table in score_tables(runs) for row in table.rows] == ["mine"]
    text = format_report(found, every=True)
    paper = text.partition("The paper's figures\n\n")[2].partition("\n\n")[0]
    assert "mine (timed)" in paper
    assert "[diagnose]" not in paper
    told = {row["system"]: row["task"] for row in json.loads(format_report(found, "json"))["rows"]}
    assert (told["mine (timed)"], told["mine (timed) [diagnose]"]) == ("repair", "diagnose")
