"""What the figures of a report show, against values computed by hand."""

import csv
import io
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import pytest
from tests.evaluation.test_report import run

from sunset.evaluation.figure_frame import (
    COLUMN_IN,
    HEIGHT_IN,
    PAGE_IN,
    SHIPPED,
    ReportFigure,
    report_drawing,
    styles,
)
from sunset.evaluation.report_figures import report_figures
from sunset.evaluation.results import Flight, RunRow
from sunset.evaluation.scores import score_tables
from sunset.managing import MANAGERS
from sunset.metrics import FaultOutcome

CURED = FaultOutcome("gpu_failure", "F3", 1.0, 3.0, cured=3.0, uncured_s=2.0)
MASKED = FaultOutcome("image_shift", "F4", 0.0, 20.0, uncured_s=20.0, masked_s=7.5)
MISSED = FaultOutcome("gpu_failure", "F3", 4.0, 14.0, uncured_s=10.0)
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


def figures(found: list[RunRow]) -> Mapping[str, ReportFigure]:
    pytest.importorskip("matplotlib")
    return {figure.name: figure for figure in report_figures(found, score_tables(found))}


def data_of(figure: ReportFigure) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(figure.as_csv())))


def panels_of(figure: ReportFigure) -> list[Any]:
    """Return the panels that are drawn."""
    return [axes for axes in figure.picture.axes if axes.axison] if figure.picture else []


def campaign(
    managers: Iterable[str], flights: Iterable[str] = ("",), suites: Iterable[str] = ("artifact",)
) -> list[RunRow]:
    return [
        one
        for suite in suites
        for name in managers
        for flight in flights
        for one in runs(name, flight=flight, suite=suite)
    ]


@pytest.fixture(scope="module")
def ladder() -> Mapping[str, ReportFigure]:
    return figures(campaign(IOU_ALL))


def test_every_figure_shows_something_and_lacks_nothing(ladder: Mapping[str, ReportFigure]) -> None:
    assert list(ladder) == ["scores", "differences", "fates", "uncured"]
    for figure in ladder.values():
        assert panels_of(figure)
        assert not figure.missing
        assert {len(line) for line in figure.lines} == {len(figure.head)}
        assert figure.caption.endswith(
            "Runs: 20 s, model lite, middleware sim, thinking 0 s, SUNSET of an unknown version."
        )


def test_differences_are_of_pairs_the_better_first(ladder: Mapping[str, ReportFigure]) -> None:
    (panel,) = panels_of(ladder["differences"])
    assert [label.get_text() for label in panel.get_yticklabels()] == ["oracle − baseline", "baseline − none"]
    first, *others = data_of(ladder["differences"])
    assert [(line["first"], line["second"]) for line in others] == [("oracle", "none"), ("baseline", "none")]
    assert [first[name] for name in ("suite", "first", "second", "pairs")] == [
        "artifact",
        "oracle",
        "baseline",
        "3",
    ]
    assert float(first["utility_difference"]) == pytest.approx(0.2)
    assert float(first["score_difference"]) == pytest.approx(0.5)


def test_scores_are_by_suite_and_of_several_flights_by_flight() -> None:
    scores = figures(campaign(IOU_ALL, ("hill", "town")))["scores"]
    (panel,) = panels_of(scores)
    assert [text.get_text() for text in panel.texts] == ["artifact", "flight hill", "flight town"]
    assert [label.get_text() for label in panel.get_yticklabels()] == ["baseline"] * 3
    lines = [line for line in data_of(scores) if line["system"] == "baseline"]
    assert [(line["suite"], line["flight"], line["runs"]) for line in lines] == [
        ("artifact", "", "6"),
        ("", "hill", "3"),
        ("", "town", "3"),
    ]
    assert [float(line["score"]) for line in lines] == pytest.approx([0.5] * 3)


def test_times_without_a_cure_are_means_over_faults(ladder: Mapping[str, ReportFigure]) -> None:
    lines = [line for line in data_of(ladder["uncured"]) if line["fault"] == "gpu_failure"]
    assert {line["system"]: float(line["uncured_s"]) for line in lines} == {
        "none": 10,
        "baseline": 10,
        "oracle": 2,
    }
    (panel,) = panels_of(ladder["uncured"])
    assert [label.get_text() for label in panel.get_yticklabels()] == ["gpu failure (F3)", "image shift (F4)"]


def test_fates_are_counted_by_fault(ladder: Mapping[str, ReportFigure]) -> None:
    assert [panel.get_title(loc="left") for panel in panels_of(ladder["fates"])] == [
        name for name in IOU_ALL if name != "none"
    ]
    assert data_of(ladder["fates"])[2] == {
        "failure": "F3",
        "fault": "gpu_failure",
        "system": "oracle",
        "faults": "3",
        "cured": "3",
        "masked": "0",
        "missed": "0",
    }


def test_one_run_shows_what_became_of_its_faults() -> None:
    found = figures(runs("baseline", seeds=(1,)))
    assert [name for name, figure in found.items() if figure.picture] == ["fates", "uncured"]
    assert all(figure.missing for figure in found.values() if not figure.picture)
    no_fault = figures([replace(one, outcomes=()) for one in runs("baseline")])
    assert no_fault["fates"].missing == ["No run says what became of a fault."]


def test_without_a_valid_run_nothing_is_drawn() -> None:
    invalid = [replace(one, valid=False, reason="no") for one in runs("baseline")]
    for found in (invalid, runs("none", suite="degraded")):
        for figure in figures(found).values():
            assert figure.picture is None
            assert figure.missing
            assert figure.as_csv().count("\n") == 1


def test_where_nothing_is_to_repair_the_figure_of_scores_says_so() -> None:
    calm = [replace(one, metrics={**one.metrics, "iou_all": 0.5}) for one in campaign(IOU_ALL)]
    assert figures(calm)["scores"].missing == [
        "No suite has a score to draw: in most runs, oracle wins less than 0.02 over none."
    ]
    assert figures(runs("baseline"))["scores"].missing == [
        "A score needs runs of none, oracle and another managing system."
    ]


def test_remarks_say_who_was_run_less_and_which_runs_are_left_out() -> None:
    other = [replace(one, model="reference") for one in runs("none", seeds=(1,))]
    assert figures([*runs("baseline"), *runs("oracle", seeds=(1, 2)), *other])["fates"].missing == [
        "Managing systems have different numbers of valid runs: baseline 3, oracle 2.",
        "1 run of other models, middlewares, settings or versions are left out.",
    ]


def test_every_figure_fits_a_page_with_all_of_its_text() -> None:
    flights = [f"town{place}-110m-75deg-morning-hazy-and-so-on" for place in range(3)]
    suites = ("timed", "", "paper", "outages")
    found = campaign(IOU_ALL, flights, suites)
    for place in range(6):
        name = f"my_long_folder/of_{place}/mine.py:MyManagingSystem{place}"
        found += [replace(one, manager=name) for one in campaign(["baseline"], flights[:1], suites)]
    found = [one for one in found if one.seed < 3]  # without intervals, which take long
    for figure in figures([replace(one, suite_size=54) for one in found]).values():
        assert figure.picture
        with report_drawing():
            figure.picture.draw_without_rendering()
            width, height = figure.picture.get_size_inches()
            box = figure.picture.get_tightbbox()
            headings = [text.get_window_extent() for panel in panels_of(figure) for text in panel.texts]
        assert width in {COLUMN_IN, PAGE_IN}
        assert height <= HEIGHT_IN
        assert box.x0 > -0.02
        assert box.y0 > -0.02
        assert box.x1 < width + 0.02
        assert box.y1 < height + 0.02
        assert all(0 <= text.x0 < text.x1 <= figure.picture.bbox.x1 for text in headings)


def test_panels_to_be_compared_have_the_same_scales() -> None:
    fates = panels_of(figures(campaign(IOU_ALL, suites=("timed", "paper")))["fates"])
    assert len({(panel.get_xlim(), panel.get_ylim()) for panel in fates}) == 1


def test_long_names_keep_their_beginning_and_end() -> None:
    longer = [replace(one, manager=f"{one.manager}-that-has-a-long-name") for one in runs("baseline")]
    (panel,) = panels_of(figures([*longer, *runs("none")])["differences"])
    assert [label.get_text() for label in panel.get_yticklabels()] == ["baselin…g-name − none"]


def test_another_duration_than_that_of_most_runs_is_in_the_title() -> None:
    short = [replace(one, suite="short", flight=Flight(4.0)) for one in campaign(IOU_ALL)]
    found = figures([*campaign(IOU_ALL, suites=("paper", "timed")), *short])["scores"]
    assert [text.get_text() for text in panels_of(found)[0].texts] == ["timed", "paper", "short [4 s]"]


def test_a_managing_system_looks_the_same_in_every_report() -> None:
    names = ["mine.py:Mine", "reactive", "theirs", "baseline"]
    looks = styles(names)
    assert len({(style.colour, style.marker) for style in looks.values()}) == 4
    assert all(styles([name])[name] == looks[name] for name in names)
    many = styles([f"number {number}" for number in range(20)])
    assert len({(style.colour, style.marker) for style in many.values()}) == 20


def test_figures_and_tables_name_the_managing_systems_of_sunset_in_their_order() -> None:
    assert list(SHIPPED) == list(MANAGERS)
