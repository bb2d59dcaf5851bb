"""The score: from stored runs to tables, blocks and formats."""

import csv
import io
import json
from dataclasses import replace
from itertools import product

import pytest
from tests.evaluation.test_report import run

from sunset.evaluation.layout import lead_blocks, lead_notes
from sunset.evaluation.report import FORMATS, format_report
from sunset.evaluation.results import Flight, RunRow
from sunset.evaluation.scores import NO_SCORE, ScoreTable, score_tables
from sunset.evaluation.summary import summarise

NOTHING_TO_REPAIR = "calm"


def campaign(**wins: float) -> list[RunRow]:
    """Return runs of none, of oracle and of managing systems that win a share of what there is to win.

    Of what repairing can win there is 0.1, 0.2 and 0.3 by degradation, a little more with each seed; and 0.01 with a
    last one, where each managing system that is named loses 0.05.
    """
    rows = []
    gains = {"a": 0.1, "b": 0.2, "c": 0.3, NOTHING_TO_REPAIR: 0.01}
    for (alike, gain), seed in product(gains.items(), (1, 2, 3)):
        most = gain + 0.001 * seed * (alike != NOTHING_TO_REPAIR)
        for manager, share in {"none": 0.0, "oracle": 1.0, **wins}.items():
            won = -0.05 if alike == NOTHING_TO_REPAIR and manager in wins else share * most
            row = run(manager, "timed", seed, scenario=f"timed/{alike}", iou_all=0.2 + won)
            rows.append(replace(row, alike=alike))
    return rows


def only(tables: list[ScoreTable]) -> ScoreTable:
    (table,) = tables
    return table


def test_a_score_is_what_is_won_of_what_can_be_won() -> None:
    table = only(score_tables(campaign(half=0.5, most=0.9)))
    assert [row.manager for row in table.rows] == ["oracle", "most", "half", "none"]
    scores = [row.score.mean for row in table.rows if row.score]
    assert scores == pytest.approx([1.0, 0.9, 0.5, 0.0])
    assert [row.is_reference for row in table.rows] == [True, False, False, True]
    assert all(row.score and row.score.runs == 9 and row.runs == 12 for row in table.rows)
    assert [(one.first, one.second) for one in table.neighbours] == list(
        zip([row.system for row in table.rows], [row.system for row in table.rows[1:]], strict=False)
    )


def test_where_there_is_nothing_to_repair_runs_count_for_harm() -> None:
    table = only(score_tables(campaign(half=0.5)))
    harm = {row.manager: row.harm.mean for row in table.rows if row.harm}
    assert harm == pytest.approx({"oracle": -0.01, "half": 0.05, "none": 0.0})
    assert all(row.harm and row.harm.runs == 3 for row in table.rows)


def test_runs_without_both_references_are_counted_beside_the_score() -> None:
    runs = [
        one
        for one in campaign(half=0.5)
        if (one.manager, one.alike, one.seed) not in {("oracle", "a", 1), ("none", "b", 2)}
    ]
    (half,) = (row for row in only(score_tables(runs)).rows if row.manager == "half")
    assert half.unpaired == 2
    assert half.score is not None
    assert half.score.runs == 7
    assert any("2 of 12 runs without a score" in note for note in lead_notes(score_tables(runs)))


@pytest.mark.parametrize("is_missing", [True, False])
def test_an_invalid_or_missing_run_counts_as_never_repairing(is_missing: bool) -> None:
    whole = campaign(half=0.5)
    place = next(
        place for place, one in enumerate(whole) if (one.manager, one.alike, one.seed) == ("half", "a", 1)
    )
    lost = [] if is_missing else [replace(whole[place], valid=False, reason="broken")]
    honest = replace(whole[place], metrics={**whole[place].metrics, "iou_all": 0.2})

    found = only(score_tables([*whole[:place], *lost, *whole[place + 1 :]]))
    expected = only(score_tables([*whole[:place], honest, *whole[place + 1 :]]))

    (half,) = (row for row in found.rows if row.manager == "half")
    assert (half.runs, half.invalid, half.missing) == ((11, 0, 1) if is_missing else (12, 1, 0))
    assert [row.score for row in found.rows] == [row.score for row in expected.rows]
    assert found.differences == expected.differences
    (line,) = (line for line in lead_blocks([found])[0].lines if line.label == "half")
    assert line.runs == ("11, 1 missing" if is_missing else "12, 1 invalid")


def test_managing_systems_are_compared_with_those_that_looked_at_the_same() -> None:
    runs = [
        replace(one, evidence="images") if one.manager.startswith("pixels") else one
        for one in campaign(pixels=0.9, pixels_too=0.4, half=0.5)
    ]
    table = only(score_tables(runs))
    assert [row.system for row in table.rows] == ["oracle", "pixels", "half", "pixels_too", "none"]
    assert {(one.first, one.second) for one in table.neighbours} == {
        ("oracle", "pixels"),
        ("oracle", "half"),
        ("pixels", "pixels_too"),
        ("half", "none"),
        ("pixels_too", "none"),
    }


def test_a_bad_warm_up_makes_no_adaptation_cheaper() -> None:
    whole = [
        replace(one, metrics={**one.metrics, "cost_frames": 20}) if one.manager == "half" else one
        for one in campaign(half=0.5)
    ]
    spoilt = [
        replace(one, metrics={**one.metrics, "iou_healthy": 0.1}) if one.manager == "half" else one
        for one in whole
    ]
    assert [row.score for row in only(score_tables(whole)).rows] == [
        row.score for row in only(score_tables(spoilt)).rows
    ]


def test_the_order_is_given_at_multiples_of_the_prices() -> None:
    runs = [
        replace(
            one, metrics={**one.metrics, "iou_all": (one.metrics["iou_all"] or 0.0) + 0.06, "cost_frames": 24}
        )
        if one.manager == "dear"
        else one
        for one in campaign(dear=0.5, cheap=0.6)
    ]
    table = only(score_tables(runs))
    assert table.orders[0.0] == table.orders[0.5] == ("oracle", "dear", "cheap", "none")
    assert table.orders[1.0] == ("oracle", "cheap", "dear", "none")
    assert (
        "Order in the suite timed: oracle > cheap > dear > none; the same at 2 times the prices; at 0 and 0.5 times "
        "the prices dear > cheap; at 4 times the prices none > dear."
    ) in lead_notes([table])


def test_no_managing_system_is_ranked_by_the_runs_that_it_lets_count() -> None:
    runs = [
        replace(one, valid=False, reason="subscribed to the truth")
        if one.manager == "cheat" and one.alike != "a"
        else one
        for one in campaign(cheat=0.9, honest=0.5)
    ]
    names = [row.manager for row in only(score_tables(runs)).rows]
    assert names == ["oracle", "honest", "cheat", "none"]


def test_whether_there_is_something_to_repair_does_not_depend_on_the_seed() -> None:
    gains = {1: 0.021, 2: 0.018, 3: 0.018}
    runs = [
        replace(one, metrics={**one.metrics, "iou_all": 0.2 + gains[one.seed]})
        if (one.manager, one.alike) == ("oracle", NOTHING_TO_REPAIR)
        else one
        for one in campaign(half=0.5)
    ]
    (half,) = (row for row in only(score_tables(runs)).rows if row.manager == "half")
    assert half.score is not None
    assert half.harm is not None
    assert (half.score.runs, half.harm.runs) == (9, 3)


def test_where_there_is_mostly_nothing_to_repair_harm_ranks() -> None:
    calm = [one for one in campaign(lucky=1.0, harmless=0.0) if one.alike in {NOTHING_TO_REPAIR, "a"}]
    calm = [one for one in calm if one.alike != "a" or one.seed == 1]
    kept = [
        replace(one, metrics={**one.metrics, "iou_all": 0.2})
        if (one.manager, one.alike) == ("harmless", NOTHING_TO_REPAIR)
        else one
        for one in calm
    ]
    names = [row.manager for row in only(score_tables(kept)).rows if not row.is_reference]
    assert names == ["harmless", "lucky"]


def test_invalid_live_runs_count_as_never_repairing_whatever_the_reason() -> None:
    ended = [
        replace(one, middleware="cyclonedds", valid=one.manager != "half" or one.seed != 1)
        for one in campaign(half=0.5)
    ]
    (half,) = (row for row in only(score_tables(ended)).rows if row.manager == "half")
    assert (half.runs, half.invalid, half.score and half.score.runs) == (12, 4, 9)
    assert half.score
    assert half.score.mean == pytest.approx(0.5 * 2 / 3, abs=0.01)


def test_unlike_runs_of_one_experiment_count_by_their_mean_whichever_comes_last() -> None:
    whole = campaign(half=0.5)
    better = replace(
        next(one for one in whole if (one.manager, one.alike, one.seed) == ("half", "a", 1)), digest="another"
    )
    better = replace(better, metrics={**better.metrics, "iou_all": 0.3})
    scores = [
        next(row.score for row in only(score_tables(runs)).rows if row.manager == "half")
        for runs in ([*whole, better], [better, *whole])
    ]
    assert scores[0] == scores[1]
    assert scores[0]
    assert scores[0].mean > 0.5


def test_without_the_references_there_are_differences_but_no_score() -> None:
    runs = [one for one in campaign(half=0.5, most=0.9) if one.manager in {"half", "most"}]
    table = only(score_tables(runs))
    assert not any(row.score or row.harm for row in table.rows)
    assert [row.manager for row in table.rows] == ["most", "half"]
    (one,) = table.neighbours
    assert one.score is None
    assert one.utility is not None
    assert lead_notes([table])[0] == NO_SCORE


def test_a_single_managing_system_has_a_row_without_a_score() -> None:
    table = only(score_tables([one for one in campaign() if one.manager == "none"]))
    assert [(row.system, row.score) for row in table.rows] == [("none", None)]
    assert lead_notes([table])[0] == NO_SCORE


def test_flights_are_put_together_and_durations_are_not() -> None:
    runs = campaign(half=0.5)
    town = [replace(one, flight=Flight(20.0, bag="3c", name="town")) for one in runs]
    short = [replace(one, flight=Flight(4.0)) for one in runs]
    both = score_tables([*runs, *town, *short])
    assert sorted(row.runs for table in both for row in table.rows if row.manager == "half") == [12, 24]


def test_the_blocks_lead_from_the_best_to_the_worst() -> None:
    scores, harm, differences = lead_blocks(score_tables(campaign(half=0.5)))
    for block in (scores, harm):
        assert [line.label for line in block.lines] == ["oracle", "half", "none"]
    assert [line.label for line in differences.lines] == ["oracle − half", "half − none"]
    assert [line.cells[0] for line in scores.lines] == ["faults", "symptoms", "nothing"]


def test_tables_of_a_suite_are_told_apart_by_title_label_and_columns() -> None:
    runs = campaign(half=0.5)
    both = score_tables([*runs, *(replace(one, model="own", version="1.0") for one in runs)])
    blocks = lead_blocks(both)
    assert [block.title for block in blocks[::3]] == [
        "The score: timed [lite] [sunset unknown]",
        "The score: timed [own] [sunset 1.0]",
    ]
    assert [block.label for block in blocks[::3]] == [
        "tab:sunset-score-timed-lite-sunset-unknown",
        "tab:sunset-score-timed-own-sunset-1.0",
    ]
    lines = list(csv.DictReader(io.StringIO(format_report([], "csv", both))))
    assert {(line["source"], line["model"], line["version"]) for line in lines} == {
        (source, *setting) for source in ("score", "difference") for setting in (("lite", ""), ("own", "1.0"))
    }


def test_notes_explain_what_is_shown_and_nothing_else() -> None:
    runs = campaign(half=0.5)
    told = format_report(summarise(runs), "table", score_tables(runs))
    assert ("In brackets: the 95 %" in told, "±" in told, "Harm: mean" in told) == (True, False, True)
    single = [one for one in runs if one.seed == 1 and one.alike != NOTHING_TO_REPAIR]
    told = format_report(summarise(single), "table", score_tables(single))
    assert ("In brackets: the 95 %" in told, "±" in told, "Harm: mean" in told) == (False, False, False)


def test_the_first_page_fits_a_hundred_columns_with_intervals_and_invalid_runs() -> None:
    runs = [
        replace(one, valid=one.seed != 2 or one.manager != "half", metrics={**one.metrics, "needless": 12.5})
        for one in campaign(half=-10.5, another_managing_system=0.25)
    ]
    text = format_report(summarise(runs), "table", score_tables(runs))
    assert max(map(len, text.splitlines())) <= 100
    assert "12, 4 invalid" in text


@pytest.mark.parametrize("form", FORMATS)
def test_every_format_has_the_score(form: str) -> None:
    runs = campaign(half=0.5)
    text = format_report(summarise(runs), form, score_tables(runs))
    if form == "json":
        document = json.loads(text)
        (table,) = document["scores"]
        assert table["rows"][1]["score"]["mean"] == pytest.approx(0.5)
        assert table["rows"][1]["harm"]["mean"] == pytest.approx(0.05)
        assert {row["manager"]: row["evidence"] for row in table["rows"]} == {
            "oracle": "faults",
            "half": "symptoms",
            "none": "nothing",
        }
    elif form == "csv":
        lines = list(csv.DictReader(io.StringIO(text)))
        half = {
            one["figure"]: float(one["mean"])
            for one in lines
            if one["source"] == "score" and one["manager"] == "half"
        }
        assert half == pytest.approx({"score": 0.5, "harm": 0.05})
        assert sum(one["source"] == "difference" and one["figure"] == "utility" for one in lines) == 3
    else:
        assert text.index("The score") < text.index("Differences between neighbours")
        assert "0.50" in text
