"""What holds from when to when, where a record says little of it."""

from sunset.metrics import Injection
from sunset.viewing.states import States


def test_a_node_that_reports_no_transition_has_no_states() -> None:
    assert States([], 0, (0.0, 1.0)).lifecycle("camera") == []


def test_a_fault_was_there_from_its_onset_to_its_end() -> None:
    transient = Injection(2.0, "camera_driver_issue", "F1", "/managed_subsystem/camera", ended=4.0)
    assert States([], 0, (-1.0, 10.0)).fault(transient) == [(2.0, 4.0)]
