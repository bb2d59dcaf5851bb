"""The example that looks for causes: what it repairs, in which order, and what it undoes."""

from typing import TYPE_CHECKING

import pytest

from sunset.managing import Reactive, Symptoms
from sunset.system.vocabulary import frequency_entry

if TYPE_CHECKING:
    from tests.conftest import World

TOPICS = ("rgb_camera", "depth_camera", "sensors_fused", "segmentation")
THRESHOLD = 0.3


class Recorded(Reactive):
    """Writes down what it would do; it is called every 0.2 s of a clock of its own."""

    def on_start(self) -> None:
        super().on_start()
        self.calls = 0
        self.done: list[str] = []

    @property
    def now_s(self) -> float:
        return 0.2 * self.calls

    def redeploy(self, node: str) -> None:  # type: ignore[override]
        self.done.append(f"redeploy {node}")

    def restart(self, node: str) -> None:  # type: ignore[override]
        self.done.append(f"restart {node}")

    def activate(self, node: str) -> None:  # type: ignore[override]
        self.done.append(f"activate {node}")

    def deactivate(self, node: str) -> None:  # type: ignore[override]
        self.done.append(f"deactivate {node}")

    def set_parameter(self, node: str, name: str, value: object) -> None:  # type: ignore[override]
        self.done.append(f"{node}.{name} = {value}")


@pytest.fixture
def reactive(world: "World") -> Recorded:
    return world.start(Recorded)


def watch(
    reactive: Recorded,
    calls: int,
    *,
    silent: tuple[str, ...] = (),
    entropy: float = 0.1,
    blurred: bool = False,
    enhancement: str = "inactive",
) -> list[str]:
    """Let it see the same for so many calls; return what it did."""
    values: dict[str, bool | int | float | str] = {
        frequency_entry(topic): 0.0 if topic in silent else 10.0 for topic in TOPICS
    }
    values |= {
        "segmentation_entropy": entropy,
        "camera_autofocus_needed": blurred,
        "image_enhancement_lc_state": enhancement,
    }
    reactive.done.clear()
    for _ in range(calls):
        reactive.calls += 1
        reactive.adapt(Symptoms(values, entropy_threshold=THRESHOLD))
    return reactive.done.copy()


def test_a_healthy_system_is_left_alone(reactive: Recorded) -> None:
    assert watch(reactive, 100) == []


def test_only_the_node_furthest_upstream_is_restarted_then_redeployed(reactive: Recorded) -> None:
    silent = ("rgb_camera", "sensors_fused", "segmentation")
    assert watch(reactive, 1, silent=silent) == ["restart camera"]
    assert watch(reactive, 2, silent=silent) == []
    assert watch(reactive, 1, silent=silent) == ["redeploy camera"]
    assert (
        watch(reactive, 21, silent=silent) == []
    )  # 4 s until the camera is back, and a frame through the pipeline
    assert watch(reactive, 1, silent=silent) == ["restart camera"]


def test_a_later_outage_of_the_same_node_is_answered_with_a_restart_again(reactive: Recorded) -> None:
    assert watch(reactive, 1, silent=("segmentation",)) == ["restart segmentation"]
    assert watch(reactive, 10) == []
    assert watch(reactive, 1, silent=("segmentation",)) == ["restart segmentation"]


def test_a_blurred_camera_focuses_unless_it_is_silent(reactive: Recorded) -> None:
    assert "camera.perform_autofocus = True" not in watch(reactive, 3, blurred=True, silent=("rgb_camera",))
    assert watch(reactive, 5, blurred=True) == ["camera.perform_autofocus = True"]


def test_a_cure_that_does_not_lower_the_entropy_is_undone_before_the_next(reactive: Recorded) -> None:
    assert watch(reactive, 4, entropy=0.5) == ["sensor_fusion.do_recalibration = True"]
    enhance = ["activate image_enhancement", "sensor_fusion.topic_camera_input = rgb_enhanced"]
    assert watch(reactive, 4, entropy=0.5) == enhance
    assert watch(reactive, 4, entropy=0.6, enhancement="active") == [
        "sensor_fusion.topic_camera_input = rgb_camera",
        "deactivate image_enhancement",
        "sensor_fusion.modality = 1",
    ]
    assert watch(reactive, 4, entropy=0.1) == []
    assert watch(reactive, 1, entropy=0.5) == ["sensor_fusion.do_recalibration = True"]


def test_a_cure_that_lowers_the_entropy_is_kept(reactive: Recorded) -> None:
    watch(reactive, 8, entropy=0.5)
    assert watch(reactive, 4, entropy=0.4, enhancement="active") == ["sensor_fusion.modality = 1"]


def test_an_enhancement_that_is_on_is_switched_off(reactive: Recorded) -> None:
    watch(reactive, 4, entropy=0.5, enhancement="active")
    assert watch(reactive, 4, entropy=0.5, enhancement="active") == [
        "sensor_fusion.topic_camera_input = rgb_camera",
        "deactivate image_enhancement",
    ]


def test_no_cure_is_tried_by_the_entropy_of_old_frames(reactive: Recorded) -> None:
    watch(reactive, 3, silent=("segmentation",), entropy=0.5)
    assert watch(reactive, 3, entropy=0.5) == []
    assert watch(reactive, 1, entropy=0.5) == ["sensor_fusion.do_recalibration = True"]
