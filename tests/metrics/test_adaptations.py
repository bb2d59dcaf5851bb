import pytest

from sunset.metrics import Command, ExecutedAdaptation, Injection, executed_adaptations, unnecessary_redeploys


def command(time: float, kind: str, node: str = "camera", **more: object) -> Command:
    values: dict[str, object] = {"client": "/manager", "successful": True, **more}
    return Command(time, node="/managed_subsystem/" + node, kind=kind, **values)  # type: ignore[arg-type]


def words(*commands: Command) -> list[str]:
    return [str(adaptation) for adaptation in executed_adaptations(commands, until_s=20.0)]


def test_each_kind_of_command_is_one_adaptation() -> None:
    assert words(
        command(1, "redeploy"),
        command(2, "activate", "image_enhancement"),
        command(4, "deactivate", "image_enhancement"),
        command(6, "set_parameters", parameters=("perform_autofocus",), values=("true",)),
    ) == [
        "redeploy camera",
        "activate image_enhancement",
        "deactivate image_enhancement",
        "set camera.perform_autofocus to true",
    ]


def test_one_call_that_sets_two_parameters_is_one_adaptation() -> None:
    both = command(1, "set_parameters", "sensor_fusion", parameters=("modality", "x"), values=("1", "2"))
    assert words(both) == ["set sensor_fusion.modality to 1 and sensor_fusion.x to 2"]


def test_setting_a_topic_is_a_change_of_topic() -> None:
    rewire = command(
        1, "set_parameters", "sensor_fusion", parameters=("topic_camera_input",), values=("rgb_enhanced",)
    )
    (adaptation,) = executed_adaptations((rewire,), until_s=20)
    assert adaptation.kind == "change_topic"


@pytest.mark.parametrize(("gap", "expected"), [(0.0, 1), (0.05, 1), (1.0, 1), (1.1, 2)])
def test_deactivate_and_activate_within_a_second_are_one_restart(gap: float, expected: int) -> None:
    done = executed_adaptations((command(3, "deactivate"), command(3 + gap, "activate")), until_s=20)
    assert len(done) == expected
    if expected == 1:
        assert done == (ExecutedAdaptation(3, "camera", "restart", "/manager", completed=3 + gap),)


def test_restart_through_unconfigured_is_one_restart() -> None:
    steps = ("deactivate", "cleanup", "configure", "activate")
    assert words(*(command(3 + 0.1 * i, kind) for i, kind in enumerate(steps))) == ["restart camera"]


def test_restarts_of_two_nodes_may_interleave() -> None:
    assert words(
        command(1.0, "deactivate"),
        command(1.1, "deactivate", "segmentation"),
        command(1.2, "activate"),
        command(1.3, "activate", "segmentation"),
    ) == ["restart camera", "restart segmentation"]


def test_parameter_set_while_a_node_is_down_for_a_restart_counts_for_itself() -> None:
    assert words(
        command(1.0, "deactivate"),
        command(1.1, "set_parameters", parameters=("a",), values=("1",)),
        command(1.2, "activate"),
    ) == ["restart camera", "set camera.a to 1"]


def test_different_clients_make_no_restart() -> None:
    assert words(command(1, "deactivate", client="/a"), command(1.1, "activate", client="/b")) == [
        "deactivate camera",
        "activate camera",
    ]


def test_one_deactivation_makes_one_restart() -> None:
    assert words(command(1, "deactivate"), command(1.1, "activate"), command(1.2, "activate")) == [
        "restart camera",
        "activate camera",
    ]


def test_activation_before_deactivation_is_no_restart() -> None:
    assert words(command(1, "activate"), command(1.1, "deactivate")) == [
        "activate camera",
        "deactivate camera",
    ]


def test_redeploy_between_keeps_them_apart() -> None:
    kinds = ("deactivate", "redeploy", "activate")
    assert words(*(command(1 + 0.1 * i, kind) for i, kind in enumerate(kinds))) == [
        "deactivate camera",
        "redeploy camera",
        "activate camera",
    ]


def test_refused_commands_do_not_count() -> None:
    assert words(command(1, "redeploy", successful=False), command(2, "deactivate", successful=False)) == []


def test_failed_activation_leaves_a_deactivation() -> None:
    assert words(command(1, "deactivate"), command(1.1, "activate", successful=False)) == [
        "deactivate camera"
    ]


@pytest.mark.parametrize("client", ["/scenario_executor", "/launcher", "/experiment"])
def test_the_experiments_own_commands_do_not_count(client: str) -> None:
    assert words(command(0, "set_parameters", client=client), command(1, "shutdown", client=client)) == []


def test_shutdown_by_a_manager_is_a_redeploy() -> None:
    assert words(command(1, "shutdown")) == ["redeploy camera"]


def test_a_shutdown_and_the_redeploy_that_it_needs_are_one() -> None:
    assert words(
        command(1, "shutdown"),
        command(2, "redeploy", "depth"),
        command(3, "redeploy", client="/another"),
        command(5, "redeploy"),
    ) == ["redeploy depth", "redeploy camera", "redeploy camera"]


def test_such_a_redeploy_is_of_the_time_at_which_a_new_process_was_asked_for() -> None:
    commands = [command(1, "shutdown"), command(3, "redeploy")]
    assert [adaptation.time for adaptation in executed_adaptations(commands, until_s=20)] == [3.0]
    assert [adaptation.time for adaptation in executed_adaptations(commands, until_s=2)] == [1.0]


@pytest.mark.parametrize("node", ["/monitor", "/elsewhere/camera", "rviz", ""])
def test_other_nodes_are_not_the_managed_system(node: str) -> None:
    assert words(Command(1.0, "/manager", node, "redeploy")) == []


def test_short_node_names_are_taken() -> None:
    assert words(Command(1.0, "/manager", "camera", "redeploy")) == ["redeploy camera"]


def test_unknown_kind_of_command_is_no_adaptation() -> None:
    assert words(command(1, "get_parameters")) == []


def test_commands_after_the_end_do_not_count_and_those_of_the_warm_up_do() -> None:
    assert (
        words(command(-1, "redeploy"), command(20.0, "redeploy"), command(20.1, "redeploy"))
        == ["redeploy camera"] * 2
    )


DISCONNECT = Injection(0.0, "hardware_disconnect", "F1", "camera", redeploy_only=True)
DRIVER = Injection(0.0, "camera_driver_issue", "F1", "/managed_subsystem/camera")


def unnecessary(times: list[float], *injections: Injection, node: str = "camera") -> list[float]:
    done = [ExecutedAdaptation(time, node, "redeploy") for time in times]
    return [adaptation.time for adaptation in unnecessary_redeploys(done, injections)]


def test_first_redeploy_of_a_fault_that_needs_one_is_necessary_and_the_next_is_not() -> None:
    assert unnecessary([1.2, 7.0], DISCONNECT) == [7.0]


def test_redeploy_of_a_fault_that_a_restart_cures_is_unnecessary() -> None:
    assert unnecessary([1.2], DRIVER) == [1.2]


def test_redeploy_before_the_injection_is_unnecessary_and_cures_nothing() -> None:
    assert unnecessary([-1.0, 1.2], DISCONNECT) == [-1.0]


def test_redeploy_of_another_node_is_unnecessary_and_cures_nothing() -> None:
    assert unnecessary([1.2], DISCONNECT, node="segmentation") == [1.2]


def test_one_redeploy_cures_all_faults_of_its_node() -> None:
    other = Injection(0.5, "another", "F1", "camera", redeploy_only=True)
    assert unnecessary([1.2, 2.0], DISCONNECT, other) == [2.0]


def test_fault_injected_again_after_its_cure_needs_a_redeploy_again() -> None:
    again = Injection(5.0, "hardware_disconnect", "F1", "camera", redeploy_only=True)
    assert unnecessary([1.2, 3.0, 6.0], DISCONNECT, again) == [3.0]


def test_restarts_are_no_redeploys() -> None:
    restart = ExecutedAdaptation(1.0, "camera", "restart")
    assert unnecessary_redeploys([restart], [DISCONNECT]) == ()


def test_a_redeploy_after_its_fault_has_healed_is_unnecessary() -> None:
    healed = Injection(1.0, "hardware_disconnect", "F1", "camera", redeploy_only=True, ended=3.0)
    assert unnecessary([2.0], healed) == []
    assert unnecessary([4.0], healed) == [4.0]
