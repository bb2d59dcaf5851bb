"""What the figures of a report show, against values computed by hand."""

import csv
import io
from collections.abc import Iterable
from dataclasses import replace

import pytest
from tests.evaluation.test_report import run

from sunset.evaluation import Flight, RunRow, score_tables
from sunset.evaluation.charts import Chart, Curves, Intervals, Points, Shares
from sunset.evaluation.report_charts import report_charts
from sunset.evaluation.system_styles import SHIPPED, styles
from sunset.managing import MANAGERS
from sunset.metrics import FaultOutcome

CURED = FaultOutcome("gpu_failure", "F3", 1.0, 3.0, cured=3.0)
MASKED = FaultOutcome("image_shift", "F4", 0.0, 20.0, masked_s=7.5)
MISSED = FaultOutcome("gpu_failure", "F3", 4.0, 14.0)
IOU_ALL = {"none": 0.1, "baseline": 0.3, "oracle": 0.5}
T_DOWN_S = {"none": 20.0, "baseline": 4.0, "oracle": 2.0}


def runs(
    manager: str, *, flight: str = "", seeds: Iterable[int] = (1, 2, 3), suite: str = "artifact"
) -> list[RunRow]:
    """Return a run a seed, of which the second has twice the downtime."""
    return [
        replace(
            run(
                manager,
                suite,
                seed,
                scenario=f"{suite}/x",
                flight=Flight(20.0, bag=flight, name=flight),
                iou_all=IOU_ALL[manager] + (seed - 2) / 100,
                t_down_s=T_DOWN_S[manager] * (2 if seed == 2 and manager != "none" else 1),
                adaptations={"none": 0, "baseline": 3, "oracle": 2}[manager],
            ),
            outcomes=(CURED if manager == "oracle" else MISSED, MASKED),
        )
        for seed in seeds
    ]


def charts(found: list[RunRow]) -> dict[str, Chart]:
    return {chart.name: chart for chart in report_charts(found, score_tables(found))}


def data_of(chart: Chart) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(chart.as_csv())))


@pytest.fixture(scope="module")
def ladder() -> dict[str, Chart]:
    return charts([*runs("none"), *runs("baseline"), *runs("oracle")])


def test_every_figure_shows_something_and_lacks_nothing(ladder: dict[str, Chart]) -> None:
    assert list(ladder) == ["differences", "scores", "profiles", "cures", "fates", "costs"]
    for chart in ladder.values():
        assert chart.panels
        assert chart.missing == ()
        assert {len(line) for line in chart.lines} == {len(chart.head)}


def test_differences_are_of_pairs_the_better_first(ladder: dict[str, Chart]) -> None:
    (panel,) = ladder["differences"].panels
    assert isinstance(panel, Intervals)
    assert [mark.label for mark in panel.marks] == ["oracle − baseline", "baseline − none"]
    assert [mark.system for mark in panel.marks] == ["oracle", "baseline"]
    assert [mark.value for mark in panel.marks] == pytest.approx([0.2, 0.2])
    first, *others = data_of(ladder["differences"])
    assert [(line["first"], line["second"]) for line in others] == [("oracle", "none"), ("baseline", "none")]
    assert (first["suite"], first["first"], first["second"], first["pairs"]) == (
        "artifact",
        "oracle",
        "baseline",
        "3",
    )
    assert float(first["utility_difference"]) == pytest.approx(0.2)
    assert float(first["score_difference"]) == pytest.approx(0.5)


def test_scores_are_by_suite_and_of_several_flights_by_flight(ladder: dict[str, Chart]) -> None:
    (panel,) = ladder["scores"].panels
    assert isinstance(panel, Intervals)
    (mark,) = panel.marks
    assert mark.system == "baseline"
    assert mark.value == pytest.approx(0.5)
    managers = ("none", "baseline", "oracle")
    two = charts(
        [one for name in managers for flight in ("hill", "town") for one in runs(name, flight=flight)]
    )
    assert [panel.title for panel in two["scores"].panels] == ["artifact", "flight hill", "flight town"]
    lines = [line for line in data_of(two["scores"]) if line["system"] == "baseline"]
    assert [(line["suite"], line["flight"], line["runs"]) for line in lines] == [
        ("artifact", "", "6"),
        ("", "hill", "3"),
        ("", "town", "3"),
    ]
    assert [float(line["score"]) for line in lines] == pytest.approx([0.5] * 3)


def test_a_suite_with_little_to_repair_has_no_panel_of_scores() -> None:
    found = [one for name in ("none", "baseline", "oracle") for one in runs(name, suite="calm")]
    nothing = [replace(one, metrics={**one.metrics, "utility": 0.2}) for one in found]
    little = [replace(one, scenario="calm/y") for one in found if one.seed == 1]
    scores = charts([*nothing, *little, *runs("none"), *runs("baseline"), *runs("oracle")])["scores"]
    assert [panel.title for panel in scores.panels] == ["artifact"]
    assert {line["suite"] for line in data_of(scores)} == {"artifact"}


def test_profiles_are_shares_of_runs(ladder: dict[str, Chart]) -> None:
    down, iou = ladder["profiles"].panels
    assert isinstance(down, Curves)
    assert isinstance(iou, Curves)
    baseline, oracle = down.curves[1:]
    assert [curve.system for curve in down.curves] == ["none", "baseline", "oracle"]
    assert baseline.x == pytest.approx([0, 4, 8, 20])  # 4 s, 8 s and 4 s
    assert baseline.shares == pytest.approx([0, 2 / 3, 1, 1])
    assert oracle.x == pytest.approx([0, 2, 4, 20])
    # more than 0.28 in all, more than 0.29 in two of three
    assert iou.curves[1].x == pytest.approx([0, 0.29, 0.3, 0.31, 0.51])
    assert iou.curves[1].shares == pytest.approx([1, 2 / 3, 1 / 3, 0, 0])


def test_times_to_cure_are_by_failure(ladder: dict[str, Chart]) -> None:
    panels = {panel.title: panel for panel in ladder["cures"].panels}
    assert list(panels) == ["F3", "F4", "all failures"]
    outages, everything = panels["F3"], panels["all failures"]
    assert isinstance(outages, Curves)
    assert isinstance(everything, Curves)
    none, _, oracle = outages.curves
    assert (none.x, none.shares, none.mean) == ((0, 20), (1, 1), 20)
    assert (oracle.x, oracle.shares, oracle.mean) == ((0, 2, 20), (1, 0, 0), 2)
    assert everything.curves[2].shares == (1, 0.5, 0.5)
    assert everything.curves[2].mean == 11.0  # 2 s and 20 s
    line = next(line for line in data_of(ladder["cures"]) if line["system"] == "oracle")
    assert (line["failure"], line["faults"], line["cured"], line["restricted_mean_s"]) == (
        "F3",
        "3",
        "3",
        "2.0",
    )


def test_fates_are_shares_of_each_fault(ladder: dict[str, Chart]) -> None:
    panels = [panel for panel in ladder["fates"].panels if isinstance(panel, Shares)]
    assert {panel.lines for panel in panels} == {("gpu_failure", "image_shift")}
    assert {panel.columns for panel in panels} == {("none", "baseline", "oracle")}
    assert {panel.title: panel.shares for panel in panels} == {
        "cured [%]": ((0, 0, 1), (0, 0, 0)),
        "masked [%]": ((0, 0, 0), (1, 1, 1)),
        "missed [%]": ((1, 1, 0), (0, 0, 0)),
    }
    assert data_of(ladder["fates"])[2] == {
        "setup": "",
        "fault": "gpu_failure",
        "system": "oracle",
        "faults": "3",
        "cured": "3",
        "masked": "0",
        "missed": "0",
    }


def test_the_front_is_of_those_that_no_other_one_beats(ladder: dict[str, Chart]) -> None:
    (panel,) = ladder["costs"].panels
    assert isinstance(panel, Points)
    assert [(point.system, point.x) for point in panel.points] == [
        ("none", 0),
        ("baseline", 3),
        ("oracle", 2),
    ]
    assert [point.y for point in panel.points] == pytest.approx([0.1, 0.3, 0.5])
    assert [point.system for point in panel.front] == ["none", "oracle"]
    assert [line["on_front"] for line in data_of(ladder["costs"])] == ["true", "false", "true"]


def test_a_figure_says_what_it_lacks() -> None:
    old = [replace(one, outcomes=None) for one in runs("baseline", seeds=(1, 2))]
    found = charts(old)
    assert [name for name, chart in found.items() if not chart.panels] == [
        "differences",
        "scores",
        "cures",
        "fates",
    ]
    assert "There is nothing to compare" in found["differences"].missing[0]
    assert "it needs runs of none and oracle" in found["scores"].missing[0]
    assert found["cures"].missing == found["fates"].missing
    assert "baseline: 2 of 2 runs are of a version that did not say" in found["cures"].missing[0]
    assert "fewer than 3 seeds have no confidence interval" in found["costs"].missing[0]
    no_fault = [replace(one, outcomes=()) for one in runs("baseline")]
    assert charts(no_fault)["fates"].missing == ("There is no fault in any of the runs.",)


def test_without_a_valid_run_nothing_is_drawn() -> None:
    invalid = [replace(one, valid=False, reason="no") for one in runs("baseline")]
    for found in ([], invalid, runs("none", suite="degraded")):
        for chart in charts(found).values():
            assert chart.panels == ()
            assert chart.missing
            assert chart.as_csv().count("\n") == 1


def test_who_was_run_on_less_is_named() -> None:
    found = charts([*runs("baseline"), *runs("oracle", seeds=(1, 2))])
    assert found["fates"].missing == (
        "Not all were run on the same scenarios, flights and seeds: oracle has 2 runs of 3.",
    )


def test_of_long_names_something_of_both_is_left() -> None:
    longer = [replace(one, manager=f"{one.manager}-that-has-a-long-name") for one in runs("baseline")]
    (panel,) = charts([*longer, *runs("none")])["differences"].panels
    assert isinstance(panel, Intervals)
    assert [mark.label for mark in panel.marks] == ["baseline-that-… − none"]


def test_setups_are_never_put_together() -> None:
    both = [*runs("baseline"), *(replace(one, model="reference") for one in runs("baseline"))]
    titles = [panel.title for panel in charts(both)["costs"].panels]
    assert titles == ["artifact · lite", "artifact · reference"]


def test_a_managing_system_looks_the_same_in_every_report() -> None:
    names = ["mine.py:Mine", "reactive", "theirs", "baseline"]
    looks = styles(names)
    assert len({(style.colour, style.marker) for style in looks.values()}) == 4
    assert all(styles([name])[name] == looks[name] for name in names)
    many = styles([f"number {number}" for number in range(20)])
    assert len({(style.colour, style.marker) for style in many.values()}) == 20


def test_figures_and_tables_name_the_managing_systems_of_sunset_in_their_order() -> None:
    assert list(SHIPPED) == list(MANAGERS)
