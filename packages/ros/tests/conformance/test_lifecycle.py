"""Lifecycle nodes, as real rclpy nodes behave, except that no request kills them."""

from typing import Any

import pytest

from conformance.harness import Harness
from sunset_ros.interfaces.lifecycle_msgs.msg import State, Transition, TransitionEvent
from sunset_ros.interfaces.lifecycle_msgs.srv import (
    ChangeState,
    GetAvailableStates,
    GetAvailableTransitions,
    GetState,
)
from sunset_ros.interfaces.std_msgs.msg import String

GRAPH = [
    *[(1, "configure", 1, 10), (2, "cleanup", 2, 11), (3, "activate", 2, 13), (4, "deactivate", 3, 14)],
    *[(5, "shutdown", 1, 12), (6, "shutdown", 2, 12), (7, "shutdown", 3, 12)],
    *[
        (10, "transition_success", 10, 2),
        (11, "transition_failure", 10, 1),
        (12, "transition_error", 10, 15),
        (20, "transition_success", 11, 1),
        (21, "transition_failure", 11, 2),
        (22, "transition_error", 11, 15),
        (30, "transition_success", 13, 3),
        (31, "transition_failure", 13, 2),
        (32, "transition_error", 13, 15),
        (40, "transition_success", 14, 2),
        (41, "transition_failure", 14, 3),
        (42, "transition_error", 14, 15),
        (50, "transition_success", 12, 4),
        (51, "transition_failure", 12, 4),
        (52, "transition_error", 12, 15),
        (60, "transition_success", 15, 1),
        (61, "transition_failure", 15, 4),
        (62, "transition_error", 15, 4),
    ],
]


def change(harness: Harness, label: str = "", number: int = 0) -> bool:
    client = harness.node.create_client(ChangeState, "/managed/change_state")
    request = ChangeState.Request(transition=Transition(id=number, label=label))
    return bool(harness.call(client, request).success)


def state(harness: Harness) -> tuple[int, str]:
    client = harness.node.create_client(GetState, "/managed/get_state")
    current: State = harness.call(client, GetState.Request()).current_state
    return current.id, current.label


def rows(response: GetAvailableTransitions.Response) -> list[tuple[Any, ...]]:
    return [
        (each.transition.id, each.transition.label, each.start_state.id, each.goal_state.id)
        for each in response.available_transitions
    ]


def test_a_node_goes_through_its_life(harness: Harness) -> None:
    harness.start("Managed")
    assert state(harness) == (1, "unconfigured")
    for label, expected in (
        ("configure", (2, "inactive")),
        ("activate", (3, "active")),
        ("deactivate", (2, "inactive")),
        ("cleanup", (1, "unconfigured")),
        ("shutdown", (4, "finalized")),
    ):
        assert change(harness, label)
        assert state(harness) == expected


def test_transitions_can_be_asked_for_by_id(harness: Harness) -> None:
    harness.start("Managed")
    assert change(harness, number=Transition.TRANSITION_CONFIGURE)
    assert change(harness, number=Transition.TRANSITION_ACTIVATE)
    assert change(harness, number=Transition.TRANSITION_ACTIVE_SHUTDOWN)
    assert state(harness) == (4, "finalized")


def test_a_label_wins_over_an_id(harness: Harness) -> None:
    harness.start("Managed")
    assert change(harness, "configure", Transition.TRANSITION_UNCONFIGURED_SHUTDOWN)
    assert state(harness) == (2, "inactive")


@pytest.mark.parametrize(("label", "number"), [("activate", 0), ("nonsense", 1), ("", 3), ("", 99), ("", 0)])
def test_an_impossible_transition_is_refused_and_the_node_lives(
    harness: Harness, label: str, number: int
) -> None:
    harness.start("Managed")
    assert not change(harness, label, number)
    assert state(harness) == (1, "unconfigured")
    assert change(harness, "configure")


def test_a_lifecycle_publisher_sends_only_while_active(harness: Harness) -> None:
    harness.start("Managed")
    work = harness.collect(String, "/managed/work")
    assert change(harness, "configure")
    harness.pause(0.5)
    assert work == []
    assert change(harness, "activate")
    assert harness.spin(lambda: len(work) >= 3)
    assert change(harness, "deactivate")
    harness.pause(0.3)
    before = len(work)
    harness.pause(0.5)
    assert len(work) == before


@pytest.mark.parametrize(
    ("arguments", "success", "expected", "path"),
    [
        ([], True, (3, "active"), [(2, 13), (13, 3)]),
        (["-p", "activate:=failure"], False, (2, "inactive"), [(2, 13), (13, 2)]),
        (["-p", "activate:=error"], False, (1, "unconfigured"), [(2, 13), (13, 15), (15, 1)]),
        (
            ["-p", "activate:=error", "-p", "error:=failure"],
            False,
            (4, "finalized"),
            [(2, 13), (13, 15), (15, 4)],
        ),
    ],
)
def test_events_tell_the_path_of_a_transition(
    harness: Harness,
    arguments: list[str],
    success: bool,
    expected: tuple[int, str],
    path: list[tuple[int, int]],
) -> None:
    harness.start("Managed", *arguments)
    events = harness.collect(TransitionEvent, "/managed/transition_event")
    assert harness.spin(lambda: harness.node.count_publishers("/managed/transition_event") == 1)
    harness.pause(0.3)
    assert change(harness, "configure")
    assert harness.spin(lambda: len(events) == 2)
    assert [(event.start_state.label, event.goal_state.label) for event in events] == [
        ("unconfigured", "configuring"),
        ("configuring", "inactive"),
    ]
    events.clear()
    assert change(harness, "activate") is success
    assert state(harness) == expected
    assert harness.spin(lambda: len(events) == len(path))
    assert [(event.start_state.id, event.goal_state.id) for event in events] == path


def test_all_states_are_listed(harness: Harness) -> None:
    harness.start("Managed")
    client = harness.node.create_client(GetAvailableStates, "/managed/get_available_states")
    states = harness.call(client, GetAvailableStates.Request()).available_states
    assert [(each.id, each.label) for each in states] == [
        *[(0, "unknown"), (1, "unconfigured"), (2, "inactive"), (3, "active"), (4, "finalized")],
        *[(10, "configuring"), (11, "cleaningup"), (12, "shuttingdown"), (13, "activating")],
        *[(14, "deactivating"), (15, "errorprocessing")],
    ]


def test_available_transitions_leave_the_state(harness: Harness) -> None:
    harness.start("Managed")
    client = harness.node.create_client(GetAvailableTransitions, "/managed/get_available_transitions")
    assert rows(harness.call(client, GetAvailableTransitions.Request())) == [
        (1, "configure", 1, 10),
        (5, "shutdown", 1, 12),
    ]
    assert change(harness, "configure")
    assert rows(harness.call(client, GetAvailableTransitions.Request())) == [
        (2, "cleanup", 2, 11),
        (3, "activate", 2, 13),
        (6, "shutdown", 2, 12),
    ]


def test_the_graph_has_all_transitions(harness: Harness) -> None:
    harness.start("Managed")
    client = harness.node.create_client(GetAvailableTransitions, "/managed/get_transition_graph")
    response = harness.call(client, GetAvailableTransitions.Request())
    assert sorted(rows(response)) == sorted(GRAPH)
    labels = {each.goal_state.id: each.goal_state.label for each in response.available_transitions}
    assert labels[15] == "errorprocessing"
