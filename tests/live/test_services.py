"""All parameter and lifecycle services of all nodes of a running system, asked through the wire alone.

What is expected is what rclpy's nodes answer; where a request would kill one of those, a refusal.
"""

from collections.abc import Iterator
from typing import Any

import pytest
from tests.live.services import (
    BOOL,
    DOUBLE,
    FAULT,
    INTEGER,
    NODES,
    STRING,
    Asker,
    bad_parameters,
    good_parameters,
    parameter,
    python_value,
)
from tests.live.systems import MANAGED, Tool, Up, eventually, exists, going_up

from conformance.test_lifecycle import GRAPH
from sunset.system_interfaces.srv import Redeploy
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import (
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from sunset_ros.interfaces.rcl_interfaces.msg import Parameter
from sunset_ros.interfaces.rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)

pytestmark = [pytest.mark.xdist_group("processes"), pytest.mark.thorough]

OF_EVERY_NODE = {
    name: f"rcl_interfaces/srv/{kind}"
    for name, kind in {
        "describe_parameters": "DescribeParameters",
        "get_parameter_types": "GetParameterTypes",
        "get_parameters": "GetParameters",
        "list_parameters": "ListParameters",
        "set_parameters": "SetParameters",
        "set_parameters_atomically": "SetParametersAtomically",
    }.items()
}
LIFECYCLE_SERVICES = {
    name: f"lifecycle_msgs/srv/{kind}"
    for name, kind in {
        "change_state": "ChangeState",
        "get_state": "GetState",
        "get_available_states": "GetAvailableStates",
        "get_available_transitions": "GetAvailableTransitions",
        "get_transition_graph": "GetAvailableTransitions",
    }.items()
}
OTHERS = {
    **{f"/managed_subsystem/{node}": LIFECYCLE_SERVICES for node in MANAGED},
    "/bag_player": {"start": "std_srvs/srv/Trigger"},
    "/scenario_executor": {"inject": "std_srvs/srv/Trigger"},
    "/launcher": {"redeploy": "system_interfaces/srv/Redeploy"},
}

STATES = {
    0: "unknown",
    1: "unconfigured",
    2: "inactive",
    3: "active",
    4: "finalized",
    10: "configuring",
    11: "cleaningup",
    12: "shuttingdown",
    13: "activating",
    14: "deactivating",
    15: "errorprocessing",
}
IDS = (*range(10), *(10 * group + outcome for group in range(1, 7) for outcome in range(4)), 99, 255)
LABELS = (
    *("configure", "cleanup", "activate", "deactivate", "create", "destroy", "transition_success"),
    *(
        "transition_failure",
        "transition_error",
        "Activate",
        " activate",
        "activate\n",
        "4",
        "ä",
        "x" * 10_000,
    ),
)
WALK = (  # through every transition but shutdown, once by its id and once by its label
    *((4, "", "inactive"), (0, "cleanup", "unconfigured"), (1, "", "inactive"), (99, "activate", "active")),
    *((1, "deactivate", "inactive"), (2, "", "unconfigured"), (255, "configure", "inactive")),
    (3, "", "active"),
)

every_node = pytest.mark.parametrize("node", NODES)
every_managed_node = pytest.mark.parametrize("node", MANAGED)


@pytest.fixture(scope="module")
def system() -> Iterator[tuple[Up, Tool]]:
    with going_up("--scenario", "autofocus_needed") as (up, tool):
        assert up.tells("The faults are injected")  # which changes a parameter
        yield up, tool


@pytest.fixture(scope="module")
def asker(system: tuple[Up, Tool]) -> Asker:
    return Asker(system[1])


def names_of(asker: Asker, node: str, *prefixes: str, depth: int = 0) -> list[str]:
    request = ListParameters.Request(prefixes=list(prefixes), depth=depth)
    result = asker.ask(ListParameters, f"{node}/list_parameters", request).result
    assert result.prefixes == []  # no name has parts
    found: list[str] = result.names
    return found


def get(asker: Asker, node: str, *names: str) -> list[Any]:
    answer = asker.ask(GetParameters, f"{node}/get_parameters", GetParameters.Request(names=list(names)))
    return [python_value(value) for value in answer.values]


def types_of(asker: Asker, node: str, *names: str) -> list[int]:
    request = GetParameterTypes.Request(names=list(names))
    return list(asker.ask(GetParameterTypes, f"{node}/get_parameter_types", request).types)


def described(asker: Asker, node: str, *names: str) -> list[Any]:
    request = DescribeParameters.Request(names=list(names))
    found: list[Any] = asker.ask(DescribeParameters, f"{node}/describe_parameters", request).descriptors
    return found


def put(asker: Asker, node: str, *parameters: Parameter) -> list[bool]:
    request = SetParameters.Request(parameters=list(parameters))
    results = asker.ask(SetParameters, f"{node}/set_parameters", request).results
    assert all(bool(result.reason) is not result.successful for result in results)
    return [result.successful for result in results]


def put_together(asker: Asker, node: str, *parameters: Parameter) -> bool:
    request = SetParametersAtomically.Request(parameters=list(parameters))
    result = asker.ask(SetParametersAtomically, f"{node}/set_parameters_atomically", request).result
    assert bool(result.reason) is not result.successful
    successful: bool = result.successful
    return successful


@every_node
def test_a_node_offers_the_services_of_its_kind(asker: Asker, node: str) -> None:
    expected = {f"{node}/{name}": kind for name, kind in {**OF_EVERY_NODE, **OTHERS.get(node, {})}.items()}
    namespace, _, name = node.rpartition("/")

    def offered() -> dict[str, str]:
        found = asker.tool.node.get_service_names_and_types_by_node(name, namespace or "/")
        return {service: kind for service, (kind,) in found}

    assert asker.tool.spin(lambda: offered() == expected), offered()


@every_node
def test_all_parameters_are_listed(asker: Asker, node: str) -> None:
    names = list(NODES[node])
    assert names_of(asker, node) == names
    assert names_of(asker, node, depth=1) == names
    assert names_of(asker, node, depth=2**64 - 1) == names
    assert names_of(asker, node, names[-1], "use_sim_time", names[-1]) == list(
        dict.fromkeys(("use_sim_time", names[-1]))
    )
    assert names_of(asker, node, "nonsense", "use_sim", "", "use_sim_time.", "x" * 10_000) == []


@every_node
def test_values_and_types_are_those_declared(asker: Asker, node: str) -> None:
    expected = [known.type for known in NODES[node].values()]
    assert types_of(asker, node, *NODES[node]) == expected
    python = {BOOL: bool, INTEGER: int, DOUBLE: float, STRING: str}
    assert [type(value) for value in get(asker, node, *NODES[node])] == [python[kind] for kind in expected]
    assert types_of(asker, node, "use_sim_time", "use_sim_time") == [BOOL, BOOL]
    assert len(get(asker, node, "use_sim_time", "use_sim_time")) == 2


@every_node
def test_descriptions_are_those_declared(asker: Asker, node: str) -> None:
    descriptors = described(asker, node, *NODES[node])
    for descriptor, (name, known) in zip(descriptors, NODES[node].items(), strict=True):
        ranges = [*descriptor.integer_range, *descriptor.floating_point_range]
        limits = [(each.from_value, each.to_value) for each in ranges]
        assert (descriptor.name, descriptor.type, descriptor.read_only, limits) == (
            name,
            known.type,
            known.read_only,
            [known.limits] if known.limits else [],
        )
        assert not descriptor.dynamic_typing
        assert len(descriptor.integer_range) == (known.type == INTEGER and bool(known.limits))


@every_node
def test_an_unknown_name_empties_the_whole_answer(asker: Asker, node: str) -> None:
    for names in (("nonsense",), ("use_sim_time", ""), ("", "use_sim_time"), ("x" * 10_000,), ()):
        assert get(asker, node, *names) == []
        assert types_of(asker, node, *names) == []
        assert described(asker, node, *names) == []


@every_node
def test_bad_values_are_refused_each_for_itself_and_change_nothing(asker: Asker, node: str) -> None:
    before = get(asker, node, *NODES[node])
    for one in bad_parameters(node):
        assert put(asker, node, one) == [False], one
        assert not put_together(asker, node, one), one
    assert put(asker, node, *bad_parameters(node)) == [False] * len(bad_parameters(node))
    assert get(asker, node, *NODES[node]) == before


@every_node
def test_all_of_a_set_are_taken_or_none(asker: Asker, node: str) -> None:
    before = get(asker, node, *NODES[node])
    good = good_parameters(node)
    for bad in bad_parameters(node):
        assert not put_together(asker, node, good[0], bad), bad
    assert not put_together(asker, node, bad_parameters(node)[0], *good)
    assert get(asker, node, *NODES[node]) == before
    assert put_together(asker, node)
    assert put(asker, node) == []
    wanted = {one.name: one for one in good}  # the last of each
    assert put_together(asker, node, *good)
    assert get(asker, node, *wanted) == [python_value(one.value) for one in wanted.values()]


@every_node
def test_good_values_are_taken_one_after_the_other(asker: Asker, node: str) -> None:
    bad = bad_parameters(node)[0]
    for one in good_parameters(node):
        if one.name == "image_shift" and not one.value.integer_value:
            continue  # by now it is there
        assert put(asker, node, bad, one, bad) == [False, True, False], one
        assert get(asker, node, one.name) == [python_value(one.value)]


@pytest.mark.parametrize(
    ("node", "fault", "cure"),
    [
        ("camera", "autofocus_needed", "perform_autofocus"),
        ("sensor_fusion", "image_shift", "do_recalibration"),
    ],
)
def test_a_fault_is_not_wished_away_but_cured(asker: Asker, node: str, fault: str, cure: str) -> None:
    node = f"/managed_subsystem/{node}"
    kind = NODES[node][fault].type
    present, gone = {BOOL: (True, False), INTEGER: (1920, 0)}[kind]
    assert put(asker, node, parameter(fault, kind, present)) == [True]
    assert put(asker, node, parameter(fault, kind, gone)) == [False]
    assert not put_together(asker, node, parameter("use_sim_time", BOOL, True), parameter(fault, kind, gone))
    assert get(asker, node, fault) == [present]
    assert put(asker, node, parameter(cure, BOOL, False)) == [True]
    assert get(asker, node, fault) == [present]
    assert put(asker, node, parameter(cure, BOOL, True)) == [True]
    assert asker.tool.spin(lambda: get(asker, node, fault, cure) == [gone, False])


@every_node
def test_a_fault_is_taken_and_stays(asker: Asker, node: str) -> None:
    faults = [name for name, known in NODES[node].items() if known is FAULT]
    for fault in faults:
        assert put(asker, node, parameter(fault, BOOL, False), parameter(fault, BOOL, True)) == [True, True]
        assert put(asker, node, parameter(fault, BOOL, False)) == [False]
    assert get(asker, node, *faults) == [True] * len(faults)


def change(asker: Asker, node: str, number: int = 0, label: str = "") -> bool:
    request = ChangeState.Request(transition=Transition(id=number, label=label))
    success: bool = asker.ask(ChangeState, f"/managed_subsystem/{node}/change_state", request).success
    return success


def state(asker: Asker, node: str) -> str:
    current = asker.ask(GetState, f"/managed_subsystem/{node}/get_state", GetState.Request()).current_state
    assert STATES[current.id] == current.label
    label: str = current.label
    return label


def activate(asker: Asker, node: str) -> None:
    """Wait until a node is active; the image enhancement must be asked to."""
    if node == "image_enhancement" and state(asker, node) == "inactive":
        assert change(asker, node, label="activate")
    assert asker.tool.spin(lambda: state(asker, node) == "active")


def transitions(asker: Asker, node: str, service: str) -> list[tuple[int, str, int, int]]:
    request = GetAvailableTransitions.Request()
    response = asker.ask(GetAvailableTransitions, f"/managed_subsystem/{node}/{service}", request)
    for one in response.available_transitions:
        assert STATES[one.start_state.id] == one.start_state.label
        assert STATES[one.goal_state.id] == one.goal_state.label
    return [
        (one.transition.id, one.transition.label, one.start_state.id, one.goal_state.id)
        for one in response.available_transitions
    ]


@every_managed_node
def test_all_states_and_transitions_are_told(asker: Asker, node: str) -> None:
    service = f"/managed_subsystem/{node}/get_available_states"
    states = asker.ask(GetAvailableStates, service, GetAvailableStates.Request()).available_states
    assert {one.id: one.label for one in states} == STATES
    assert len(states) == len(STATES)
    assert sorted(transitions(asker, node, "get_transition_graph")) == sorted(GRAPH)


@every_managed_node
def test_transitions_of_the_state_are_taken_and_all_others_refused(asker: Asker, node: str) -> None:
    activate(asker, node)
    now, seen = "active", set()
    for number, label, goal in WALK:
        available = [one for one in GRAPH if STATES[one[2]] == now]
        assert sorted(transitions(asker, node, "get_available_transitions")) == sorted(available)
        if now not in seen:
            seen.add(now)
            for other in {*IDS} - {one[0] for one in available}:
                assert not change(asker, node, other), (now, other)
            for other_label in {*LABELS} - {one[1] for one in available}:
                assert not change(asker, node, available[0][0], other_label), (now, other_label)
        assert state(asker, node) == now
        assert change(asker, node, number, label)
        now = goal
    assert state(asker, node) == "active"
    assert seen == {"active", "inactive", "unconfigured"}


@pytest.mark.parametrize(
    ("steps", "number"),
    [((), 7), (("deactivate",), 6), (("deactivate", "cleanup"), 5)],
    ids=["active", "inactive", "unconfigured"],
)
def test_a_shutdown_ends_the_process(
    system: tuple[Up, Tool], asker: Asker, steps: tuple[str, ...], number: int
) -> None:
    up, tool = system
    for node in MANAGED:
        if not exists(up.pids[node]):  # since the test before
            assert tool.call(Redeploy, "/launcher/redeploy", Redeploy.Request(node=node)).success
    for index, node in enumerate(MANAGED):
        activate(asker, node)
        for step in steps:
            assert change(asker, node, label=step)
        by_label = (index + number) % 2
        assert change(asker, node, 0 if by_label else number, "shutdown" if by_label else "")
    for node in MANAGED:
        assert eventually(lambda node=node: up.state(node).startswith("ended in order"))  # type: ignore[misc]
        assert not exists(up.pids[node])
