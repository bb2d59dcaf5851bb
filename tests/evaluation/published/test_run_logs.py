"""Which rules and strategies a log has of a run: times of messages, samples and commands are given."""

import numpy as np
import pytest

from sunset.evaluation.published import ANALYZER, EXECUTED, SUCCEEDED, rule_rows
from sunset.metrics import Command, Samples, Timeline

START_NS = 5 * 10**9
TOPICS = {"F1": "rgb_camera", "F2": "sensors_fused", "F3": "segmentation"}


def command(
    seconds: float, kind: str, node: str, *parameters: str, successful: bool = True, client: str = "/mine"
) -> Command:
    place = f"/managed_subsystem/{node}"
    return Command(seconds, client, place, kind, parameters, ("true",) * len(parameters), successful)


def run(
    *commands: Command,
    silent: dict[str, tuple[float, float]] | None = None,
    unsure: tuple[float, float] = (99.0, 99.0),
    blurred: tuple[float, float] = (99.0, 99.0),
) -> Timeline:
    """Return ten seconds in which failures have no messages, or bad samples, from one time to another."""
    times = np.arange(-20, 110) / 10

    def within(span: tuple[float, float]) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        return (times >= span[0] - 1e-6) & (times < span[1] - 1e-6)

    return Timeline(
        duration_s=10.0,
        message_times={
            f"/managed_subsystem/{topic}": times[~within((silent or {}).get(failure, (99.0, 99.0)))]
            for failure, topic in TOPICS.items()
        },
        samples={
            "segmentation_entropy": Samples(times, np.where(within(unsure), 0.9, 0.1)),
            "camera_sharpness": Samples(times, np.where(within(blurred), 0.1, 0.9)),
        },
        thresholds={"entropy_threshold": 0.5, "sharpness_threshold": 0.5},
        commands=commands,
        expected_frames=100,
    )


def told(timeline: Timeline) -> list[tuple[float, str, str, int]]:
    """Return seconds, rule or source, strategy and status of the rows."""
    return [
        (
            round((row.time_ns - START_NS) / 1e9, 6),
            row.rule if row.source is ANALYZER else "planning",
            row.strategy,
            row.status,
        )
        for row in sorted(rule_rows(timeline, START_NS), key=lambda row: row.time_ns)
    ]


def test_a_rule_succeeds_at_the_first_look_without_its_symptom() -> None:
    # silent from the last message, 0.9, to 2.5: the looks after the trigger, at 2.05, are at 2.25, 2.45 and 2.65
    timeline = run(command(2.05, "redeploy", "segmentation"), silent={"F3": (1.0, 2.5)})
    assert told(timeline) == [
        (2.05, "redeploy_segmentation", "", 0),
        (2.05, "planning", "redeploy_segmentation", EXECUTED),
        (2.65, "redeploy_segmentation", "redeploy_segmentation", SUCCEEDED),
    ]


def test_a_rule_without_an_end_has_no_outcome() -> None:
    timeline = run(command(3.0, "set_parameters", "sensor_fusion", "do_recalibration"), unsure=(2.0, 99.0))
    assert told(timeline) == [
        (3.0, "do_recalibration", "", 0),
        (3.0, "planning", "do_recalibration", EXECUTED),
    ]


def test_a_rule_that_is_triggered_is_not_triggered_again_before_its_outcome() -> None:
    tries = [command(time, "redeploy", "camera") for time in (2.1, 2.9, 6.0)]
    rows = told(run(*tries, silent={"F1": (1.0, 4.0)}))
    assert [(time, rule) for time, rule, _, _ in rows] == [
        (2.1, "redeploy_camera"),
        (2.1, "planning"),
        (2.9, "planning"),
        (4.1, "redeploy_camera"),  # its success
        (6.0, "planning"),  # without a symptom
    ]


@pytest.mark.parametrize(
    ("adaptation", "rule", "strategy"),
    [
        (("redeploy", "sensor_fusion"), "redeploy_sensor_fusion", "redeploy_sensor_fusion"),
        (("redeploy", "segmentation"), "do_recalibration", "redeploy_segmentation"),
        (("set_parameters", "sensor_fusion", "modality"), "do_recalibration", "modality"),
        (("set_parameters", "camera", "perform_autofocus"), "camera_sharpness", "perform_autofocus"),
        (("activate", "image_enhancement"), "do_recalibration", "activate_image_enhancement"),
        (("redeploy", "depth"), "do_recalibration", "redeploy_depth"),
    ],
)
def test_an_adaptation_answers_the_symptom_of_its_own_node_else_one_of_a_signal_downstream(
    adaptation: tuple[str, ...], rule: str, strategy: str
) -> None:
    timeline = run(
        command(3.0, *adaptation), silent={"F2": (1.0, 5.0)}, unsure=(1.0, 5.0), blurred=(1.0, 5.0)
    )
    first, second, *_ = told(timeline)
    assert (first[1], second[2]) == (rule, strategy)


def test_what_the_blackboard_may_still_have_told_is_answered() -> None:
    timeline = run(command(2.55, "redeploy", "camera"), silent={"F1": (1.0, 2.5)})
    assert [row[1] for row in told(timeline)] == ["redeploy_camera", "planning", "redeploy_camera"]


def test_requests_that_were_refused_or_came_from_the_experiment_are_not_strategies() -> None:
    timeline = run(
        command(2.0, "redeploy", "camera", successful=False),
        command(2.0, "redeploy", "camera", client="/scenario_executor"),
    )
    assert told(timeline) == []
