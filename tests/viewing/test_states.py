"""What holds from when to when, where a record says little of it."""

from sunset.viewing.states import States


def test_a_node_that_reports_no_transition_has_no_states() -> None:
    assert States([], 0, (0.0, 1.0)).lifecycle("camera") == []
