from dataclasses import replace

import pytest

from sunset.errors import ScenarioError
from sunset.scenarios import suite_size
from sunset.system import Adaptation, AdaptationKind, FaultKind, current_system, get_fault

SYSTEM = current_system()

NODES = {"camera", "depth", "image_enhancement", "sensor_fusion", "segmentation"}

# The table of faults and their cures, written out by hand: (failure, node, kind, cures in words)
TABLE = {
    "camera_driver_issue": ("F1", "camera", "internal", [["restart camera"], ["redeploy camera"]]),
    "hardware_disconnect": ("F1", "camera", "internal", [["redeploy camera"]]),
    "sync_issue": (
        "F2",
        "sensor_fusion",
        "internal",
        [["restart sensor_fusion"], ["redeploy sensor_fusion"]],
    ),
    "memory_leakage": ("F2", "sensor_fusion", "internal", [["redeploy sensor_fusion"]]),
    "cuda_out_of_memory": (
        "F3",
        "segmentation",
        "internal",
        [["restart segmentation"], ["redeploy segmentation"]],
    ),
    "gpu_failure": ("F3", "segmentation", "internal", [["redeploy segmentation"]]),
    "image_degradation": (
        "F4",
        "camera",
        "external",
        [["activate image_enhancement", "set sensor_fusion.topic_camera_input to rgb_enhanced"]],
    ),
    "unneeded_enhancement": (
        "F4",
        "sensor_fusion",
        "configuration",
        [["set sensor_fusion.topic_camera_input to rgb_camera"]],
    ),
    "image_shift": (
        "F4",
        "sensor_fusion",
        "internal",
        [["set sensor_fusion.do_recalibration to true"], ["redeploy sensor_fusion"]],
    ),
    "depth_degradation": ("F4", "depth", "external", [["set sensor_fusion.modality to 1"]]),
    "autofocus_needed": (
        "F5",
        "camera",
        "internal",
        [["set camera.perform_autofocus to true"], ["redeploy camera"]],
    ),
}


def test_catalogue_is_the_table() -> None:
    found = {
        name: (
            fault.failure,
            fault.node,
            fault.kind,
            [[str(adaptation) for adaptation in cure] for cure in fault.cures],
        )
        for name, fault in SYSTEM.faults.items()
    }
    assert found == TABLE
    assert list(found) == list(TABLE)


def test_three_faults_need_a_redeploy() -> None:
    only = {fault.name for fault in SYSTEM.faults.values() if fault.redeploy_only}
    assert only == {"hardware_disconnect", "memory_leakage", "gpu_failure"}


def test_every_cure_is_an_adaptation_that_the_system_offers() -> None:
    assert {a for fault in SYSTEM.faults.values() for cure in fault.cures for a in cure} <= set(
        SYSTEM.adaptations
    )


def test_the_system_offers_nineteen_adaptations_of_five_nodes() -> None:
    assert len(SYSTEM.adaptations) == len(set(SYSTEM.adaptations)) == 19
    assert {adaptation.node for adaptation in SYSTEM.adaptations} == NODES


def test_suite_strengths_are_within_their_limits_and_other_than_healthy() -> None:
    for fault in SYSTEM.faults.values():
        assert fault.value != fault.healthy
        assert type(fault.value) is type(fault.healthy)
        if fault.limits is not None:
            assert isinstance(fault.value, int | float)
            assert fault.limits[0] <= fault.value <= fault.limits[1]
            assert fault.limits[0] == fault.healthy


def test_injection_sets_the_faults_parameter_last() -> None:
    for fault in SYSTEM.faults.values():
        last = fault.injection[-1]
        assert (last.node, last.parameter, last.value) == (fault.node, fault.parameter, fault.value)


def test_unneeded_enhancement_is_injected_by_rewiring_to_an_active_enhancement() -> None:
    words = [str(adaptation) for adaptation in get_fault("unneeded_enhancement").injection]
    assert words == ["activate image_enhancement", "set sensor_fusion.topic_camera_input to rgb_enhanced"]


def test_internal_faults_end_with_a_redeploy_of_their_node_and_others_do_not() -> None:
    for fault in SYSTEM.faults.values():
        redeploy = (Adaptation(AdaptationKind.REDEPLOY, fault.node),)
        assert (redeploy in fault.cures) == (fault.kind is FaultKind.INTERNAL)


def test_excluded_pairs_are_each_others_cure() -> None:
    for first, second in SYSTEM.exclusive:
        assert get_fault(first).cures[0] == get_fault(second).injection


def test_unknown_fault_is_refused_with_the_known_ones() -> None:
    with pytest.raises(
        ScenarioError, match=r"no fault 'gremlins': choose one of camera_driver_issue, .*needed\."
    ):
        get_fault("gremlins")


def test_catalogue_is_read_only() -> None:
    with pytest.raises(TypeError, match="does not support item assignment"):
        SYSTEM.faults["new"] = get_fault("gpu_failure")  # type: ignore[index]


def test_every_failure_says_what_one_sees() -> None:
    assert len({failure.description for failure in SYSTEM.failures.values()}) == 5


def test_what_is_upstream_follows_from_the_wiring() -> None:
    assert SYSTEM.upstream == {
        "camera": set(),
        "depth": set(),
        "image_enhancement": {"camera"},
        "sensor_fusion": {"camera", "depth", "image_enhancement"},
        "segmentation": {"camera", "depth", "image_enhancement", "sensor_fusion"},
    }


def test_the_node_that_fails_is_the_one_that_should_have_sent() -> None:
    assert SYSTEM.failing_nodes == {
        "F1": "camera",
        "F2": "sensor_fusion",
        "F3": "segmentation",
        "F4": "segmentation",
        "F5": "camera",
    }


def test_the_suites_have_so_many_scenarios() -> None:
    assert {name: suite_size(name) for name in SYSTEM.suites} == {
        "paper": 54,
        "artifact": 18,
        "nofault": 1,
        "degraded": 9,
        "single": 11,
        "outages": 20,
        "timed": 18,
        "transient": 14,
        "cascade": 7,
        "calm": 6,
        "long": 4,
    }


def test_a_fault_that_nothing_cures_is_not_cured_by_a_redeploy() -> None:
    assert not replace(get_fault("hardware_disconnect"), cures=()).redeploy_only
