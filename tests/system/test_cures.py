"""Whether a cure is in place: the score, the world of an experiment and the page give the same answer."""

from dataclasses import replace
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.recording.runs import RUN

from sunset.harness._world import World
from sunset.metrics import Injection, Setting, Timeline, score
from sunset.recording import RecordedMessage, StoredRun
from sunset.system import (
    EXPERIMENT,
    LOG_TOPIC,
    STATE,
    Adaptation,
    AdaptationKind,
    Fault,
    FaultKind,
    Value,
    current_system,
    full_name,
    get_fault,
)
from sunset.system_interfaces.msg import ExperimentLogging
from sunset.texts.names import ros_text
from sunset.viewing.collecting import run_view

EXTERNAL = [fault for fault in current_system().faults.values() if fault.kind is FaultKind.EXTERNAL]
STRENGTHS = st.sampled_from([0.0, 0.01, 0.29, 0.31, 0.9])
CHANGES = st.one_of(
    st.tuples(st.just("camera"), st.just("image_degradation"), STRENGTHS),
    st.tuples(st.just("image_enhancement"), st.just("image_degradation"), STRENGTHS),
    st.tuples(st.just("image_enhancement"), st.just(STATE), st.sampled_from(["active", "inactive"])),
    st.tuples(st.just("sensor_fusion"), st.just("modality"), st.integers(0, 2)),
    st.tuples(
        st.just("sensor_fusion"),
        st.just("topic_camera_input"),
        st.sampled_from(["rgb_camera", "rgb_enhanced", "/managed_subsystem/rgb_enhanced"]),
    ),
)
Change = tuple[str, str, Value]
START = RecordedMessage(LOG_TOPIC, 0, ExperimentLogging(source=EXPERIMENT, rule_name="start", timestamp=0))


def seen_by_the_world(world: World, change: Change) -> None:
    node, name, value = change
    if name == STATE:
        world.see_transition(node, "activating" if value == "active" else "deactivating", str(value))
    else:
        world.see_value(node, name, value, declared=False)


@given(changes=st.lists(CHANGES, max_size=12))
def test_score_world_and_page_agree_on_whether_a_cure_is_in_place(changes: list[Change]) -> None:
    """One change every two seconds, looked at a second later."""
    duration_s = 2.0 * (len(changes) + 1)
    times = [2.0 * (place + 1) for place in range(len(changes))]
    timeline = Timeline(
        duration_s=duration_s,
        thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.1},
        injections=tuple(
            Injection(0.0, fault.name, fault.failure, full_name(fault.node), internal=False)
            for fault in EXTERNAL
        ),
        settings=tuple(
            Setting(time, full_name(node), name, ros_text(value))
            for time, (node, name, value) in zip(times, changes, strict=True)
        ),
    )
    figures = score(timeline)
    run = StoredRun(Path(), msgspec.structs.replace(RUN, duration_s=duration_s), timeline, figures, ())
    drawn = {view["name"]: view["around"] for view in run_view(run, [START], [], "")["faults"]}

    world, in_place_s = World(), dict.fromkeys((fault.name for fault in EXTERNAL), 0.0)
    for time, change in zip(times, changes, strict=True):
        seen_by_the_world(world, change)
        for fault in EXTERNAL:
            in_place_s[fault.name] += 2.0 * world.is_worked_around(fault)
            on_page = any(first <= time + 1.0 < last for first, last in drawn[fault.name])
            assert world.is_worked_around(fault) == on_page
    for outcome, fault in zip(figures.outcomes, EXTERNAL, strict=True):
        assert (outcome.cured is not None) == (in_place_s[fault.name] > 0)
        assert outcome.uncured_s == pytest.approx(duration_s - in_place_s[fault.name])


def test_the_cure_of_one_configuration_fault_leaves_another_one_in_the_world() -> None:
    wiring = get_fault("unneeded_enhancement")
    only_colour = Adaptation(AdaptationKind.SET_PARAMETER, "sensor_fusion", "modality", 1)
    mode = Fault(
        name="wrong_mode",
        failure="F4",
        node="sensor_fusion",
        description="The fusion uses the colour images only.",
        cures=((replace(only_colour, value=0),),),
        kind=FaultKind.CONFIGURATION,
        parameter="modality",
        value=1,
        injection=(only_colour,),
    )
    world = World()
    world.hold(wiring.injection, wiring)
    world.hold(mode.injection, mode)

    assert world.after_change_to("sensor_fusion", "topic_camera_input", "rgb_camera") == []

    assert not world.holds(wiring)
    assert world.holds(mode)
    assert world.after_transition("sensor_fusion", "unconfigured", "inactive") == list(mode.injection)
