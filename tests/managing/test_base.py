"""Writing a managing system: what it is shown, when it is called, and what its methods do."""

import math
from typing import TYPE_CHECKING

import pytest

from sunset.harness.monitor import Monitor
from sunset.managing import ManagingSystem, NoAdaptation, Symptoms
from sunset.nodes import Camera, Fusion, ImageEnhancement
from sunset.system_interfaces.msg import SetBlackboardGroup
from sunset.system_interfaces.srv import Redeploy
from sunset_ros import CallbackError, Future, Node
from sunset_ros.exceptions import InvalidParameterValueException
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter as ParameterMessage
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterType, ParameterValue
from sunset_ros.interfaces.sensor_msgs.msg import Image

if TYPE_CHECKING:
    from tests.conftest import World


class Watcher(ManagingSystem):
    """Keeps what it is shown."""

    def on_start(self) -> None:
        self.seen: list[tuple[float, Symptoms]] = []

    def adapt(self, symptoms: Symptoms) -> None:
        self.seen.append((self.get_clock().now().nanoseconds / 1e9, symptoms))


class Launcher(Node):
    """Remembers what it is asked for."""

    def __init__(self, **options: object) -> None:
        super().__init__("launcher", **options)  # type: ignore[arg-type]
        self.asked: list[str] = []
        self.create_service(Redeploy, "~/redeploy", self._redeploy)

    def _redeploy(self, request: Redeploy.Request, response: Redeploy.Response) -> Redeploy.Response:
        self.asked.append(request.node)
        response.success = request.node != "toaster"
        response.message = "" if response.success else "there is no toaster"
        return response


@pytest.fixture
def watcher(world: "World") -> Watcher:
    return world.start(Watcher)


UP = {"managed_subsystem_segmentation_freq": 10.0}


def show(world: "World", **numbers: float) -> None:
    """Publish entries of the blackboard of a system that is up, if nothing else is said."""
    publish(world, **(UP | numbers))


def publish(world: "World", **numbers: float) -> None:
    group = [
        ParameterMessage(
            name=name, value=ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
        )
        for name, value in numbers.items()
    ]
    world.publish("/blackboard_group", SetBlackboardGroup(bb_params=group))


def outcome(world: "World", future: Future[bool]) -> bool | None:
    world.run(0.05)
    return future.result()


def warnings(world: "World") -> list[str]:
    return [message.msg for message in world.messages["/rosout"]]


# What it sees


def test_it_is_called_every_period_once_the_system_is_up(world: "World", watcher: Watcher) -> None:
    publish(world, managed_subsystem_rgb_camera_freq=10.0)
    world.run(1.0)
    assert watcher.seen == []
    show(world, segmentation_entropy=0.1)
    world.run(2.0)
    times = [time for time, _ in watcher.seen]
    assert times == pytest.approx([1.2 + 0.2 * tick for tick in range(10)])


def test_it_is_called_on_when_the_system_breaks(world: "World", watcher: Watcher) -> None:
    show(world)
    world.run(0.5)
    show(world, managed_subsystem_segmentation_freq=0.0)
    world.run(1.0)
    assert len(watcher.seen) == 7
    assert watcher.seen[-1][1].stopped("segmentation")


def test_the_period_is_a_parameter(world: "World") -> None:
    watcher = world.start(Watcher, parameters={"period": 0.5})
    show(world, segmentation_entropy=0.1)
    world.run(2.05)
    assert len(watcher.seen) == 4


def test_symptoms_are_the_latest_and_those_not_mentioned_stay(world: "World", watcher: Watcher) -> None:
    show(world, segmentation_entropy=0.1, camera_sharpness=2.0)
    world.run(0.1)
    show(world, segmentation_entropy=0.3)
    world.run(0.15)
    (_, symptoms) = watcher.seen[-1]
    assert (symptoms.entropy, symptoms.sharpness) == (0.3, 2.0)


def test_a_topic_stops_only_after_it_was_heard(world: "World", watcher: Watcher) -> None:
    show(world)
    world.run(0.2)
    for frequency in (9.0, 0.0):
        show(world, managed_subsystem_rgb_camera_freq=frequency)
        world.run(0.2)
    assert [symptoms.stopped("rgb_camera") for _, symptoms in watcher.seen] == [False, False, True]


def test_it_understands_the_monitor(world: "World", watcher: Watcher) -> None:
    world.start(Monitor)
    world.start(Camera)
    world.publish(
        "/managed_subsystem/segmentation", Image(height=1, width=1, encoding="8UC1", step=1, data=[0])
    )
    world.run(2.0)
    (_, symptoms) = watcher.seen[-1]
    assert math.isnan(symptoms.frequency("rgb_camera"))
    assert (symptoms.state("camera"), symptoms.heartbeat("camera")) == ("inactive", 10.0)
    assert math.isnan(symptoms.entropy)


def test_the_threshold_is_a_parameter(world: "World") -> None:
    watcher = world.start(Watcher, parameters={"entropy_threshold": 0.25})
    assert watcher.entropy_threshold == 0.25
    for entropy in (0.25, 0.26):
        show(world, segmentation_entropy=entropy)
        world.run(0.2)
    assert [symptoms.unsure for _, symptoms in watcher.seen] == [False, True]


# What it can do


def test_a_parameter_is_set_and_the_node_confirms(world: "World", watcher: Watcher) -> None:
    fusion = world.start(Fusion)
    assert outcome(world, watcher.set_parameter("sensor_fusion", "modality", 1)) is True
    assert fusion.modality == 1
    full = "/managed_subsystem/sensor_fusion"
    assert outcome(world, watcher.set_parameter(full, "modality", 2)) is True
    assert fusion.modality == 2


def test_a_refusal_is_an_answer_and_is_logged(world: "World", watcher: Watcher) -> None:
    world.start(Fusion)
    assert outcome(world, watcher.set_parameter("sensor_fusion", "modality", 9)) is False
    assert any("sensor_fusion refused modality = 9" in text for text in warnings(world))


@pytest.mark.parametrize(
    ("node", "said"), [("camra", "did you mean 'camera'"), ("camera", "so the request is lost.")]
)
def test_a_request_that_no_node_gets_is_logged(
    world: "World", watcher: Watcher, node: str, said: str
) -> None:
    watcher.activate(node)
    assert any(said in text for text in warnings(world))


def test_a_refusal_does_not_repeat_all_of_what_it_refuses(world: "World", watcher: Watcher) -> None:
    world.start(Fusion)

    for name in ("modality", "topic_camera_input"):
        assert outcome(world, watcher.set_parameter("sensor_fusion", name, "no topic " * 100_000)) is False

    told = warnings(world)
    assert len(told) == 2
    assert max(map(len, told)) < 4000


def test_a_topic_is_changed(world: "World", watcher: Watcher) -> None:
    fusion = world.start(Fusion)
    change = watcher.change_topic("sensor_fusion", "topic_camera_input", "rgb_enhanced")
    assert outcome(world, change) is True
    assert fusion.topic_camera_input == "rgb_enhanced"


def test_a_node_is_activated_deactivated_and_restarted(world: "World", watcher: Watcher) -> None:
    world.start(ImageEnhancement)
    world.run(0.1)
    assert outcome(world, watcher.activate("image_enhancement")) is True
    assert outcome(world, watcher.activate("image_enhancement")) is False
    assert outcome(world, watcher.restart("image_enhancement")) is True
    assert outcome(world, watcher.deactivate("image_enhancement")) is True
    assert outcome(world, watcher.deactivate("image_enhancement")) is False


def test_a_restart_activates_also_what_was_not_active(world: "World", watcher: Watcher) -> None:
    world.start(ImageEnhancement)
    world.run(0.1)
    assert outcome(world, watcher.restart("image_enhancement")) is False
    world.run(0.2)
    assert world.messages["/diagnostics"][-1].status[0].message == "active"


def test_a_redeploy_is_asked_of_the_launcher(world: "World", watcher: Watcher) -> None:
    launcher = world.start(Launcher)
    assert outcome(world, watcher.redeploy("camera")) is True
    assert outcome(world, watcher.redeploy("/managed_subsystem/depth")) is True
    assert outcome(world, watcher.redeploy("toaster")) is False
    assert launcher.asked == ["camera", "depth", "toaster"]
    assert any("toaster is not redeployed: there is no toaster" in text for text in warnings(world))


def test_what_is_not_answered_stays_open(world: "World", watcher: Watcher) -> None:
    assert outcome(world, watcher.activate("camera")) is None


def test_adapt_may_be_a_coroutine_that_waits(world: "World") -> None:
    class Patient(ManagingSystem):
        def on_start(self) -> None:
            self.answers: list[bool | None] = []

        async def adapt(self, symptoms: Symptoms) -> None:  # type: ignore[override]
            if symptoms.entropy > 0.5 and not self.answers:
                self.answers.append(await self.activate("image_enhancement"))
                self.answers.append(await self.set_parameter("sensor_fusion", "modality", 7))

    manager = world.start(Patient)
    world.start(ImageEnhancement)
    world.start(Fusion)
    show(world, segmentation_entropy=0.9)
    world.run(0.3)
    assert manager.answers == [True, False]


@pytest.mark.parametrize("period", [0.0, -1.0, float("nan")])
def test_a_period_that_is_none_is_refused(world: "World", period: float) -> None:
    with pytest.raises(InvalidParameterValueException, match="period"):
        world.start(Watcher, parameters={"period": period})


# Errors


def test_an_exception_in_adapt_surfaces(world: "World") -> None:
    class Broken(ManagingSystem):
        def adapt(self, symptoms: Symptoms) -> None:
            raise ZeroDivisionError(f"with {len(symptoms)} symptoms")

    world.start(Broken)
    show(world, segmentation_entropy=0.1)
    with pytest.raises(CallbackError, match=r"/managing_system.*with 2 symptoms"):
        world.run(1.0)


def test_the_idle_one_sends_nothing(world: "World") -> None:
    world.start(NoAdaptation)
    show(world, segmentation_entropy=0.9, managed_subsystem_rgb_camera_freq=0.0)
    world.run(2.0)
    clients = [info for info in world.sim.endpoints() if info.node_name == "managing_system"]
    assert not [info for info in clients if info.kind.value == "client"]
