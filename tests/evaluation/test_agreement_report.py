import json
import re
from dataclasses import replace

import pytest

from sunset.errors import InvalidInputError
from sunset.evaluation.agreement import AGREEMENT_FORMATS, Agreement, LeftOut, Pair, format_agreement
from sunset.evaluation.differences import Difference
from sunset.evaluation.intervals import Estimate
from sunset.evaluation.results import FIGURES, Flight
from sunset.metrics import Episode, ExecutedAdaptation, RunMetrics, Timeline, score

RIPPLE = "artifact/camera_driver_issue+image_degradation+autofocus_needed"


def run(adaptations: int, *failures: str) -> RunMetrics:
    nothing = score(Timeline(thresholds={"entropy_threshold": 0.1, "sharpness_threshold": 1.0}))
    return RunMetrics(
        **nothing.to_json(),  # type: ignore[arg-type]
        failures=tuple(Episode(failure, 0.0, 1.0, None, True, None) for failure in failures),
        executed=tuple(ExecutedAdaptation(1.0, "camera", "redeploy") for _ in range(adaptations)),
    )


def compared(name: str) -> Difference:
    match name:
        case "iou":
            estimate = Estimate(-0.2, 0.1, -0.3, -0.1, 3)
            return Difference(figure=name, first=0.3, second=0.5, difference=estimate)
        case "t_down_s":
            estimate = Estimate(0.25, None, None, None, 1)
            return Difference(figure=name, first=3.75, second=3.5, difference=estimate, one_sided=2)
    return Difference(figure=name, first=None, second=None, difference=None)


def agreement(*, pairs: bool = True) -> Agreement:
    same, ripple = run(1, "F1"), run(2, "F1", "F2")
    return Agreement(
        suite="artifact",
        manager="baseline",
        model="lite",
        flight=Flight(20.0),
        pairs=(
            Pair(scenario=RIPPLE, seed=1, sim=same, live=same),
            Pair(scenario=RIPPLE, seed=2, sim=same, live=ripple),
            Pair(scenario="artifact/other", seed=1, sim=same, live=same),
        )
        if pairs
        else (),
        left_out=(LeftOut(scenario=RIPPLE, seed=3, reason="the live run is invalid: " + "slow " * 20),),
        differences=tuple(compared(name) for name in FIGURES),
    )


def cells(text: str, label: str) -> list[str]:
    (line,) = [line for line in text.splitlines() if re.match(rf"{re.escape(label)}  ", line)]
    return re.split(r"\s{2,}", line.strip())


def test_text_has_a_line_a_figure() -> None:
    text = format_agreement([agreement()])
    assert "baseline on artifact, model lite: 3 pairs, 1 left out" in text
    assert cells(text, "figure") == [
        "figure",
        "sim",
        "live",
        "live − sim",
        "95 % interval",
        "pairs",
        "agrees",
    ]
    assert cells(text, "iou") == ["iou", "0.500", "0.300", "-0.200", "[-0.300, -0.100]", "3", "no"]
    assert cells(text, "t_down_s") == ["t_down_s", "3.500", "3.750", "+0.250", "1", "yes"]
    assert cells(text, "miou") == ["miou", "N/A", "N/A", "N/A", "0", "N/A"]


def test_flights_of_one_model_are_told_apart() -> None:
    flights = (Flight(20.0, bag="3c" * 32), Flight(4.0, looped=True, bag="7e" * 32))
    several = [replace(agreement(), flight=flight) for flight in flights]
    text = format_agreement(several)
    assert "model lite [flight 3c3c3c3c]: 3 pairs" in text
    assert "model lite [4 s] [looped] [flight 7e7e7e7e]: 3 pairs" in text
    rows = json.loads(format_agreement(several, "json"))["rows"]
    assert [row["duration_s"] for row in rows] == [20.0, 4.0]


def test_text_is_aligned_and_fits_a_hundred_columns() -> None:
    text = format_agreement([agreement()])
    assert max(map(len, text.splitlines())) <= 100
    ends = {line.index(" 0  N/A") for line in text.splitlines() if line.endswith(" 0  N/A")}
    assert len(ends) == 1


def test_text_tells_how_often_the_same_happened_and_where_it_did_not() -> None:
    text = " ".join(format_agreement([agreement()]).split())
    assert "The same failures appeared in 2 of 3 pairs, throughout in 1 of 2 scenarios." in text
    assert "The same adaptations were executed in 2 of 3 pairs, throughout in 1 of 2 scenarios." in text
    assert f"{RIPPLE}, seed 2: failures F1 → F1 F2" in text
    assert f"{RIPPLE}, seed 2: redeploy camera 1 → 2" in text
    assert f"{RIPPLE}, seed 1:" not in text


def test_text_tells_what_is_left_out_and_what_only_one_of_two_runs_has() -> None:
    text = " ".join(format_agreement([agreement()]).split())
    assert f"Left out: {RIPPLE}, seed 3: the live run is invalid: slow slow" in text
    assert "Only one of the two runs has t_down_s in 2 more pairs." in text
    assert "within 20 % of the simulation's or, of a time, within 0.5 s." in text


def test_text_without_a_pair_has_no_table() -> None:
    text = format_agreement([agreement(pairs=False)])
    assert "baseline on artifact, model lite: 0 pairs, 1 left out" in text
    assert "Left out:" in text
    assert "live − sim  " not in text


def test_text_says_why_a_figure_has_no_interval() -> None:
    note = "Figures of fewer than 3 seeds have no confidence interval:"
    assert note not in format_agreement([agreement()])
    few = replace(compared("iou"), difference=Estimate(-0.2, 0.1, None, None, 2))
    assert note in format_agreement([replace(agreement(), differences=(few,))])


def test_json_has_figures_scenarios_and_what_is_left_out() -> None:
    (row,) = json.loads(format_agreement([agreement()], "json"))["rows"]
    assert (row["manager"], row["suite"], row["model"], row["pairs"]) == ("baseline", "artifact", "lite", 3)
    assert row["figures"]["iou"] == {
        "sim": 0.5,
        "live": 0.3,
        "difference": {"mean": -0.2, "std": 0.1, "ci95": [-0.3, -0.1], "runs": 3},
        "pairs": 3,
        "one_sided": 0,
        "agrees": False,
    }
    assert row["scenarios"][1] == {
        "scenario": RIPPLE,
        "seed": 2,
        "same_failures": False,
        "same_adaptations": False,
        "failures": {"sim": ["F1"], "live": ["F1", "F2"]},
        "adaptations": {"sim": {"redeploy camera": 1}, "live": {"redeploy camera": 2}},
    }
    assert [(one["scenario"], one["seed"]) for one in row["left_out"]] == [(RIPPLE, 3)]


def test_an_unknown_format_is_refused() -> None:
    with pytest.raises(InvalidInputError, match=f"be {' or '.join(AGREEMENT_FORMATS)}, got 'clay'"):
        format_agreement([], "clay")
