"""Experiments that are advanced from outside, with a managing system in the same process."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest

from sunset.errors import SunsetError
from sunset.experiments import RunSpec, Settings, Timing, World, prepare, run
from sunset.experiments.observer import Observer
from sunset.managing import ManagingSystem, Reactive, Symptoms, request
from sunset.recording import RecordWriter
from sunset.scenarios import load_scenario
from sunset.system import Adaptation, AdaptationKind, redeploy, restart, system_with
from sunset_ros.task import Future

SHORT = Timing(duration_s=5.0, warm_up_s=1.0)
SCENARIO = "camera_driver_issue+image_degradation"
FOCUS = Adaptation(AdaptationKind.SET_PARAMETER, "camera", "perform_autofocus", value=True)

pytestmark = pytest.mark.usefixtures("flight")


def spec_of(manager: str = "none", timing: Timing = SHORT) -> RunSpec:
    return RunSpec(scenario=load_scenario(SCENARIO), manager=manager, settings=Settings(timing=timing))


@contextmanager
def world_of(folder: Path, spec: RunSpec) -> Iterator[tuple[World, RecordWriter]]:
    with system_with(fault.name for fault in spec.scenario.faults), RecordWriter(folder) as writer:
        yield World(spec, prepare(spec), Observer(writer)), writer


class ByNumber(ManagingSystem):
    """Does something in some of its decisions, which it counts."""

    steps = {3: (restart("camera"), FOCUS), 12: (redeploy("camera"),)}  # noqa: RUF012  read only

    def on_start(self) -> None:
        self.number = 0

    def adapt(self, symptoms: Symptoms) -> None:
        del symptoms
        self.number += 1
        for step in self.steps.get(self.number, ()):
            request(self, step)


class Told(ManagingSystem):
    """Waits for each decision until it is told."""

    is_asked = False
    answer: Future[Sequence[Adaptation]]

    async def adapt(self, symptoms: Symptoms) -> None:  # type: ignore[override]  # it may be a coroutine
        del symptoms
        self.is_asked, self.answer = True, Future()
        for step in await self.answer:
            request(self, step)


def tell(world: World, manager: Told) -> None:
    number = 0
    while world.advance_until(lambda: manager.is_asked):
        number += 1
        manager.is_asked = False
        manager.answer.set_result(ByNumber.steps.get(number, ()))


@pytest.mark.parametrize("manager", [Reactive, ByNumber])
def test_a_managing_system_in_the_same_process_leaves_the_messages_of_a_confined_one(
    tmp_path: Path, manager: type[ManagingSystem]
) -> None:
    name = "reactive" if manager is Reactive else f"{__file__}:ByNumber"
    confined = run(spec_of(name), tmp_path / "confined")

    with world_of(tmp_path / "world", spec_of()) as (world, writer):
        world.manage(manager)
        start_ns = world.finish()

        assert writer.digest == confined.record.digest
        assert start_ns == confined.record.start_ns


def test_a_decision_that_is_told_leaves_the_messages_of_one_that_is_made(tmp_path: Path) -> None:
    with world_of(tmp_path / "made", spec_of()) as (world, made):
        world.manage(ByNumber)
        world.finish()
        expected = made.digest

    with world_of(tmp_path / "told", spec_of()) as (world, written):
        tell(world, world.manage(Told))
        world.finish()

        assert written.digest == expected


def test_an_experiment_stops_where_it_is_asked_to(tmp_path: Path) -> None:
    with world_of(tmp_path / "run", spec_of()) as (world, _):
        assert world.advance_until(lambda: world.now_ns >= 3 * 10**9)
        assert 3 * 10**9 <= world.now_ns < 3.1 * 10**9
        world.advance_to(4 * 10**9)
        assert world.now_ns == 4 * 10**9
        assert not world.advance_until(lambda: False)
        assert world.is_over
        assert world.start_ns is not None
        assert world.now_ns == world.start_ns + 5 * 10**9


def test_a_system_that_does_not_come_up_is_an_error(tmp_path: Path) -> None:
    with (
        world_of(tmp_path / "run", spec_of(timing=Timing(bring_up_limit_s=2.0))) as (world, _),
        pytest.raises(SunsetError, match=r"^The managed system did not come up within 2 s in "),
    ):
        world.advance_until(lambda: False)
