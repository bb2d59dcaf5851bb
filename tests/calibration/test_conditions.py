"""Conditions do to a frame what the nodes of the pipeline do."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sunset.calibration import (
    Condition,
    cure_of,
    effects,
    plan_curves,
    possible_pairs,
    suite_strengths,
)
from sunset.errors import InvalidInputError
from sunset.image_messages import array_of_bgr, image_of_bgr, image_of_depth
from sunset.nodes import Camera, Depth, Fusion, ImageEnhancement
from sunset.perception import Modality, load_model
from sunset.system import BLUR_SIGMA, current_system
from sunset.system_interfaces.msg import SensorFusion
from sunset_ros.interfaces.builtin_interfaces.msg import Time
from sunset_ros.interfaces.std_msgs.msg import Header

EXCLUSIVE = current_system().exclusive
FAULTS = current_system().faults
UNSURE = ("image_degradation", "unneeded_enhancement", "image_shift", "depth_degradation")
BLURRED = "autofocus_needed"

if TYPE_CHECKING:
    from tests.conftest import World

pytestmark = pytest.mark.thorough

RNG = np.random.default_rng(5)
BGR = RNG.integers(0, 256, (48, 128, 3), dtype=np.uint8)
DEPTH = RNG.integers(1000, 5000, (48, 128), dtype=np.uint16)
NODES = (Camera, Depth, ImageEnhancement, Fusion)


def piped(world: "World", parameters: dict[str, dict[str, object]], *, enhance: bool = False) -> SensorFusion:
    """Send one frame through real nodes; return the message that reaches the segmentation."""
    for node in NODES:
        own = {"lifecycle_activation_delay": 0.0} if node is not ImageEnhancement else {}
        world.start(node, parameters=own | parameters.get(node.node_name, {}))
    world.run(0.2)
    if enhance:
        assert world.transition("image_enhancement", "activate")
        assert world.set("sensor_fusion", "topic_camera_input", "rgb_enhanced").successful
        world.run(0.2)
    header = Header(stamp=Time(sec=1, nanosec=0), frame_id="camera")
    world.publish("/depth_raw", image_of_depth(header, DEPTH))
    world.publish("/rgb_raw", image_of_bgr(header, BGR))
    world.run(0.2)
    fused: SensorFusion
    (fused,) = world.messages["/managed_subsystem/sensors_fused"]
    return fused


def test_the_camera_degrades_then_blurs_and_the_fusion_shifts(world: "World") -> None:
    fused = piped(
        world,
        {
            "camera": {"image_degradation": 0.8, "autofocus_needed": True},
            "sensor_fusion": {"image_shift": 14},
        },
    )
    faults = {"image_degradation": 0.8, BLURRED: BLUR_SIGMA, "image_shift": 14.0}
    seen = Condition(Modality.FUSION).with_faults(faults).seen(BGR, DEPTH, RNG)
    np.testing.assert_array_equal(seen.bgr, array_of_bgr(fused.rgb))
    camera = array_of_bgr(world.messages["/managed_subsystem/rgb_camera"][0])
    expected = Condition(Modality.FUSION).with_faults(faults | {"image_shift": 0.0}).seen(BGR, DEPTH, RNG)
    np.testing.assert_array_equal(expected.bgr, camera)
    assert seen.sharpness == expected.sharpness


def test_enhanced_images_are_enhanced_after_the_camera_and_before_the_shift(world: "World") -> None:
    strengths: dict[str, dict[str, object]] = {
        "camera": {"image_degradation": 0.5},
        "image_enhancement": {"image_degradation": 0.7},
        "sensor_fusion": {"image_shift": 6},
    }
    fused = piped(world, strengths, enhance=True)
    faults = {"image_degradation": 0.5, "unneeded_enhancement": 0.7, "image_shift": 6.0}
    seen = Condition(Modality.FUSION).with_faults(faults).seen(BGR, DEPTH, RNG)
    np.testing.assert_array_equal(seen.bgr, array_of_bgr(fused.rgb))


@pytest.mark.parametrize("fault", [*UNSURE, BLURRED])
def test_the_cure_leads_back_to_a_frame_without_the_fault(fault: str) -> None:
    nominal = Condition(Modality.FUSION)
    faulty = nominal.with_faults({fault: suite_strengths()[fault]})
    cured = faulty.cured_of(fault)
    assert faulty not in {nominal, cured}
    if fault == "depth_degradation":
        assert cured == Condition(Modality.RGB)
    elif fault == "image_degradation":
        restored = cured.seen(BGR, DEPTH, RNG).bgr.astype(int)
        assert np.abs(restored - BGR).max() <= 3
        assert np.abs(faulty.seen(BGR, DEPTH, RNG).bgr.astype(int) - BGR).max() > 50
    else:
        assert cured == nominal


@pytest.mark.parametrize("fault", [*UNSURE, BLURRED])
def test_a_cure_is_that_of_the_catalogue_and_ends_no_other_fault(fault: str) -> None:
    assert cure_of(fault) == FAULTS[fault].cures[0]
    for other in (*UNSURE, BLURRED):
        if {fault, other} not in [set(pair) for pair in EXCLUSIVE] and other != fault:
            alone = Condition(Modality.FUSION).with_faults({other: suite_strengths()[other]})
            assert alone.cured_of(fault) == alone or fault == "depth_degradation"  # which drops a sensor


@given(strength=st.floats(0, 30), seed=st.integers(0, 99))
def test_noise_scales_with_the_strength_and_is_drawn_for_those_who_see_it(strength: float, seed: int) -> None:
    one, double = (
        Condition(Modality.FUSION)
        .with_faults({"depth_degradation": value})
        .seen(BGR, DEPTH + np.uint16(30000), np.random.default_rng(seed))
        .depth.astype(float)
        - (DEPTH + np.uint16(30000))
        for value in (strength, 2 * strength)
    )
    np.testing.assert_allclose(double, 2 * one, atol=2)
    unseen = Condition(Modality.RGB).with_faults({"depth_degradation": strength})
    assert unseen.seen(BGR, DEPTH, RNG).depth is DEPTH


def test_the_faults_are_those_of_the_catalogue() -> None:
    assert set(effects()) == {*UNSURE, BLURRED}
    assert set(UNSURE) == {name for name, fault in FAULTS.items() if fault.failure == "F4"}
    assert [name for name, fault in FAULTS.items() if fault.failure == "F5"] == [BLURRED]
    assert len(set(possible_pairs())) == 9


def test_strengths_are_those_of_the_suites_unless_others_are_given() -> None:
    strengths = suite_strengths({"image_degradation": 0.4, "image_shift": 5})
    assert strengths["unneeded_enhancement"] == strengths["image_degradation"] == 0.4
    assert strengths["image_shift"] == 5
    assert strengths["depth_degradation"] == FAULTS["depth_degradation"].value
    assert strengths[BLURRED] == BLUR_SIGMA


@pytest.mark.parametrize(
    ("fault", "strength", "words"),
    [
        ("rotor_failure", 1.0, "not to 'rotor_failure'"),
        ("gpu_failure", 1.0, "not to 'gpu_failure'"),
        ("unneeded_enhancement", 1.0, "its strength is that of image_degradation"),
        ("image_degradation", 2.0, "greater than 0 and at most 1.9, got 2"),
        ("depth_degradation", 0.0, "greater than 0 and at most 100, got 0"),
        ("depth_degradation", float("nan"), "got nan"),
        ("image_shift", 2.5, "a whole number greater than 0 and at most 1920, got 2.5"),
        (BLURRED, -1.0, "greater than 0"),
    ],
)
def test_a_strength_that_cannot_be_is_refused(fault: str, strength: float, words: str) -> None:
    with pytest.raises(InvalidInputError, match=words):
        suite_strengths({fault: strength})


def test_a_plan_holds_every_condition_once_and_every_suite_strength() -> None:
    plan = plan_curves(load_model("lite").card, {"image_shift": 7})
    conditions = plan.conditions()
    assert len(set(conditions)) == len(conditions)
    assert {(fault, plan.strengths[fault]) for fault in (*UNSURE, BLURRED)} <= set(plan.points)
    assert ("image_shift", 7.0) in plan.points
    assert conditions[: len(plan.networks)] == tuple(Condition(network) for network in Modality)
    for fault, strength in plan.points:
        assert plan.before(fault, strength=strength) in conditions
        assert plan.after(fault, strength) in conditions
    assert {plan.before(*pair) for pair in possible_pairs()} <= set(conditions)


def test_a_model_of_one_network_is_measured_with_the_faults_that_it_can_see() -> None:
    card = load_model("lite").card
    for modality, faults in (
        (Modality.DEPTH, {"depth_degradation"}),
        (Modality.RGB, {*UNSURE, BLURRED} - {"depth_degradation"}),
    ):
        alone = plan_curves(replace(card, networks={modality: card.networks[modality]}))
        assert {fault for fault, _ in alone.points} == faults
        assert all(condition.modality is modality for condition in alone.conditions())
