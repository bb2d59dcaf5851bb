"""Whole runs, with every figure worked out by hand."""

import json
import math

import numpy as np
import numpy.typing as npt
import pytest

from sunset.metrics import (
    Command,
    Frames,
    Injection,
    Samples,
    Timeline,
    score,
)

Times = npt.NDArray[np.float64]


def steady(start: float, stop: float) -> Times:
    return np.arange(round(start * 10), round(stop * 10)) / 10


def frames(times: Times, iou: float) -> Frames:
    """Return frames of one class of 100 pixels, of which `iou` are right and the others missed."""
    counts = np.zeros((len(times), 28), dtype=np.int64)
    truth = counts.copy()
    truth[:, 3] = 100
    right = counts.copy()
    right[:, 3] = round(100 * iou)
    return Frames(times, np.full(len(times), iou), right, right, truth)


def command(
    time: float, kind: str, node: str, client: str = "/baseline", *, successful: bool = True
) -> Command:
    return Command(time, client, f"/managed_subsystem/{node}", kind, successful=successful)


def use_rgb_only(time: float) -> Command:
    node = "/managed_subsystem/sensor_fusion"
    return Command(time, "/baseline", node, "set_parameters", ("modality",), ("1",))


INJECTIONS = (
    Injection(0.0, "camera_driver_issue", "F1", "camera"),
    Injection(0.0, "depth_degradation", "F4", "depth", internal=False),
    Injection(0.0, "autofocus_needed", "F5", "camera"),
)


def run(segmentation: Times, commands: tuple[Command, ...] = (), **more: object) -> Timeline:
    """Return a run in which all three topics are silent together."""
    values: dict[str, object] = {
        "message_times": {
            "/managed_subsystem/rgb_camera": segmentation,
            "/managed_subsystem/sensors_fused": segmentation,
            "/managed_subsystem/segmentation": segmentation,
        },
        "thresholds": {"entropy_threshold": 0.2, "sharpness_threshold": 0.5},
        "commands": commands,
        "frames": frames(segmentation[segmentation >= 0], 0.5),
        **more,
    }
    return Timeline(**values)  # type: ignore[arg-type]


def test_healthy_run_without_a_manager() -> None:
    metrics = score(run(steady(-3, 20)))
    assert metrics.to_json() == {
        "f_resolved_per_adaptation": None,
        "t_react_s": None,
        "t_detect_s": None,
        "t_decide_s": None,
        "t_repair_s": None,
        "redeploys_unnecessary": 0,
        "t_down_s": 0.0,
        "availability": 1.0,
        "iou": 0.5,
        "iou_all": 0.5,
        "miou": 0.5,
        "episodes": 0,
        "episodes_resolved": 0,
        "episodes_unresolved": 0,
        "episodes_subsided": 0,
        "adaptations": 0,
        "faults_injected": 0,
        "faults_cured": None,
        "faults_masked": None,
        "masked_s": None,
        "uncured_s": None,
        "needless": 0,
        "cost_frames": 0,
        "iou_healthy": 0.5,
        "utility": 0.5,
        "diagnoses": 0,
        "faults_detected": 0,
        "faults_located": 0,
        "faults_identified": 0,
        "faults_top1": 0,
        "t_detected_s": None,
        "t_located_s": None,
        "t_identified_s": None,
        "false_alarms": 0,
        "faultless_s": 20.0,
        "brier": 0.0,
        **dict.fromkeys(("tokens_in", "tokens_out", "price", "think_s")),
        "frames_without_truth": 0,
    }


def test_outage_repaired_by_redeploys_and_a_change_of_modality() -> None:
    # Messages stop with the injection and come back at 6.0. F1 began at 0 (injected), its ripples F2 and
    # F3 with the last message at -0.1, so at 0; all hold from 0.9. The camera is redeployed at 1.2, the
    # fusion at 1.2 and the segmentation at 1.4, all before 6.0: F1's command is that of 1.2, F2's 1.2,
    # F3's 1.4. Entropy is high at 6.0 to 7.4 and low from 7.5: hidden until 6.4, over from 6.4 (five
    # samples of 0.4), back with the fourth low sample at 7.8 (0.4 + 4 · 0.1 = 0.8 < 1.0). It is 0 → 7.0
    # to react. Sharpness is low until the end: unresolved.
    entropy_times = np.concatenate([steady(-3, 0), steady(6, 20)])
    metrics = score(
        run(
            np.concatenate([steady(-3, 0), steady(6, 20)]),
            (
                command(0.0, "set_parameters", "camera", "/scenario_executor"),
                command(1.2, "redeploy", "camera"),
                command(1.2, "shutdown", "camera", "/launcher"),
                command(1.2, "redeploy", "sensor_fusion"),
                command(1.4, "redeploy", "segmentation"),
                command(1.6, "redeploy", "segmentation", successful=False),
                use_rgb_only(7.0),
            ),
            injections=INJECTIONS,
            samples={
                "segmentation_entropy": Samples(
                    entropy_times, np.where((entropy_times >= 6) & (entropy_times < 7.45), 0.4, 0.1)
                ),
                "camera_sharpness": Samples(entropy_times, np.where(entropy_times < 0, 0.9, 0.3)),
            },
        )
    )
    assert [(episode.failure, episode.resolved) for episode in metrics.failures] == [
        ("F1", True),
        ("F2", True),
        ("F3", True),
        ("F4", True),
        ("F5", False),
    ]
    assert (metrics.episodes, metrics.episodes_resolved, metrics.episodes_unresolved) == (5, 4, 1)
    assert metrics.episodes_subsided == 0
    assert metrics.adaptations == 4
    assert metrics.f_resolved_per_adaptation == 1.0
    assert metrics.t_react_s == pytest.approx((1.2 + 1.2 + 1.4 + 7.0) / 4)
    assert metrics.t_detect_s == pytest.approx((0.9 * 3 + 6.4) / 4)
    assert metrics.t_decide_s == pytest.approx((0.3 + 0.3 + 0.5 + 0.6) / 4)
    assert metrics.t_repair_s == pytest.approx((4.8 + 4.8 + 4.6 + 0.8) / 4)
    assert metrics.redeploys_unnecessary == 3  # a restart would have cured the driver
    assert metrics.t_down_s == pytest.approx(6.0)
    assert metrics.availability == pytest.approx(0.7)
    assert metrics.iou == pytest.approx(0.5)
    assert metrics.iou_all == pytest.approx(0.5 * 140 / 200)
    assert metrics.miou == pytest.approx(0.5)


def test_reaction_is_detection_and_decision() -> None:
    metrics = score(
        run(
            np.concatenate([steady(-3, 2), steady(6, 20)]),
            (command(3.7, "redeploy", "camera"),),
            injections=(Injection(2.0, "camera_driver_issue", "F1", "camera"),),
        )
    )
    assert metrics.t_react_s is not None
    assert metrics.t_detect_s is not None
    assert metrics.t_decide_s is not None
    assert metrics.t_react_s == pytest.approx(metrics.t_detect_s + metrics.t_decide_s)


def test_one_adaptation_that_resolves_three_failures_scores_three() -> None:
    metrics = score(
        run(
            np.concatenate([steady(-3, 0), steady(5, 20)]),
            (command(1.2, "redeploy", "camera"),),
            injections=INJECTIONS,
        )
    )
    assert metrics.f_resolved_per_adaptation == 3.0


def test_adaptations_that_resolve_nothing_score_zero_and_not_none() -> None:
    metrics = score(run(steady(-3, 0), (command(1.2, "redeploy", "camera"),)))
    assert metrics.f_resolved_per_adaptation == 0.0
    assert metrics.t_react_s is None


def test_never_repairing_has_the_greatest_downtime() -> None:
    never = score(run(steady(-3, 0), injections=INJECTIONS))
    late = score(run(np.concatenate([steady(-3, 0), steady(19, 20)]), (command(15, "redeploy", "camera"),)))
    assert never.t_down_s == 20.0
    assert never.availability == 0.0
    assert late.t_down_s == pytest.approx(19.0)
    assert never.iou_all == 0.0
    assert (never.iou, never.miou) == (None, None)
    assert never.episodes_unresolved == 3


def test_restart_is_one_adaptation() -> None:
    metrics = score(
        run(
            np.concatenate([steady(-3, 0), steady(1.5, 20)]),
            (command(1.2, "deactivate", "camera"), command(1.25, "activate", "camera")),
            injections=INJECTIONS,
        )
    )
    assert metrics.adaptations == 1
    assert metrics.f_resolved_per_adaptation == 3.0
    assert metrics.t_react_s == pytest.approx(1.2)
    assert metrics.redeploys_unnecessary == 0


def test_frames_outside_the_experiment_do_not_count() -> None:
    times = np.array([-0.1, 0.0, 0.1, 20.0])
    counts = np.zeros((4, 28), dtype=np.int64)
    counts[:, 0] = [9, 1, 3, 9]
    total = np.zeros((4, 28), dtype=np.int64)
    total[:, 0] = 10
    observed = Frames(times, np.array([0.9, 0.1, 0.3, 0.9]), counts, counts, total)
    metrics = score(run(steady(-3, 20), frames=observed, expected_frames=4))
    assert metrics.iou == pytest.approx(0.2)
    assert metrics.iou_all == pytest.approx(0.1)  # two of four never came
    assert metrics.miou == pytest.approx(4 / 20)


def test_more_frames_than_expected_do_not_raise_the_iou_over_all() -> None:
    metrics = score(run(steady(-3, 20), expected_frames=10))
    assert metrics.iou_all == 0.5


def test_figures_are_numbers_that_json_knows() -> None:
    for timeline in (run(steady(-3, 20)), run(steady(-3, 0)), run(np.empty(0))):
        figures = json.loads(json.dumps(score(timeline).to_json(), allow_nan=False))
        assert all(value is None or math.isfinite(value) for value in figures.values())


def test_flickering_entropy_does_not_make_dozens_of_episodes() -> None:
    # every third frame is high; the mean of five has one or two high ones of 0.3: 0.14 or 0.18 < 0.2
    times = steady(-3, 20)
    flicker = Samples(times, np.where(np.arange(len(times)) % 3 == 0, 0.3, 0.1))
    assert score(run(times, samples={"segmentation_entropy": flicker})).episodes == 0
