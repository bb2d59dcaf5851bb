"""What is said of the faults behind a run's symptoms."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from sunset.metrics import Episode, FaultOutcome, Injection, RunMetrics, Setting, Timeline, score
from sunset.recording.schema import StoredFault
from sunset.recording.story import Cause, causes_of


def timeline(injections: Sequence[Injection], settings: Sequence[Setting] = ()) -> Timeline:
    return Timeline(
        injections=tuple(injections),
        settings=tuple(settings),
        thresholds={"entropy_threshold": 0.1, "sharpness_threshold": 1.0},
    )


def metrics(episodes: Sequence[Episode] = (), outcomes: Sequence[FaultOutcome] = ()) -> RunMetrics:
    nothing = score(timeline([]))
    return replace(nothing, failures=tuple(episodes), outcomes=tuple(outcomes))


def episode(failure: str, *, injected: bool) -> Episode:
    return Episode(failure, 0.0, 1.0, None, injected, None)


def only_cause(fault: str, failure: str, seen: RunMetrics) -> Cause:
    there = replace(seen, outcomes=(FaultOutcome(fault, failure, 0.0, 20.0),))
    (cause,) = causes_of(timeline([Injection(0.0, fault, failure, "some_node")]), there)
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


def test_what_is_said_of_its_cure_is_what_the_figures_count() -> None:
    noise = partial(FaultOutcome, "depth_degradation", "F4")
    healing = partial(Injection, fault="depth_degradation", failure="F4", node="depth", internal=False)
    injections = [
        healing(0.0, ended=3.0),
        healing(5.0, ended=8.0),
        healing(10.0, ended=13.0),
        healing(15.0, ended=None),
    ]
    outcomes = [noise(0.0, 3.0), noise(5.0, 8.0, 6.25), noise(10.0, 13.0, 10.0), noise(15.0, 20.0)]

    (cause,) = causes_of(timeline(injections), metrics(outcomes=outcomes))

    assert cause.cured_by.partition("; ")[2] == (
        "healed by itself at 3.00 s, done at 6.25 s, in place at 10.00 s and not done"
    )


def test_a_cure_while_a_fault_was_away_is_said_to_be_one() -> None:
    away = Injection(0.0, "sync_issue", "F2", "sensor_fusion", ended=3.0, cured_away=4.5)
    outcomes = [FaultOutcome("sync_issue", "F2", 0.0, 3.0, 4.5)]

    (cause,) = causes_of(timeline([away]), metrics(outcomes=outcomes))

    assert cause.cured_by.endswith("; done at 4.50 s (while it was away)")


def test_a_cure_of_a_fault_that_heals_is_told_with_what_it_saved_or_cost() -> None:
    plan = StoredFault("hardware_disconnect", at=5.0, until=7.0)
    fault = Injection(5.0, "hardware_disconnect", "F1", "camera", ended=6.1, cause="redeploy camera")
    outcome = FaultOutcome("hardware_disconnect", "F1", 5.0, 6.1, 6.1)

    def told(ended: float) -> str:
        seen = metrics([Episode("F1", 5.0, 6.0, ended, True, None)], [outcome])
        (cause,) = causes_of(timeline([fault]), seen, [plan])
        return cause.cured_by.partition("; ")[2]

    assert (
        told(10.1) == "done at 6.10 s (it would have healed by itself at 7.00 s, 3.10 s before F1 was over)"
    )
    assert told(6.5) == "done at 6.10 s (it would have healed by itself at 7.00 s)"


def test_a_fault_that_came_when_all_was_over_is_left_out() -> None:
    assert causes_of(timeline([Injection(20.0, "gpu_failure", "F3", "segmentation")]), metrics()) == ()


def test_a_fault_of_another_version_is_left_out() -> None:
    seen = metrics(outcomes=[FaultOutcome("unheard_of", "F9", 0.0, 20.0)])

    assert causes_of(timeline([Injection(0.0, "unheard_of", "F9", "some_node")]), seen) == ()


def test_a_fault_that_did_not_come_is_told_with_the_reason() -> None:
    came = [Injection(1.0, "cuda_out_of_memory", "F3", "segmentation")]
    seen = metrics(outcomes=[FaultOutcome("cuda_out_of_memory", "F3", 1.0, 3.0)])
    follow = partial(StoredFault, "gpu_failure")

    def told(plan: StoredFault) -> str:
        *_, missing = causes_of(timeline(came), seen, [StoredFault("cuda_out_of_memory"), plan])
        assert missing.fault == "gpu_failure"
        assert missing.cured_by == missing.looks_like == ""
        return missing.showed_as

    after = "nothing: it did not come, since"
    assert told(follow(after={"fault": "cuda_out_of_memory", "delay": 6.0})) == (
        f"{after} cuda_out_of_memory was gone by 7.00 s"
    )
    assert told(follow(after={"fault": "cuda_out_of_memory", "delay": 19.0})) == (
        f"{after} the run had ended by 20.00 s"
    )
    assert told(follow(after={"fault": "image_shift", "delay": 1.0})) == f"{after} image_shift did not"
    assert told(follow(at=9.0)) == "nothing: it did not come in the time of the run"
    assert len(causes_of(timeline(came), seen, [StoredFault("cuda_out_of_memory")])) == 1
