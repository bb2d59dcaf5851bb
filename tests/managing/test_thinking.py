"""Thinking takes time: when what was decided is done, and when a managing system is asked again."""

import math
from typing import TYPE_CHECKING

import pytest
from tests.managing.test_base import Launcher, show

from sunset.managing import ManagingSystem, Symptoms
from sunset.nodes import Camera
from sunset.system_interfaces.msg import Diagnosis
from sunset_ros import CallbackError, Future

if TYPE_CHECKING:
    from tests.conftest import World


class Thinker(ManagingSystem):
    """Asks for a redeploy at its first decision, after some thought, and keeps when it was asked."""

    seconds = 0.5

    def on_start(self) -> None:
        self.times: list[float] = []
        self.outcome: Future[bool] | None = None

    def adapt(self, symptoms: Symptoms) -> None:
        self.times.append(self.get_clock().now().nanoseconds / 1e9)
        self.think(self.seconds)
        if self.outcome is None:
            self.outcome = self.redeploy("camera")


class Plain(ManagingSystem):
    """Asks for two redeploys at its first and its third decision."""

    def on_start(self) -> None:
        self.times: list[float] = []

    def adapt(self, symptoms: Symptoms) -> None:
        self.times.append(self.get_clock().now().nanoseconds / 1e9)
        if len(self.times) in {1, 3}:
            self.redeploy("camera")
            self.redeploy("depth")


class Restarter(ManagingSystem):
    """Restarts the camera at its first decision."""

    def on_start(self) -> None:
        self.outcome: Future[bool] | None = None

    def adapt(self, symptoms: Symptoms) -> None:
        self.outcome = self.outcome or self.restart("camera")


class Rash(ManagingSystem):
    """Thinks after it has acted."""

    def adapt(self, symptoms: Symptoms) -> None:
        self.redeploy("camera")
        self.think(1.0)


class RashCoroutine(ManagingSystem):
    """The same in a coroutine."""

    async def adapt(self, symptoms: Symptoms) -> None:  # type: ignore[override]  # it may be one
        self.redeploy("camera")
        self.think(1.0)


class Repeating(ManagingSystem):
    """Thinks, acts, waits for the outcome, and thinks again."""

    def on_start(self) -> None:
        self.times: list[float] = []

    async def adapt(self, symptoms: Symptoms) -> None:  # type: ignore[override]  # it may be one
        if not self.times:
            for _ in range(2):
                self.times.append(self.get_clock().now().nanoseconds / 1e9)
                self.think(0.3)
                await self.redeploy("camera")


class Patient(ManagingSystem):
    """Waits for the outcome of its decision, which it has thought about."""

    def on_start(self) -> None:
        self.seen: list[tuple[float, bool]] = []

    async def adapt(self, symptoms: Symptoms) -> None:  # type: ignore[override]  # it may be one
        if not self.seen:
            self.think(0.3)
            outcome = await self.redeploy("camera")
            self.seen.append((self.get_clock().now().nanoseconds / 1e9, outcome))


def test_what_is_decided_is_done_when_it_has_thought(world: "World") -> None:
    launcher = world.start(Launcher)
    thinker = world.start(Thinker)
    show(world)
    world.run(0.65)
    assert thinker.times == pytest.approx([0.2])
    assert launcher.asked == []
    world.run(0.2)
    assert launcher.asked == ["camera"]
    assert thinker.outcome is not None
    assert thinker.outcome.result() is True
    # it is asked again at the next of its ticks, every 0.2 s
    assert thinker.times == pytest.approx([0.2, 0.8])


def test_a_fixed_time_is_charged_for_each_decision_that_adapts_once(world: "World") -> None:
    launcher = world.start(Launcher)
    plain = world.start(Plain, parameters={"thinking": 0.3})
    show(world)
    world.run(0.45)
    assert launcher.asked == []
    world.run(0.1)
    assert launcher.asked == ["camera", "depth"]
    world.run(0.7)
    # the second decision does not adapt and takes no time, the third one takes until 1.1
    assert plain.times == pytest.approx([0.2, 0.6, 0.8, 1.2])
    assert launcher.asked == ["camera", "depth"] * 2


def test_a_restart_is_one_decision(world: "World") -> None:
    world.start(Camera, parameters={"lifecycle_activation_delay": 0.0})
    world.run(0.5)
    restarter = world.start(Restarter, parameters={"thinking": 0.3})
    show(world)
    world.run(0.55)
    assert restarter.outcome is not None
    assert restarter.outcome.result() is True


def test_what_is_awaited_comes_when_it_was_thought_about(world: "World") -> None:
    world.start(Launcher)
    patient = world.start(Patient)
    show(world)
    world.run(1.0)
    ((time, accepted),) = patient.seen
    assert time == pytest.approx(0.5, abs=0.01)
    assert accepted


@pytest.mark.parametrize("rash", [Rash, RashCoroutine])
def test_who_thinks_after_acting_is_told(world: "World", rash: type[ManagingSystem]) -> None:
    world.start(Launcher)
    world.start(rash)
    show(world)
    with pytest.raises(CallbackError, match="think must be called before the adaptations that it delays"):
        world.run(1.0)


def test_a_coroutine_that_has_waited_for_the_outcome_may_think_again(world: "World") -> None:
    world.start(Launcher)
    repeating = world.start(Repeating)
    show(world)
    world.run(1.0)
    assert repeating.times == pytest.approx([0.2, 0.5], abs=0.01)


@pytest.mark.parametrize("seconds", [-0.1, math.nan, math.inf, 3601.0, True, "1"])
def test_no_such_time_can_be_thought(world: "World", seconds: object) -> None:
    thinker = world.start(Thinker)
    with pytest.raises(ValueError, match="time to think must be"):
        thinker.think(seconds)  # type: ignore[arg-type]


def test_adaptations_are_refused_where_the_task_is_to_diagnose(world: "World") -> None:
    camera = world.start(Camera, parameters={"lifecycle_activation_delay": 0.0})
    world.run(0.5)
    restarter = world.start(Restarter, parameters={"task": "diagnose"})
    show(world)
    world.run(0.55)
    assert restarter.greeting["task"] == "diagnose"
    assert restarter.outcome is not None
    assert restarter.outcome.result() is False
    redeployed = restarter.redeploy(camera.get_name())
    assert (redeployed.done(), redeployed.result()) == (True, False)


def test_a_diagnosis_is_published(world: "World") -> None:
    thinker = world.start(Plain)
    thinker.diagnose({"gpu_failure": 0.9, "sync_issue": 0})
    world.run(0.1)
    (message,) = world.messages["/managing_system/diagnosis"]
    assert isinstance(message, Diagnosis)
    assert dict(zip(message.faults, message.probabilities, strict=True)) == {
        "gpu_failure": 0.9,
        "sync_issue": 0.0,
    }


@pytest.mark.parametrize(
    ("probabilities", "said"),
    [
        ({"gpu_failure": 1.5}, r"probability of gpu_failure must be a number from 0 to 1, got 1\.5"),
        ({"gpu_failure": -0.1}, r"must be a number from 0 to 1, got -0\.1"),
        ({"gpu_failure": math.nan}, "must be a number from 0 to 1, got nan"),
        ({"gpu_failure": True}, "must be a number from 0 to 1, got True"),
        ({"gpu_failure": "0.9"}, "must be a number from 0 to 1, got '0.9'"),
        ({3: 0.9}, "name of a fault in a diagnosis must be a text, got 3"),
        (["gpu_failure"], "must map faults to probabilities"),
    ],
)
def test_no_such_diagnosis_can_be_published(world: "World", probabilities: object, said: str) -> None:
    thinker = world.start(Plain)
    with pytest.raises(ValueError, match=said):
        thinker.diagnose(probabilities)  # type: ignore[arg-type]
    world.run(0.1)
    assert "/managing_system/diagnosis" not in world.messages
