"""How right diagnoses are, worked out by hand."""

import math
from collections.abc import Mapping

import pytest

from sunset.metrics import Diagnosis, Injection, RunMetrics, Setting, Timeline, score

GPU = Injection(2.0, "gpu_failure", "F3", "segmentation", ended=8.0, cause="")
SHIFT = Injection(4.0, "image_shift", "F4", "sensor_fusion")
FAULTS = 11
"""How many the catalogue has."""


def diagnosed(
    *diagnoses: tuple[float, Mapping[str, float]], faults: tuple[Injection, ...] = (GPU,)
) -> RunMetrics:
    timeline = Timeline(
        thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.1},
        injections=faults,
        diagnoses=tuple(Diagnosis(time, probabilities) for time, probabilities in diagnoses),
    )
    return score(timeline)


def levels(metrics: RunMetrics) -> tuple[int | None, ...]:
    """Return how many faults were detected, located, identified and top 1."""
    return (
        metrics.faults_detected,
        metrics.faults_located,
        metrics.faults_identified,
        metrics.faults_top1,
    )


def times(metrics: RunMetrics) -> tuple[float | None, ...]:
    return metrics.t_detected_s, metrics.t_located_s, metrics.t_identified_s


@pytest.mark.parametrize("late", [(), ((20.0, {"gpu_failure": 0.9}),)])
def test_a_run_without_a_diagnosis_names_nothing(late: tuple[tuple[float, Mapping[str, float]], ...]) -> None:
    metrics = diagnosed(*late)
    assert (metrics.diagnoses, levels(metrics), times(metrics)) == (0, (0, 0, 0, 0), (None, None, None))
    assert (metrics.false_alarms, metrics.faultless_s) == (0, 14.0)
    assert metrics.brier == pytest.approx(6 / 20 / FAULTS)


def test_a_perfect_run_has_perfect_figures() -> None:
    metrics = diagnosed(
        (2.0, {"gpu_failure": 1.0}),
        (4.0, {"gpu_failure": 1.0, "image_shift": 1.0}),
        (8.0, {"image_shift": 1.0}),
        faults=(GPU, SHIFT),
    )
    assert (levels(metrics), times(metrics)) == ((2, 2, 2, 2), (0.0, 0.0, 0.0))
    assert (metrics.false_alarms, metrics.faultless_s, metrics.brier) == (0, 2.0, 0.0)


def test_a_run_without_faults_and_diagnoses_is_perfect() -> None:
    metrics = diagnosed((1.0, {}), faults=())
    assert (metrics.diagnoses, levels(metrics), times(metrics)) == (1, (0, 0, 0, 0), (None, None, None))
    assert (metrics.false_alarms, metrics.faultless_s, metrics.brier) == (0, 20.0, 0.0)


def test_a_fault_is_detected_then_located_then_identified() -> None:
    metrics = diagnosed(
        (3.0, {"sync_issue": 0.9}),
        (4.0, {"cuda_out_of_memory": 0.9, "gpu_failure": 0.4}),
        (5.0, {"cuda_out_of_memory": 0.6, "gpu_failure": 0.5}),
        (6.0, {"cuda_out_of_memory": 0.2, "gpu_failure": 0.5}),
    )
    assert (levels(metrics), times(metrics)) == ((1, 1, 1, 1), (1.0, 2.0, 3.0))


def test_two_suspects_tell_together_that_a_fault_is_there() -> None:
    # 1 - 0.7 * 0.7 = 0.51
    metrics = diagnosed((3.0, {"cuda_out_of_memory": 0.3, "gpu_failure": 0.3}))
    assert levels(metrics) == (1, 1, 0, 0)


def test_equal_probabilities_of_more_faults_than_there_are_have_no_top_1() -> None:
    both = {"cuda_out_of_memory": 0.5, "gpu_failure": 0.5}
    assert levels(diagnosed((3.0, both))) == (1, 1, 1, 0)
    two = (GPU, Injection(2.0, "cuda_out_of_memory", "F3", "segmentation"))
    # from 8 s on the second fault is alone, and both have the same probability still
    assert levels(diagnosed((3.0, both), faults=two)) == (2, 2, 2, 1)


def test_names_that_are_flashed_in_turn_identify_nothing_that_they_leave_before_the_fault_ends() -> None:
    names = ("camera_driver_issue", "gpu_failure", "image_shift")
    turns = [(2.0 + 0.1 * place, {names[place % 3]: 1.0}) for place in range(61)]
    assert levels(diagnosed(*turns)) == (1, 0, 0, 0)


def test_a_diagnosis_counts_within_eight_seconds_while_the_fault_is_there() -> None:
    def found(time: float, fault: Injection) -> int | None:
        return diagnosed((time, {fault.fault: 1.0}), faults=(fault,)).faults_identified

    assert [found(time, SHIFT) for time in (11.9, 12.0)] == [1, 0]
    assert [found(time, GPU) for time in (7.9, 8.0)] == [1, 0]


def test_a_diagnosis_just_before_the_cure_counts() -> None:
    metrics = diagnosed((7.999, {"gpu_failure": 0.9}))
    assert (levels(metrics), metrics.t_identified_s) == ((1, 1, 1, 1), 5.999)


def test_a_fault_that_comes_and_goes_counts_each_time() -> None:
    again = Injection(10.0, "gpu_failure", "F3", "segmentation")
    metrics = diagnosed((3.0, {"gpu_failure": 1.0}), faults=(GPU, again))
    assert (metrics.faults_injected, levels(metrics)) == (2, (2, 2, 2, 2))
    assert metrics.t_identified_s == 0.5  # after 1 s, and at once


def test_a_false_alarm_begins_while_no_fault_is_there() -> None:
    alarm = {"gpu_failure": 0.9}
    metrics = diagnosed(
        (-2.0, alarm),  # begins at 0
        (1.0, {}),
        (3.0, alarm),  # not false
        (10.0, {"gpu_failure": 0.3}),
        (11.0, alarm),
        (12.0, {"sync_issue": 0.9}),  # the same alarm
    )
    assert (metrics.false_alarms, metrics.faultless_s) == (2, 14.0)


def test_the_brier_score_is_a_mean_over_time_and_faults() -> None:
    metrics = diagnosed((4.0, {"gpu_failure": 0.5, "sync_issue": 0.2}))
    # the fault: 2 s without a diagnosis, 4 s with 0.5, then 12 s too long; the other one: 16 s
    total = 2 * 1.0 + 4 * 0.25 + 12 * 0.25 + 16 * 0.04
    assert metrics.brier == pytest.approx(total / 20 / FAULTS)


def test_a_fault_that_is_worked_around_is_there() -> None:
    depth = Injection(0.0, "depth_degradation", "F4", "depth", internal=False)
    timeline = Timeline(
        thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.1},
        injections=(depth,),
        settings=(Setting(0.5, "sensor_fusion", "modality", "1"),),
        diagnoses=(Diagnosis(1.0, {"depth_degradation": 1.0}),),
    )
    metrics = score(timeline)
    assert metrics.outcomes[0].cured == 0.5
    assert (metrics.faults_identified, metrics.t_identified_s, metrics.faultless_s) == (1, 1.0, 0.0)


@pytest.mark.parametrize("said", [{"gpu_failure": math.nan}, {"gpu_failure": 7.0}, {"no_such_fault": 1.0}])
def test_what_is_not_a_probability_or_a_fault_names_nothing(said: Mapping[str, float]) -> None:
    metrics = diagnosed((0.0, said))
    assert (levels(metrics), metrics.false_alarms) == ((0, 0, 0, 0), 0)
    assert metrics.brier == pytest.approx(6 / 20 / FAULTS)


def test_who_names_every_fault_has_no_top_1_and_a_bad_brier_score() -> None:
    every = dict.fromkeys(
        (
            *("camera_driver_issue", "hardware_disconnect", "sync_issue", "memory_leakage"),
            *("cuda_out_of_memory", "gpu_failure", "image_degradation", "unneeded_enhancement"),
            *("image_shift", "depth_degradation", "autofocus_needed"),
        ),
        1.0,
    )
    metrics = diagnosed((0.0, every))
    assert (levels(metrics), metrics.false_alarms) == ((1, 1, 1, 0), 1)
    assert metrics.brier == pytest.approx(1 - 6 / 20 / FAULTS)


def test_many_diagnoses_are_looked_at_once_each() -> None:
    # one look at all of them for each takes minutes here
    many = [(number / 2_000, {"gpu_failure": number % 2}) for number in range(40_000)]
    metrics = diagnosed(*many)
    assert metrics.diagnoses == 40_000
    assert metrics.brier == pytest.approx(0.5 / FAULTS, abs=1e-3)
