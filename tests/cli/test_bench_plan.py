from tests.cli.conftest import Complaint


def test_an_earlier_campaign_without_a_plan_is_refused(complaint: Complaint) -> None:
    assert "add --plan" in complaint(["bench", "--like", "x", "--out", "y"])


def test_a_plan_has_two_formats(complaint: Complaint) -> None:
    assert "printed as table or json, got 'latex'" in complaint(["bench", "--plan", "--format", "latex"])


def test_an_earlier_campaign_that_is_missing_is_refused(complaint: Complaint) -> None:
    assert "There is no folder" in complaint(["bench", "--plan", "--like", "nowhere"])
