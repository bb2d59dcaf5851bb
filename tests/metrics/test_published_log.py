"""What the paper's evaluation script takes from a log, with every figure worked out by hand."""

from collections.abc import Sequence

import pytest

from sunset.metrics import LogRow, LogSource, StrategyStatus, log_figures


def frames(first: int, last: int, iou: float = 0.5) -> list[LogRow]:
    """Return a frame every 0.1 s; first and last in tenths of a second."""
    return [LogRow(number * 10**8, LogSource.EVALUATOR, iou=iou) for number in range(first, last + 1)]


def fault(seconds: float, name: str) -> LogRow:
    return LogRow(round(seconds * 1e9), LogSource.SCENARIO_EXECUTOR, fault=name)


def outcome(seconds: float, rule: str, status: StrategyStatus = StrategyStatus.SUCCEEDED) -> LogRow:
    return LogRow(round(seconds * 1e9), LogSource.ANALYZER, rule, rule, status)


def trigger(seconds: float, rule: str) -> list[LogRow]:
    """Return a trigger, and the execution of the rule's strategy."""
    return [
        LogRow(round(seconds * 1e9), LogSource.ANALYZER, rule=rule),
        LogRow(round(seconds * 1e9), LogSource.PLANNING, strategy=rule, status=StrategyStatus.EXECUTED),
    ]


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
    assert (found.refused, found.executed, found.succeeded) == ("", 3, 1)
    assert (found.redeploys, found.redeploys_unnecessary) == (2, 1)
    assert (found.reactions_s.number, found.reactions_s.mean) == (1, 2.0)
    assert found.t_down_s == pytest.approx(3.0)
    assert found.ious.number == 30 + 13
    assert found.ious.mean == pytest.approx((30 * 0.2 + 13 * 0.8) / 43)
    assert found.ious.deviation == pytest.approx((30 * 13 / 43**2) ** 0.5 * 0.6)  # of two values


def test_of_a_rule_that_fails_and_goes_on_its_trigger_counts() -> None:
    rule = "redeploy_camera"
    events = [*trigger(1.05, rule), outcome(1.55, rule, StrategyStatus.FAILED)]
    found = log_figures(in_order(*frames(1, 60), *events, outcome(2.05, rule, StrategyStatus.RESOLVED)))
    assert (found.refused, found.executed, found.succeeded, found.reactions_s.total) == ("", 1, 1, 1.0)


def test_of_a_rule_that_is_triggered_again_after_it_failed_the_last_trigger_counts() -> None:
    rule = "redeploy_camera"
    events = [
        *trigger(1.05, rule),
        outcome(1.45, rule, StrategyStatus.FAILED),
        *trigger(1.55, rule),
        outcome(2.05, rule),
    ]
    found = log_figures(in_order(*frames(1, 60), *events))
    assert (found.refused, found.succeeded, found.reactions_s.total) == ("", 1, 0.5)


def test_the_last_four_rows_of_a_log_are_not_looked_at() -> None:
    found = log_figures(
        in_order(*frames(1, 20), *trigger(1.05, "redeploy_camera"), outcome(2.05, "redeploy_camera"))
    )
    assert (found.succeeded, found.ious.number) == (0, 17)


def test_a_gap_to_the_end_is_not_one() -> None:
    found = log_figures(in_order(*frames(1, 20), *trigger(3.0, "redeploy_camera"), *frames(200, 203)))
    assert found.t_down_s == 0  # the frames of the other end of the gap are the rows that are dropped


CAMERA = trigger(0.55, "redeploy_camera")


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        ([*frames(1, 13), *CAMERA], "it has fewer than 10 frames"),
        (frames(1, 100), "no rule was triggered"),
        ([*frames(0, 100), *CAMERA], "a time in it is 0"),
        ([*frames(17 * 10**9, 17 * 10**9 + 100), *CAMERA], "a time in it is of a wall clock"),
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
    assert found.redeploys_unnecessary == found.redeploys - 1
