"""What the paper's evaluation script takes from a log, with every figure worked out by hand."""

from collections.abc import Sequence

import pytest

from sunset.evaluation.published import (
    ANALYZER,
    EVALUATOR,
    EXECUTED,
    EXECUTOR,
    PLANNING,
    RESOLVED,
    SUCCEEDED,
    LogFigures,
    LogRow,
    log_figures,
)

FAILED = 4


def frames(first: int, last: int, iou: float = 0.5) -> list[LogRow]:
    """Return a frame every 0.1 s; first and last in tenths of a second."""
    return [LogRow(number * 10**8, EVALUATOR, iou=iou) for number in range(first, last + 1)]


def fault(seconds: float, name: str) -> LogRow:
    return LogRow(round(seconds * 1e9), EXECUTOR, fault=name)


def outcome(seconds: float, rule: str, status: int = SUCCEEDED) -> LogRow:
    return LogRow(round(seconds * 1e9), ANALYZER, rule, rule, status)


def trigger(seconds: float, rule: str) -> list[LogRow]:
    """Return a trigger, and the execution of the rule's strategy."""
    return [
        LogRow(round(seconds * 1e9), ANALYZER, rule=rule),
        LogRow(round(seconds * 1e9), PLANNING, strategy=rule, status=EXECUTED),
    ]


def successes(found: LogFigures) -> list[float]:
    return list(found.values["f_resolved_per_adaptation"])


def in_order(*rows: LogRow) -> list[LogRow]:
    return sorted(rows, key=lambda row: row.time_ns)


def test_figures_of_a_log_worked_out_by_hand() -> None:
    found = log_figures(
        in_order(
            *frames(1, 30, 0.2),
            fault(3.05, "gpu_failure"),
            fault(3.05, "image_shift"),
            *trigger(4.25, "redeploy_segmentation"),
            *trigger(4.25, "redeploy_sensor_fusion"),
            *trigger(5.25, "do_recalibration"),
            *frames(60, 72, 0.8),  # three before the last event, and the ten after it that count
            outcome(6.25, "redeploy_segmentation"),
            *frames(73, 200, 1.0),
        )
    )
    assert found.refused == ""
    assert {name: list(values) for name, values in found.values.items()} == {
        "f_resolved_per_adaptation": [pytest.approx(1 / 3)],
        "t_react_s": [2.0],
        "redeploys_unnecessary": [1],  # two, and one fault that only a redeploy cures
        "t_down_s": [pytest.approx(3.0)],
        "iou": [0.2] * 30 + [0.8] * 13,
    }


def test_the_same_log_by_the_definitions_of_the_project() -> None:
    # 20 s from 3.05 s on: silent from 3.0 to 6.0 s, and from 20.0 s to the end
    log = in_order(*frames(1, 30, 0.2), fault(3.05, "gpu_failure"), *frames(60, 200, 0.8))
    found = log_figures(log).own
    assert {name: list(values) for name, values in found.items()} == {
        "t_down_s": [pytest.approx(2.95 + 3.05)],
        "iou": [pytest.approx(0.8)],
        "iou_all": [pytest.approx(141 * 0.8 / 200)],
    }
    assert log_figures(frames(1, 200)).own == {}
    assert log_figures([fault(0.05, "gpu_failure"), *frames(1, 8)]).own == {}


def test_of_a_rule_that_fails_and_goes_on_its_trigger_counts() -> None:
    rule = "redeploy_camera"
    events = [*trigger(1.05, rule), outcome(1.55, rule, FAILED)]
    found = log_figures(in_order(*frames(1, 60), *events, outcome(2.05, rule, RESOLVED)))
    assert (found.refused, successes(found), found.values["t_react_s"]) == ("", [1.0], [1.0])


def test_of_a_rule_that_is_triggered_again_after_it_failed_the_last_trigger_counts() -> None:
    rule = "redeploy_camera"
    events = [
        *trigger(1.05, rule),
        outcome(1.45, rule, FAILED),
        *trigger(1.55, rule),
        outcome(2.05, rule),
    ]
    found = log_figures(in_order(*frames(1, 60), *events))
    assert (found.refused, successes(found), found.values["t_react_s"]) == ("", [0.5], [0.5])


def test_the_last_four_rows_of_a_log_are_not_looked_at() -> None:
    found = log_figures(
        in_order(*frames(1, 20), *trigger(1.05, "redeploy_camera"), outcome(2.05, "redeploy_camera"))
    )
    assert (successes(found), len(found.values["iou"])) == ([0.0], 17)


def test_a_gap_to_the_end_is_not_one() -> None:
    found = log_figures(in_order(*frames(1, 20), *trigger(3.0, "redeploy_camera"), *frames(200, 203)))
    assert found.values["t_down_s"] == [
        0
    ]  # the frames of the other end of the gap are the rows that are dropped


CAMERA = trigger(0.55, "redeploy_camera")


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        ([*frames(1, 13), *CAMERA], "it has fewer than 10 frames"),
        (frames(1, 100), "no rule was triggered"),
        ([*frames(0, 100), *CAMERA], "a time in it is 0 or of a wall clock"),
        ([*frames(17 * 10**9, 17 * 10**9 + 100), *CAMERA], "a time in it is 0 or of a wall clock"),
        (
            [*frames(1, 100), *CAMERA, *trigger(0.75, "redeploy_camera")],
            "the rule redeploy_camera is triggered again before its outcome",
        ),
    ],
    ids=["few frames", "no rule", "time 0", "wall time", "twice"],
)
def test_a_log_is_refused_but_for_its_redeploys(rows: Sequence[LogRow], reason: str) -> None:
    found = log_figures(in_order(*rows, fault(0.1, "gpu_failure")))
    assert found.refused == reason
    redeploys = sum(row.source == PLANNING for row in rows)
    assert {name: list(values) for name, values in found.values.items()} == {
        "redeploys_unnecessary": [redeploys - 1]
    }


def test_a_log_out_of_order_is_refused() -> None:
    assert log_figures([*CAMERA, *frames(1, 100)]).refused == "its times do not ascend"
