from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sunset.metrics import (
    Episode,
    ExecutedAdaptation,
    Injection,
    Samples,
    Spell,
    Timeline,
    excesses,
    failure_episodes,
    silences,
)
from sunset.system import Signal

Times = npt.NDArray[np.float64]

OVER, UNDER = Signal("segmentation", "entropy"), Signal("camera", "sharpness", below=True)


def steady(start: float, stop: float) -> Times:
    """Return 10 Hz times in [start, stop), on the tenths."""
    return np.arange(round(start * 10), round(stop * 10)) / 10


def samples(*pieces: tuple[float, float, float]) -> Samples:
    """Return 10 Hz samples: each piece is (start, stop, value)."""
    times = np.concatenate([steady(start, stop) for start, stop, _ in pieces])
    values = np.concatenate([np.full(len(steady(start, stop)), value) for start, stop, value in pieces])
    return Samples(times, values)


def silent(*pieces: tuple[float, float]) -> list[Spell]:
    times = np.concatenate([np.empty(0), *(steady(start, stop) for start, stop in pieces)])
    return silences(times, duration_s=20.0)


def over(*pieces: tuple[float, float, float]) -> list[Spell]:
    return excesses(samples(*pieces), OVER, 0.2, duration_s=20.0)


def test_steady_topic_is_never_silent() -> None:
    assert silent((-3, 20)) == []


def test_silence_holds_one_second_after_the_last_message_until_the_next() -> None:
    assert silent((-3, 5), (9, 20)) == [Spell(4.9, 5.9, 9.0)]


def test_silence_to_the_end_stays_open() -> None:
    assert silent((-3, 5)) == [Spell(4.9, 5.9, None)]


def test_topic_that_never_came_is_silent_from_zero() -> None:
    assert silent() == [Spell(0.0, 1.0, None)]


def test_topic_that_came_late_is_silent_from_zero() -> None:
    assert silent((3, 20)) == [Spell(0.0, 1.0, 3.0)]


def test_topic_that_fell_silent_in_the_warm_up_is_so_from_the_start() -> None:
    assert silent((-3, -2), (2, 20)) == [Spell(-2.1, 0.0, 2.0)]


def test_silence_that_ended_in_the_warm_up_does_not_count() -> None:
    assert silent((-5, -4), (-2, 20)) == []


@pytest.mark.parametrize(("gap", "count"), [(1.0, 0), (1.001, 1)])
def test_silence_of_a_second_is_the_limit(gap: float, count: int) -> None:
    times = np.concatenate([steady(-1, 5), steady(5, 20) + gap - 0.1])
    assert len(silences(times, duration_s=20.0)) == count


def test_last_second_of_the_run_shows_no_symptom() -> None:
    assert silent((-3, 19.1)) == []  # the last message at 19.0: the symptom would hold from 20.0
    assert silent((-3, 19.0)) == [Spell(18.9, 19.9, None)]


def test_messages_after_the_end_end_nothing() -> None:
    assert silent((-3, 5), (20.1, 22)) == [Spell(4.9, 5.9, None)]


def test_five_samples_over_the_threshold_hold_until_their_mean_falls_back() -> None:
    # 0.1 before 5.0, 0.4 from 5.0, 0.1 from 8.0; the mean of five passes 0.2 with the second high sample
    # (0.1·3 + 0.4·2 = 1.1 > 1.0) and falls back with the fourth low one (0.4·1 + 0.1·4 = 0.8 < 1.0;
    # with the third it is 0.4·2 + 0.1·3 = 1.1)
    (spell,) = over((-3, 5, 0.1), (5, 8, 0.4), (8, 20, 0.1))
    assert (spell.origin, spell.holds, spell.ended) == pytest.approx((4.7, 5.1, 8.3))


def test_a_single_high_frame_is_no_episode() -> None:
    assert over((-3, 5, 0.1), (5, 5.1, 0.59), (5.1, 20, 0.1)) == []  # (0.1·4 + 0.59) / 5 = 0.198


def test_mean_that_equals_the_threshold_is_not_over_it() -> None:
    assert excesses(samples((-3, 20, 0.25)), OVER, 0.25, duration_s=20.0) == []
    assert excesses(samples((-3, 20, 0.25)), UNDER, 0.25, duration_s=20.0) == []


def test_under_a_threshold_works_the_other_way_round() -> None:
    low = samples((-3, 5, 0.9), (5, 8, 0.1), (8, 20, 0.9))
    (spell,) = excesses(low, UNDER, 0.5, duration_s=20.0)
    # 0.9·2 + 0.1·3 = 2.1 < 2.5 at the third low sample; back with the third high one (2.9 > 2.5)
    assert (spell.origin, spell.holds, spell.ended) == pytest.approx((4.8, 5.2, 8.2))


def test_fewer_than_five_samples_give_no_verdict() -> None:
    assert over((5, 5.4, 0.9)) == []
    (spell,) = over((5, 5.5, 0.9))
    assert (spell.origin, spell.holds, spell.ended) == (5.0, 5.4, None)


def test_symptom_before_an_outage_neither_ends_nor_starts_anew_on_stale_samples() -> None:
    # high until the outage, low after it: ends with the fifth fresh sample, not the first
    (spell,) = over((-3, 5, 0.1), (5, 7, 0.4), (10, 20, 0.1))
    assert (spell.holds, spell.ended) == pytest.approx((5.1, 10.4))


def test_symptom_that_outlasts_an_outage_is_one_episode() -> None:
    (spell,) = over((-3, 5, 0.1), (5, 7, 0.4), (10, 20, 0.4))
    assert spell.holds == pytest.approx(5.1)
    assert spell.ended is None


def test_samples_from_before_an_outage_do_not_make_a_symptom_after_it() -> None:
    # one very high fresh sample and four from before the outage would have a mean over the threshold
    (spell,) = over((-3, 5, 0.1), (8, 20, 0.9))
    assert (spell.origin, spell.holds) == pytest.approx((8.0, 8.4))


def test_short_gap_leaves_the_window_as_it_is() -> None:
    # a gap of 0.9 s: with two high samples the mean of five is over already
    (spell,) = over((-3, 5, 0.1), (5.8, 20, 0.4))
    assert (spell.origin, spell.holds) == pytest.approx((4.7, 5.9))


def test_samples_that_stop_within_a_symptom_leave_it_open() -> None:
    (spell,) = over((-3, 5, 0.1), (5, 7, 0.4))
    assert spell.ended is None


def test_samples_after_the_end_end_nothing() -> None:
    (spell,) = over((-3, 5, 0.1), (5, 20.05, 0.4), (20.2, 22, 0.1))
    assert spell.ended is None


def test_symptom_of_the_warm_up_that_goes_on_is_cut_off_at_zero() -> None:
    (spell,) = over((-3, 2, 0.4), (2, 20, 0.1))
    assert (spell.origin, spell.holds, spell.ended) == pytest.approx((-3.0, 0.0, 2.3))


def test_symptom_that_ended_in_the_warm_up_does_not_count() -> None:
    assert over((-3, -2, 0.4), (-2, 20, 0.1)) == []


def test_no_samples_are_no_symptom() -> None:
    assert excesses(Samples(), OVER, 0.2, duration_s=20.0) == []


@given(st.lists(st.floats(0, 1), max_size=60), st.floats(0.1, 0.9))
@settings(max_examples=100)
def test_spells_are_where_the_moving_mean_is_over(values: list[float], threshold: float) -> None:
    times = np.arange(len(values), dtype=np.float64) / 10
    spells = excesses(Samples(times, np.array(values)), OVER, threshold, duration_s=20.0)
    for position in range(4, len(values)):
        mean = sum(values[position - 4 : position + 1]) / 5
        inside = any(
            spell.holds <= times[position] and (spell.ended is None or times[position] < spell.ended)
            for spell in spells
        )
        assert inside == (mean > threshold)


# --- failures -----------------------------------------------------------------------------------------


def adaptation(time: float, node: str = "camera", kind: str = "redeploy") -> ExecutedAdaptation:
    return ExecutedAdaptation(time, node, kind, "/manager")


def episodes(
    *adaptations: ExecutedAdaptation,
    camera: Times | None = None,
    fusion: Times | None = None,
    segmentation: Times | None = None,
    entropy: Samples | None = None,
    sharpness: Samples | None = None,
    injections: tuple[Injection, ...] = (),
) -> tuple[Episode, ...]:
    whole = steady(-3, 20)
    timeline = Timeline(
        message_times={
            "/managed_subsystem/rgb_camera": whole if camera is None else camera,
            "/managed_subsystem/sensors_fused": whole if fusion is None else fusion,
            "/managed_subsystem/segmentation": whole if segmentation is None else segmentation,
        },
        samples={
            "segmentation_entropy": entropy or Samples(),
            "camera_sharpness": sharpness or Samples(),
        },
        thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.5},
        injections=injections,
    )
    return failure_episodes(timeline, adaptations)


def outage(start: float, stop: float) -> Times:
    """Return times of a topic that is silent from `start` to `stop`."""
    return np.concatenate([steady(-3, start), steady(stop, 20)])


DISCONNECT = Injection(0.02, "hardware_disconnect", "F1", "/managed_subsystem/camera", redeploy_only=True)
LEAK = Injection(0.02, "memory_leakage", "F2", "sensor_fusion", redeploy_only=True)
SHIFT = Injection(0.03, "image_shift", "F4", "sensor_fusion")
NOISE = Injection(0.04, "depth_degradation", "F4", "depth", internal=False)
HIGH_FROM_ZERO = samples((-3, 0, 0.1), (0, 20, 0.4))


def test_healthy_flight_has_no_episode() -> None:
    assert episodes() == ()


def test_failure_of_an_injected_fault_began_with_the_injection() -> None:
    (episode,) = episodes(adaptation(1.2), camera=outage(0.1, 6), injections=(DISCONNECT,))
    assert (episode.failure, episode.injected, episode.resolved) == ("F1", True, True)
    assert (episode.began, episode.holds, episode.ended) == (0.02, 1.0, 6.0)
    assert episode.t_detect == pytest.approx(0.98)
    assert episode.t_decide == pytest.approx(0.2)
    assert episode.t_react == pytest.approx(1.18)
    assert episode.t_repair == pytest.approx(4.8)


def test_ripple_began_with_its_topics_last_message() -> None:
    ripple = outage(0.3, 6.4)
    camera, fusion = episodes(adaptation(1.2), camera=outage(0, 6), fusion=ripple, injections=(DISCONNECT,))
    assert (camera.failure, fusion.failure) == ("F1", "F2")
    assert (fusion.began, fusion.holds) == pytest.approx((0.2, 1.2))
    assert not fusion.injected
    assert fusion.t_react == pytest.approx(1.0)
    assert fusion.adaptation == camera.adaptation


def test_failure_begins_at_zero_at_the_earliest() -> None:
    (episode,) = episodes(fusion=outage(0, 6))  # its last message was at -0.1
    assert (episode.began, episode.holds) == pytest.approx((0.0, 0.9))


def test_relapse_began_with_its_own_evidence_and_not_with_the_old_injection() -> None:
    twice = np.concatenate([steady(-3, 0.1), steady(6, 10), steady(15, 20)])
    again = replace(DISCONNECT, time=10.0)
    injections = (DISCONNECT, again)
    first, second = episodes(adaptation(1.2), adaptation(11.0), camera=twice, injections=injections)
    assert (first.began, second.began) == pytest.approx((0.02, 9.9))
    assert (first.injected, second.injected) == (True, False)
    assert second.t_react == pytest.approx(1.1)


def test_fault_injected_again_into_a_new_process_is_not_a_new_fault() -> None:
    again = Injection(7.0, "depth_degradation", "F4", "depth", internal=False)
    entropy = samples((-3, 0, 0.1), (0, 3, 0.4), (3, 8, 0.1), (8, 20, 0.4))
    first, second = episodes(entropy=entropy, injections=(NOISE, again))
    assert (first.began, second.began) == pytest.approx((0.04, 7.7))


def test_failure_of_two_faults_began_with_the_first_and_both_are_accounted_for() -> None:
    entropy = samples((-3, 0, 0.1), (0, 3, 0.4), (3, 8, 0.1), (8, 20, 0.4))
    first, second = episodes(entropy=entropy, injections=(SHIFT, NOISE))
    assert first.began == 0.03
    assert not second.injected


def test_failure_hidden_by_an_outage_began_with_its_injection() -> None:
    entropy = samples((-3, 0, 0.1), (6, 12, 0.4), (12, 20, 0.1))
    (episode,) = episodes(adaptation(8, "sensor_fusion"), entropy=entropy, injections=(NOISE,))
    assert (episode.began, episode.holds) == pytest.approx((0.04, 6.4))
    assert episode.t_react == pytest.approx(7.96)
    assert episode.t_decide == pytest.approx(1.6)


def test_fault_that_ended_with_its_process_is_not_to_blame_for_a_later_failure() -> None:
    entropy = samples((-3, 0, 0.1), (6, 12, 0.1), (12, 20, 0.4))
    redeploy = adaptation(1.2, "sensor_fusion")
    (gone,) = episodes(redeploy, entropy=entropy, injections=(SHIFT,))
    assert gone.began == pytest.approx(11.7)
    assert not gone.injected
    (there,) = episodes(redeploy, entropy=entropy, injections=(NOISE,))  # external: it outlasts a redeploy
    assert (there.began, there.injected) == (0.04, True)


def test_redeploy_in_the_silence_itself_leaves_the_blame_with_the_fault() -> None:
    (episode,) = episodes(adaptation(0.5), camera=outage(0.1, 6), injections=(DISCONNECT,))
    assert episode.began == 0.02


def test_fault_that_was_cured_before_it_showed_is_not_to_blame_for_a_later_silence() -> None:
    restart, redeploy = adaptation(0.5, kind="restart"), adaptation(10.05)
    (episode,) = episodes(restart, redeploy, camera=outage(10.1, 13), injections=(DISCONNECT,))
    assert (episode.began, episode.injected) == (10.0, False)


@pytest.mark.parametrize("kind", ["redeploy", "deactivate", "change_topic", "set_parameter"])
def test_ending_a_silence_of_ones_own_making_resolves_nothing(kind: str) -> None:
    first, second = adaptation(5.02, kind=kind), adaptation(6.5, kind="activate")
    found = episodes(
        first,
        second,
        camera=outage(5.1, 7),
        fusion=outage(5.1, 7),
        segmentation=outage(5.2, 7.1),
        injections=(DISCONNECT, SHIFT),
    )
    assert [(episode.failure, episode.subsided) for episode in found] == [
        ("F1", True),
        ("F2", True),
        ("F3", True),
    ]


def test_a_silence_upstream_of_the_fault_is_none_of_its_ripples() -> None:
    camera, fusion, segmentation = episodes(
        adaptation(1.2),
        camera=outage(0.1, 6),
        fusion=outage(0.1, 6),
        segmentation=outage(0.2, 6),
        injections=(LEAK,),
    )
    assert [each.resolved for each in (camera, fusion, segmentation)] == [False, True, True]


def test_an_uncertainty_without_any_fault_that_could_cause_it_is_resolved_by_nobody() -> None:
    entropy = samples((-3, 5, 0.1), (5, 9, 0.4), (9, 20, 0.1))
    blur = Injection(0.02, "autofocus_needed", "F5", "camera")
    for injections, resolved in (((), False), ((DISCONNECT,), False), ((blur,), True)):
        (episode,) = episodes(adaptation(7), entropy=entropy, injections=injections)
        assert episode.resolved == resolved


def test_a_silence_with_a_fault_is_that_faults_whatever_was_adapted_then() -> None:
    (episode,) = episodes(adaptation(0.05), camera=outage(0.1, 6), injections=(DISCONNECT,))
    assert episode.t_react == pytest.approx(0.03)


def test_fault_injected_after_the_symptom_held_is_not_to_blame() -> None:
    late = Injection(5.0, "hardware_disconnect", "F1", "camera")
    (episode,) = episodes(camera=outage(2, 8), injections=(late,))
    assert episode.began == pytest.approx(1.9)
    assert not episode.injected


def test_last_able_adaptation_before_the_end_is_the_one_that_resolved() -> None:
    adaptations = (
        adaptation(1.0, "segmentation"),
        adaptation(1.5, "camera"),
        adaptation(2.0, "segmentation"),  # downstream of the fusion
        adaptation(7.0, "camera"),  # after the end
    )
    (episode,) = episodes(*adaptations, fusion=outage(0, 6), injections=(LEAK,))
    assert episode.adaptation == adaptations[1]


@pytest.mark.parametrize(
    ("failure", "able"),
    [
        ("F1", {"camera"}),
        ("F2", {"camera", "depth", "image_enhancement", "sensor_fusion"}),
        ("F3", {"camera", "depth", "image_enhancement", "sensor_fusion", "segmentation"}),
        ("F4", {"camera", "depth", "image_enhancement", "sensor_fusion", "segmentation"}),
        ("F5", {"camera"}),
    ],
)
def test_only_the_failing_node_and_those_upstream_can_resolve(failure: str, able: set[str]) -> None:
    found = set()
    for node in ("camera", "depth", "image_enhancement", "sensor_fusion", "segmentation"):
        (episode,) = episodes(
            adaptation(2.0, node),
            camera=outage(0, 6) if failure == "F1" else None,
            fusion=outage(0, 6) if failure == "F2" else None,
            segmentation=outage(0, 6) if failure == "F3" else None,
            entropy=samples((-3, 0, 0.1), (0, 6, 0.4), (6, 20, 0.1)) if failure == "F4" else None,
            sharpness=samples((-3, 0, 0.9), (0, 6, 0.1), (6, 20, 0.9)) if failure == "F5" else None,
            injections=(replace(DISCONNECT, failure=failure),),
        )
        assert episode.failure == failure
        if episode.resolved:
            found.add(node)
    assert found == able


def test_command_before_the_failure_began_does_not_resolve_it() -> None:
    (episode,) = episodes(adaptation(1.0), camera=outage(5, 9))
    assert (episode.resolved, episode.subsided) == (False, True)


def test_command_before_the_symptom_holds_can_resolve_with_a_negative_time_to_decide() -> None:
    (episode,) = episodes(adaptation(0.5), camera=outage(0.1, 3), injections=(DISCONNECT,))
    assert episode.t_decide == pytest.approx(-0.5)
    assert episode.t_react == pytest.approx(0.48)
    assert episode.t_react == pytest.approx(episode.t_detect + (episode.t_decide or 0))


def test_failure_that_ends_by_itself_is_not_resolved() -> None:
    (episode,) = episodes(camera=outage(0.1, 6))
    assert (episode.resolved, episode.subsided, episode.ended) == (False, True, 6.0)
    assert episode.t_react is episode.t_decide is episode.t_repair is None


def test_failure_that_holds_to_the_end_is_not_resolved_by_any_adaptation() -> None:
    (episode,) = episodes(adaptation(1.2), adaptation(5.0), entropy=HIGH_FROM_ZERO, injections=(SHIFT,))
    assert (episode.resolved, episode.subsided, episode.ended) == (False, False, None)


def test_repair_after_the_end_does_not_resolve() -> None:
    camera = np.concatenate([steady(-3, 0.1), steady(20.1, 25)])
    (episode,) = episodes(adaptation(18), camera=camera, injections=(DISCONNECT,))
    assert not episode.resolved


def test_episodes_come_in_order_of_their_symptoms() -> None:
    found = episodes(camera=outage(5, 9), segmentation=outage(2, 4), entropy=HIGH_FROM_ZERO)
    assert [episode.failure for episode in found] == ["F4", "F3", "F1"]


def test_topics_that_are_not_there_are_silent() -> None:
    timeline = Timeline(thresholds={"entropy_threshold": 0.2, "sharpness_threshold": 0.5})
    assert [episode.failure for episode in failure_episodes(timeline, ())] == ["F1", "F2", "F3"]


# --- faults that end by themselves ----------------------------------------------------------------------

HEALED = Injection(4.0, "camera_driver_issue", "F1", "camera", ended=6.0)


def test_what_heals_by_itself_is_nobodys_merit() -> None:
    camera = outage(4.0, 6.1)
    (fusion_restart,) = [adaptation(5.2, "sensor_fusion", "restart")]
    untouched = episodes(camera=camera, injections=(HEALED,))
    (meddled, _) = episodes(
        adaptation(5.2, "camera"), fusion_restart, camera=camera, fusion=camera, injections=(HEALED,)
    )
    assert [one.subsided for one in untouched] == [True]
    assert untouched[0].began == 4.0
    assert not meddled.resolved
    assert meddled.subsided


def test_what_was_cured_before_it_would_have_healed_is_resolved() -> None:
    cured = replace(HEALED, ended=5.2, cause="restart camera")
    (episode,) = episodes(adaptation(5.2, "camera", "restart"), camera=outage(4.0, 5.4), injections=(cured,))
    assert episode.t_react == pytest.approx(1.2)


def test_a_fault_that_comes_again_after_its_end_is_a_new_one() -> None:
    again = replace(HEALED, time=12.0, ended=14.0)
    camera = np.concatenate([steady(-3, 4), steady(6.1, 12), steady(14.1, 20)])
    first, second = episodes(camera=camera, injections=(HEALED, again))
    assert (first.began, second.began) == (4.0, 12.0)
    assert (first.injected, second.injected) == (True, True)


def test_a_degradation_that_has_healed_is_not_to_blame_for_a_later_one() -> None:
    passing = replace(NOISE, time=2.0, ended=3.0)
    later = replace(SHIFT, time=12.0)
    entropy = samples((-3, 12, 0.1), (12, 20, 0.4))
    (episode,) = episodes(entropy=entropy, injections=(passing, later))
    assert episode.began == 12.0


@pytest.mark.parametrize(("acted", "resolved"), [(9.0, False), (10.3, True), (10.7, False)])
def test_of_two_degradations_one_heals_and_the_other_is_cured(acted: float, resolved: bool) -> None:
    passing = replace(NOISE, time=2.0, ended=10.0)
    entropy = samples((-3, 2, 0.1), (2, 10.6, 0.4), (10.6, 20, 0.1))
    staying = replace(SHIFT, time=3.0)
    (episode,) = episodes(adaptation(acted, "sensor_fusion"), entropy=entropy, injections=(passing, staying))
    assert episode.ended == pytest.approx(10.8, abs=0.11)
    assert episode.resolved is resolved


def test_an_outage_that_another_one_prolongs_is_resolved_with_the_other() -> None:
    sync = Injection(5.5, "sync_issue", "F2", "sensor_fusion", ended=8.0, cause="restart sensor_fusion")
    (_, fusion) = episodes(
        adaptation(8.0, "sensor_fusion", "restart"),
        camera=outage(4.0, 6.1),
        fusion=outage(4.0, 8.1),
        injections=(HEALED, sync),
    )
    assert fusion.resolved


def test_a_cure_of_another_failure_takes_no_credit_for_what_healed() -> None:
    blur = Injection(
        3.55, "autofocus_needed", "F5", "camera", ended=4.1, cause="set camera.perform_autofocus"
    )
    passing = replace(NOISE, time=2.0, ended=4.0)
    entropy = samples((-3, 2, 0.1), (2, 4.1, 0.4), (4.1, 20, 0.1))
    (episode,) = episodes(
        adaptation(4.07, "camera", "set_parameter"), entropy=entropy, injections=(passing, blur)
    )
    assert not episode.resolved
    assert episode.subsided


def test_an_outage_that_has_healed_is_not_to_blame_once_messages_came() -> None:
    brief = replace(HEALED, time=0.0, ended=0.3)
    later = replace(DISCONNECT, time=0.9)
    camera = np.concatenate([steady(-3, 0), steady(0.4, 0.9), steady(5, 20)])
    (episode,) = episodes(camera=camera, injections=(brief, later))
    assert episode.began == 0.9


def test_a_relapse_is_not_that_of_a_fault_which_came_in_the_symptom_before() -> None:
    dark = replace(NOISE, fault="image_degradation", time=1.0)
    noise = replace(NOISE, time=3.0)
    entropy = samples((-3, 1, 0.1), (1, 5.5, 0.4), (5.5, 11.1, 0.1), (11.1, 20, 0.4))
    first, second = episodes(entropy=entropy, injections=(dark, noise))
    assert first.began == 1.0
    assert second.began == pytest.approx(11.1, abs=0.3)


def test_a_failure_that_is_brought_about_while_a_fault_is_left_alone_is_resolved_once() -> None:
    blur = Injection(0.0, "autofocus_needed", "F5", "camera")
    toggled = samples(
        (-3, 2, 0.1), (2, 4, 0.4), (4, 6, 0.1), (6, 8, 0.4), (8, 10, 0.1), (10, 12, 0.4), (12, 20, 0.1)
    )
    done = [adaptation(time, "sensor_fusion", "set_parameter") for time in (2.0, 4.0, 6.0, 8.0, 10.0, 12.0)]
    found = episodes(*done, entropy=toggled, injections=(blur,))
    assert [one.resolved for one in found] == [True, False, False]
    again = (blur, replace(NOISE, time=5.9))
    assert [one.resolved for one in episodes(*done, entropy=toggled, injections=again)] == [True, True, False]
