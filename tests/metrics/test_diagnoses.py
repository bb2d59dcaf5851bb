"""How right diagnoses are, worked out by hand."""

import math
from collections.abc import Mapping

import pytest

from sunset.metrics import Diagnosis, Injection, RunMetrics, Setting, Timeline, score

GPU = Injection(2.0, "gpu_failure", "F3", "segmentation", ended=8.0, cause="")
SHIFT = Injection(4.0, "image_shift", "F4", "sensor_fusion")


def diagnosed(*diagnoses: tuple[float, Mapping[str, float]], faults: tuple[Injection, ...]) -> RunMetrics:
    timeline = Timeline(
        thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.1},
        injections=faults,
        diagnoses=tuple(Diagnosis(time, probabilities) for time, probabilities in diagnoses),
    )
    return score(timeline)


def test_without_a_diagnosis_there_are_no_figures() -> None:
    for late in ((), ((20.0, {"gpu_failure": 0.9}),)):
        metrics = diagnosed(*late, faults=(GPU,))
        assert (metrics.diagnosis_precision, metrics.diagnosis_recall, metrics.t_diagnosis_s) == (None,) * 3


def test_a_diagnosis_holds_until_the_next_one() -> None:
    # there: the first from 2 to 8 s, the second from 4 to 20 s, in all 22 s
    metrics = diagnosed(
        (3.0, {"gpu_failure": 0.9, "image_shift": 0.2}),  # right until 4 s
        (5.0, {"gpu_failure": 0.9, "image_shift": 0.5}),  # right until 8 s, then half right
        (10.0, {"image_shift": 0.7, "sync_issue": 0.49}),
        faults=(GPU, SHIFT),
    )
    # named: 3 to 10 s and 5 to 20 s, in all 22 s; rightly 3 to 8 s and 5 to 20 s
    assert metrics.diagnosis_precision == pytest.approx(20 / 22)
    assert metrics.diagnosis_recall == pytest.approx(20 / 22)
    assert [one.diagnosed for one in metrics.outcomes] == [3.0, 5.0]
    assert metrics.t_diagnosis_s == 1.0


def test_a_fault_without_a_right_diagnosis_has_none() -> None:
    metrics = diagnosed((0.0, {"gpu_failure": 1.0, "sync_issue": 1.0}), faults=(GPU,))
    assert metrics.diagnosis_precision == pytest.approx(6 / 40)
    assert metrics.diagnosis_recall == 1.0
    assert [one.diagnosed for one in metrics.outcomes] == [None]
    assert metrics.t_diagnosis_s is None


def test_naming_nothing_while_nothing_is_there_is_no_right_diagnosis_of_a_fault() -> None:
    metrics = diagnosed((1.0, {}), faults=(GPU,))
    assert (metrics.diagnosis_precision, metrics.diagnosis_recall) == (None, 0.0)
    assert [one.diagnosed for one in metrics.outcomes] == [None]


def test_a_diagnosis_that_was_there_before_is_right_from_the_onset_on() -> None:
    metrics = diagnosed((-2.0, {"gpu_failure": 1.0}), faults=(GPU,))
    assert metrics.t_diagnosis_s == 0.0
    assert metrics.diagnosis_precision == pytest.approx(6 / 20)


def test_who_names_all_in_turn_has_found_nothing_out() -> None:
    names = ("sync_issue", "gpu_failure", "image_shift", "memory_leakage")
    turns = [(2.0 + number / 100, {names[number % 4]: 1.0}) for number in range(500)]
    metrics = diagnosed(*turns, faults=(GPU,))
    assert [one.diagnosed for one in metrics.outcomes] == [None]


def test_a_right_diagnosis_lasts_a_second_or_as_long_as_the_same_faults_are_there() -> None:
    def found(*diagnoses: tuple[float, Mapping[str, float]]) -> float | None:
        return diagnosed(*diagnoses, faults=(GPU,)).outcomes[0].diagnosed

    right, wrong = {"gpu_failure": 1.0}, {"gpu_failure": 1.0, "sync_issue": 1.0}
    assert found((3.0, right), (4.0, wrong)) == 3.0
    assert found((3.0, right), (3.5, right), (4.25, {})) == 3.0
    assert found((3.0, right), (3.9, wrong)) is None
    assert found((7.9, right), (8.0, {})) == 7.9  # until it was cured


def test_a_fault_that_is_worked_around_is_there() -> None:
    depth = Injection(0.0, "depth_degradation", "F4", "depth", internal=False)
    timeline = Timeline(
        thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.1},
        injections=(depth,),
        settings=(Setting(0.5, "sensor_fusion", "modality", "1"),),
        diagnoses=(Diagnosis(0.0, {"depth_degradation": 1.0}),),
    )
    metrics = score(timeline)
    assert metrics.outcomes[0].cured == 0.5
    assert (metrics.diagnosis_precision, metrics.diagnosis_recall) == (1.0, 1.0)


def test_what_is_not_a_probability_names_nothing() -> None:
    metrics = diagnosed((0.0, {"gpu_failure": math.nan}), faults=(GPU,))
    assert (metrics.diagnosis_precision, metrics.diagnosis_recall) == (None, 0.0)


def test_many_diagnoses_are_looked_at_once_each() -> None:
    # one look at all of them for each takes minutes here
    many = [(number / 5_000, {"gpu_failure": number % 2}) for number in range(100_000)]
    metrics = diagnosed(*many, faults=(GPU,))
    assert metrics.diagnosis_recall == pytest.approx(0.5, abs=1e-3)
    assert metrics.diagnosis_precision == pytest.approx(0.3, abs=1e-3)
