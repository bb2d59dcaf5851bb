"""What the diagnosing managing system believes: by what shows, by what was done, and after some time."""

import pytest

from sunset.managing.diagnosing import Belief

FAULTS = ("camera_driver_issue", "hardware_disconnect", "sync_issue")
SUSPECTS = FAULTS[:2]


@pytest.fixture
def belief() -> Belief:
    return Belief(FAULTS)


def test_a_fault_is_rare_until_its_symptom_shows(belief: Belief) -> None:
    assert belief.probability("sync_issue") == 0.01
    belief.suspect("F1", SUSPECTS)
    assert belief.probability("sync_issue") == 0.01
    assert belief.probability_of_any(SUSPECTS) > 0.7


def test_what_one_suspect_loses_the_other_gets(belief: Belief) -> None:
    belief.suspect("F1", SUSPECTS)
    before = belief.probability("hardware_disconnect")
    belief.exclude(["camera_driver_issue"])
    assert belief.probability("hardware_disconnect") > 0.95 > before
    assert belief.probability("camera_driver_issue") < 0.05


def test_a_confirmed_fault_stays_when_its_symptom_is_gone(belief: Belief) -> None:
    belief.suspect("F1", SUSPECTS)
    belief.confirm("hardware_disconnect")
    belief.settle("F1", SUSPECTS)
    assert belief.probability("hardware_disconnect") > 0.95
    assert belief.probability("camera_driver_issue") == 0.01
    belief.exclude(["hardware_disconnect"])
    assert not belief.is_certain("hardware_disconnect")


def test_an_excluded_fault_may_come_anew_after_some_time(belief: Belief) -> None:
    belief.exclude(SUSPECTS)
    assert not belief.is_plausible(SUSPECTS)
    belief.forget(1.0)
    assert not belief.is_plausible(SUSPECTS)
    belief.forget(20.0)
    assert belief.is_plausible(SUSPECTS)
    belief.suspect("F1", SUSPECTS)
    assert belief.probability("hardware_disconnect") == pytest.approx(
        belief.probability("camera_driver_issue")
    )


def test_what_was_confirmed_may_have_healed_after_some_time(belief: Belief) -> None:
    assert belief.probability_healed("hardware_disconnect") == 0.0
    belief.confirm("hardware_disconnect")
    assert belief.probability_healed("hardware_disconnect") == 0.0
    belief.forget(1.0)
    soon = belief.probability_healed("hardware_disconnect")
    belief.forget(60.0)
    late = belief.probability_healed("hardware_disconnect")
    assert 0.0 < soon < 0.05 < late < 0.26
    assert belief.probability_healed("camera_driver_issue") == 0.0
    belief.confirm("hardware_disconnect")
    assert belief.probability_healed("hardware_disconnect") == 0.0
