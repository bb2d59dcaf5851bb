import pytest
from tests.cli.conftest import Complaint


def test_an_earlier_campaign_without_a_plan_is_refused(complaint: Complaint) -> None:
    assert "add --plan" in complaint(["bench", "--like", "x", "--out", "y"])


def test_a_plan_has_two_formats(complaint: Complaint) -> None:
    assert "printed as table or json, got 'latex'" in complaint(["bench", "--plan", "--format", "latex"])


def test_a_part_of_a_plan_is_refused(complaint: Complaint) -> None:
    assert "of the whole campaign: leave out --shard" in complaint(["bench", "--plan", "--shard", "1/2"])


@pytest.mark.parametrize("verb", ["bench", "report"])
def test_two_formats_at_once_are_refused(verb: str, complaint: Complaint) -> None:
    told = complaint([verb, *["x"] * (verb == "report"), "--json", "--format", "csv"])
    assert "argument --format: not allowed with argument --json" in told.lower()


def test_an_earlier_campaign_that_is_missing_is_refused(complaint: Complaint) -> None:
    assert "There is no folder" in complaint(["bench", "--plan", "--like", "nowhere"])
