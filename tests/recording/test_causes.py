"""What is said of the faults behind a run's symptoms."""

from collections.abc import Sequence
from dataclasses import replace

from sunset.metrics import Episode, ExecutedAdaptation, Injection, RunMetrics, Timeline, score
from sunset.recording.causes import Cause, causes_of


def metrics(episodes: Sequence[Episode] = (), done: Sequence[ExecutedAdaptation] = ()) -> RunMetrics:
    nothing = score(Timeline(thresholds={"entropy_threshold": 0.1, "sharpness_threshold": 1.0}))
    return replace(nothing, failures=tuple(episodes), executed=tuple(done))


def episode(failure: str, *, injected: bool) -> Episode:
    return Episode(failure, 0.0, 1.0, None, injected, None)


def only_cause(fault: str, failure: str, seen: RunMetrics) -> Cause:
    (cause,) = causes_of([Injection(0.0, fault, failure, "some_node")], seen)
    return cause


def test_only_failures_downstream_of_the_fault_are_its_ripples() -> None:
    episodes = [episode(failure, injected=failure == "F2") for failure in ("F1", "F2", "F3", "F4")]

    cause = only_cause("sync_issue", "F2", metrics(episodes))

    assert cause.showed_as == "F2 (the sensor fusion sends no images); F3 by ripple, for lack of input"
    assert cause.looks_like == "memory_leakage"


def test_a_fault_that_was_gone_before_it_showed_is_said_to_have_shown_as_nothing() -> None:
    cause = only_cause("autofocus_needed", "F5", metrics([episode("F4", injected=False)]))

    assert cause.showed_as == "nothing; it can show as F5 (the camera's images are blurred)"
    assert cause.looks_like == ""


def test_a_cure_of_two_steps_is_done_with_the_later_one_and_only_from_the_injection_on() -> None:
    activate = ExecutedAdaptation(-1.0, "image_enhancement", "activate")
    change = ExecutedAdaptation(
        4.0, "sensor_fusion", "change_topic", "", ("modality", "topic_camera_input"), ("0", "rgb_enhanced")
    )

    def cured_by(*done: ExecutedAdaptation) -> str:
        return only_cause("image_degradation", "F4", metrics(done=done)).cured_by.rpartition("; ")[2]

    assert cured_by(activate, change) == "not done"
    assert cured_by(replace(activate, time=5.0), change) == "done at 5.00 s"
    assert cured_by(replace(activate, time=2.0), change) == "done at 4.00 s"


def test_a_fault_of_another_version_is_left_out() -> None:
    assert causes_of([Injection(0.0, "unheard_of", "F9", "some_node")], metrics()) == ()
