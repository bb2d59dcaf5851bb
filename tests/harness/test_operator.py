"""The operator of a live system: what it shows of the nodes, whatever is said of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

import pytest

from sunset.harness.node_process import NodeProcesses
from sunset.harness.operator import Operator
from sunset.system_interfaces.msg import SetBlackboardGroup
from sunset_ros import Context
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter as ParameterMessage
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterValue
from sunset_ros.parameter import Parameter

if TYPE_CHECKING:
    from tests.conftest import World


class Processes:
    """One process, which runs or has ended in order."""

    nodes: Sequence[str] = ("camera",)

    def __init__(self, pid: int | None = 7) -> None:
        self._pid = pid

    def pid(self, node: str) -> int | None:
        return self._pid

    def end_of(self, node: str) -> str:
        return "ended with exit code 0"


def shown(operator: Operator, pid: int | None = 7) -> tuple[str, float | None]:
    (status,) = operator.status(cast("NodeProcesses", Processes(pid)))
    return status.state, status.hertz


def tell(world: "World", **values: object) -> None:
    entries = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
    world.publish("/blackboard_group", SetBlackboardGroup(bb_params=entries))
    world.run(0.01)


@pytest.fixture
def operator(world: "World") -> Operator:
    def make(*, context: Context, parameter_overrides: object) -> Operator:
        del parameter_overrides
        return Operator(inject=False, warm_up_s=1.0, context=context)

    return world.start(make)


def test_state_and_frequency_come_from_the_blackboard(world: "World", operator: Operator) -> None:
    assert shown(operator) == ("starting", None)
    tell(world, camera_lc_state="active", managed_subsystem_rgb_camera_freq=9.0)
    assert shown(operator) == ("active", 9.0)


def test_a_node_that_runs_in_a_process_of_somebody_else_is_shown_as_it_is(
    world: "World", operator: Operator
) -> None:
    assert shown(operator, None)[0] == "ended with exit code 0"
    tell(world, camera_lc_state="active")
    assert shown(operator, None)[0] == "active"
    tell(world, camera_lc_state="unknown")
    assert shown(operator, None)[0] == "ended with exit code 0"
    assert shown(operator, 8)[0] == "unknown"  # its new process here has not been heard yet


def test_it_says_when_a_managing_system_may_start(world: "World") -> None:
    def make(*, context: Context, parameter_overrides: object) -> Operator:
        del parameter_overrides
        return Operator(inject=False, warm_up_s=1.0, invites=True, context=context)

    operator = world.start(make)
    tell(world, managed_subsystem_rgb_camera_freq=1.0)
    assert not operator.news
    for frequency in (1.0, 0.0, 2.0):
        tell(world, managed_subsystem_segmentation_freq=frequency)
    assert list(operator.news) == ["The system is up; start your managing system now."]


def test_types_and_names_that_it_does_not_know_are_passed_over(world: "World", operator: Operator) -> None:
    entries = [ParameterMessage(name="camera_lc_state", value=ParameterValue(type=200))]
    entries += [ParameterMessage(name=f"{number}_freq", value=ParameterValue(type=3)) for number in range(9)]
    world.publish("/blackboard_group", SetBlackboardGroup(bb_params=entries))
    world.run(0.01)
    assert shown(operator) == ("starting", None)
