"""Groups of comparable campaigns: who is in which, which rows they have, and how the rows are compared."""

import re
from collections.abc import Sequence
from dataclasses import replace

import pytest
from msgspec import structs
from tests.evaluation.test_scores import campaign

from sunset.evaluation.leaderboard import Submission, leaderboard_page
from sunset.evaluation.results import RunRow
from sunset.recording import CampaignPlan

PLAN = CampaignPlan(
    plan_version=1,
    suite="timed",
    scenarios_checksum="1" * 64,
    managers=("none",),
    manager_checksums={},
    repetitions=3,
    seed=1,
    runs=12,
    model="lite",
    model_checksum="2" * 64,
    bag=None,
    bag_checksum="",
    device="cpu",
    timing={},
    versions={"sunset": "0.1.0+aa", "numpy": "2.0"},
)


def submission(name: str, runs: Sequence[RunRow], plan: CampaignPlan = PLAN) -> Submission:
    return Submission(name=name, plan=plan, runs=runs, date="2026-03-14", authors="Ada", again=1)


def tables(text: str) -> dict[str, dict[str, list[str]]]:
    """Return the tables of a page: title → row → cells."""
    _, *parts = text.split("<h2>")
    row = r'<tr><th scope="row">(.*?)</th>(.*?)</tr>'
    cell = r"<td[^>]*>(?:<a [^>]*>)?(.*?)<"
    return {
        part.partition("<")[0]: {name: re.findall(cell, cells) for name, cells in re.findall(row, part)}
        for part in parts
    }


def test_rows_of_several_bundles_are_ranked_and_neighbours_are_compared() -> None:
    text = leaderboard_page(
        [submission("first", campaign(half=0.5)), submission("second", campaign(most=0.9))], []
    )

    found = tables(text)
    suite = "timed, 3 seeds from 1, SUNSET "
    scores = found[f"The score: {suite}"]
    assert [*scores] == ["oracle", "most", "half", "none"]
    assert [cells[-2] for cells in scores.values()] == ["first", "second", "first", "first"]
    assert [re.sub(r" \[.*", "", cells[2]) for cells in scores.values()] == ["1.00", "0.90", "0.50", "0.00"]
    assert scores["most"][-4:] == ["2026-03-14", "Ada", "second", "1/12"]
    assert '<a href="bundles/second.txt">1/12</a>' in text
    # 9 pairs with something to repair, and 3 without, in which both lose the same
    assert found[f"Differences between neighbours: {suite}"]["most − half"][3] == f"{10.5 / 12:.2f}"
    assert f"{suite}: 4 scenarios of " in text


@pytest.mark.parametrize(
    "change",
    [
        {"seed": 2},
        {"repetitions": 4},
        {"split": "5" * 64},
        {"model_checksum": "6" * 64},
        {"bag_checksum": "7" * 64},
        {"timing": {"duration_s": 5.0}},
    ],
    ids=lambda change: next(iter(change)),
)
def test_campaigns_with_other_settings_have_a_table_of_their_own(change: dict[str, object]) -> None:
    first, second = submission("first", campaign()), submission("second", campaign())
    second = replace(second, plan=structs.replace(PLAN, **change))

    assert first.group != second.group
    assert leaderboard_page([first, second], []).count("<h2>The score: timed") == 2


def test_campaigns_of_other_scenarios_or_versions_have_a_table_of_their_own() -> None:
    first = submission("first", campaign())
    others = (
        [replace(one, faults="other") for one in campaign()],
        [replace(one, version="0.1.0+bb") for one in campaign()],
    )
    assert len({submission("second", runs).group for runs in others} | {first.group}) == 3


def test_campaigns_that_differ_in_their_managing_systems_are_comparable() -> None:
    other = structs.replace(PLAN, managers=("mine",), manager_checksums={"mine": "8"}, runs=3, versions={})
    assert submission("first", campaign()).group == submission("second", campaign(), other).group


def test_equal_names_are_told_apart_and_what_comes_with_sunset_is_listed_once() -> None:
    first, second = submission("first", campaign(mine=0.5)), submission("second", campaign(mine=0.9))

    (scores, *_) = tables(leaderboard_page([first, second], [])).values()

    assert [*scores] == ["oracle", "mine of second", "mine", "none"]


def test_the_names_of_strangers_do_no_harm() -> None:
    evil = "<script>evil"
    one = submission(evil, campaign(**{evil: 0.5}), structs.replace(PLAN, split="5" * 64))
    text = leaderboard_page([one], [f"{evil} is refused: {evil}"])

    assert f"; split: SHA-256 {'5' * 64}." in text
    assert "<script>" not in text
    assert "<li>&lt;script&gt;evil is refused: &lt;script&gt;evil</li>" in text
