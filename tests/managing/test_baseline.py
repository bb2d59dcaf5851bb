"""The paper's baseline: which symptoms it answers, with what, and how often."""

from typing import TYPE_CHECKING

import pytest

from sunset.managing import Baseline, Symptoms

if TYPE_CHECKING:
    from tests.conftest import World

TOPICS = {
    "rgb_camera": "camera",
    "depth_camera": "depth",
    "sensors_fused": "sensor_fusion",
    "segmentation": "segmentation",
}
KEYS = {topic: f"managed_subsystem_{topic}_freq" for topic in TOPICS}


class Recorded(Baseline):
    """Writes down what it would do."""

    def on_start(self) -> None:
        super().on_start()
        self.done: list[str] = []

    def redeploy(self, node: str) -> None:  # type: ignore[override]
        self.done.append(f"redeploy {node}")

    def set_parameter(self, node: str, name: str, value: object) -> None:  # type: ignore[override]
        self.done.append(f"{node}.{name} = {value}")

    def restart(self, node: str) -> None:  # type: ignore[override]
        raise AssertionError(node)


@pytest.fixture
def baseline(world: "World") -> Recorded:
    return world.start(Recorded)


def tick(baseline: Recorded, *, silent: tuple[str, ...] = (), entropy: float = 0.05) -> list[str]:
    """Let it decide once; return what it did."""
    values: dict[str, bool | int | float | str] = {
        key: 0.0 if topic in silent else 10.0 for topic, key in KEYS.items()
    }
    baseline.done.clear()
    baseline.adapt(Symptoms(values | {"segmentation_entropy": entropy}, entropy_threshold=0.1))
    return baseline.done.copy()


def test_a_healthy_system_is_left_alone(baseline: Recorded) -> None:
    assert tick(baseline) == []


@pytest.mark.parametrize(("topic", "node"), TOPICS.items())
def test_the_node_of_a_silent_topic_is_redeployed_once_an_episode(
    baseline: Recorded, topic: str, node: str
) -> None:
    assert tick(baseline, silent=(topic,)) == [f"redeploy {node}"]
    assert tick(baseline, silent=(topic,)) == []
    assert tick(baseline) == []
    assert tick(baseline, silent=(topic,)) == [f"redeploy {node}"]


def test_ripples_are_answered_like_causes(baseline: Recorded) -> None:
    silent = ("rgb_camera", "sensors_fused", "segmentation")
    assert tick(baseline, silent=silent) == [
        "redeploy camera",
        "redeploy sensor_fusion",
        "redeploy segmentation",
    ]


def test_the_fusion_is_recalibrated_once_while_the_entropy_is_high(baseline: Recorded) -> None:
    assert tick(baseline, entropy=0.1) == []
    assert tick(baseline, entropy=0.11) == ["sensor_fusion.do_recalibration = True"]
    assert tick(baseline, entropy=0.5) == []
    assert tick(baseline, entropy=0.05) == []
    assert tick(baseline, entropy=0.5) == ["sensor_fusion.do_recalibration = True"]


def test_a_topic_that_was_never_heard_is_no_outage(baseline: Recorded) -> None:
    baseline.adapt(Symptoms({}))
    assert baseline.done == []


def test_it_looks_at_nothing_else(baseline: Recorded) -> None:
    baseline.adapt(
        Symptoms(
            {
                "camera_autofocus_needed": True,
                "camera_sharpness": 0.0,
                "managed_subsystem_rgb_enhanced_freq": 0.0,
                "camera_lc_state": "unknown",
            }
        )
    )
    assert baseline.done == []
