"""Groups of comparable campaigns: who is in which, which rows they have, and how the rows are compared."""

import re
from collections.abc import Sequence
from dataclasses import replace

import pytest
from msgspec import structs
from tests.evaluation.test_scores import campaign

from sunset.errors import RecordError
from sunset.evaluation.leaderboard import Group, Submission, leaderboard_page
from sunset.evaluation.results import RunRow
from sunset.recording import SETTINGS, CampaignPlan
from sunset.scenarios import SplitDescription
from sunset.system import DIAGNOSE

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


def submission(
    name: str, runs: Sequence[RunRow], plan: CampaignPlan = PLAN, split: SplitDescription | None = None
) -> Submission:
    runs = [
        replace(one, sources=one.manager, digest=f"{one.manager} {one.scenario} {one.seed}") for one in runs
    ]
    return Submission(
        name=name,
        plan=plan,
        runs=runs,
        scenarios="3" * 64,
        split=split,
        is_drawn_again=False,
        date="2026-03-14",
        authors="Ada",
        again={},
        sha256="4" * 64,
    )


def page(*submissions: Submission, refused: dict[str, str] | None = None) -> str:
    groups: dict[bytes, Group] = {}
    for one in submissions:
        groups.setdefault(one.group, Group()).add(one)
    return leaderboard_page([*groups.values()], submissions, refused or {})


def rows(text: str) -> dict[str, dict[str, str]]:
    """Return the rows of all tables: name → column → text."""
    lines = re.findall(r'<tr><th scope="row">(.*?)</th>(.*?)</tr>', text)
    cell = r'<td[^>]*data-name="(.*?)"[^>]*>(?:<a [^>]*>)?(.*?)<'
    return {name: dict(re.findall(cell, cells)) for name, cells in lines}


def test_rows_of_several_bundles_are_ranked_and_each_is_compared_with_the_row_above() -> None:
    text = page(submission("first", campaign(half=0.5)), submission("second", campaign(most=0.9)))

    table = rows(text)
    assert [*table][:4] == ["oracle", "most", "half", "none"]
    assert [table[name]["bundle"] for name in [*table][:4]] == ["first", "second", "first", "first"]
    assert [re.sub(r" \[.*", "", table[name]["score ↑"]) for name in [*table][:4]] == [
        *("1.00", "0.90", "0.50", "0.00"),
    ]
    # 9 pairs with something to repair, and 3 without, in which both lose the same
    assert table["half"]["pairs won"].startswith(f"{1.5 / 12:.2f} (p ")
    assert table["oracle"]["pairs won"] == "N/A"
    assert "Suite timed, seeds 1 to 3" in text


@pytest.mark.parametrize(
    "change",
    [
        {"seed": 2},
        {"repetitions": 4},
        {"split": "5" * 64},
        {"model_checksum": "6" * 64},
        {"bag_checksum": "7" * 64},
        {"timing": {"duration_s": 5.0}},
        {"versions": {"sunset": "0.1.0+bb"}},
    ],
    ids=lambda change: next(iter(change)),
)
def test_campaigns_with_other_settings_have_a_table_of_their_own(change: dict[str, object]) -> None:
    other = structs.replace(PLAN, **change)
    first, second = submission("first", campaign(half=0.5)), submission("second", campaign(most=0.9), other)

    assert first.group != second.group
    assert page(first, second).count("<h2>Suite timed") == 2


def test_the_tables_of_several_versions_are_named_after_them() -> None:
    runs = [replace(one, version="0.1.0+bb") for one in campaign()]
    other = submission("second", runs, structs.replace(PLAN, versions={"sunset": "0.1.0+bb"}))
    text = page(submission("first", [replace(one, version="0.1.0+aa") for one in campaign()]), other)

    assert re.findall("<h2>(Suite .*)</h2>", text) == [
        f"Suite timed, seeds 1 to 3, SUNSET 0.1.0+{version}" for version in ("aa", "bb")
    ]


def test_campaigns_that_differ_in_their_managing_systems_are_comparable() -> None:
    other = structs.replace(
        PLAN, managers=("mine",), manager_checksums={"mine": "8"}, runs=3, versions={"sunset": "0.1.0+aa"}
    )
    assert submission("first", campaign()).group == submission("second", campaign(), other).group


def test_equal_names_are_told_apart_and_equal_runs_are_listed_once() -> None:
    group = Group()
    first, second = submission("first", campaign(mine=0.5)), submission("second", campaign(mine=0.9))
    other = [replace(one, sources="other") if one.manager == "mine" else one for one in second.runs]
    copied = [replace(one, manager="yours") if one.manager == "mine" else one for one in first.runs]

    group.add(first)
    group.add(replace(second, runs=other))
    group.add(submission("third", campaign(new=0.1)))
    both = [*copied, *(replace(one, manager="more", sources="more") for one in first.runs)]
    group.add(replace(first, name="fourth", runs=both))

    assert {"mine", "mine of second", "new", "more"} < group.systems.keys()
    assert group.notes == ["yours of fourth has the source and the runs of mine of first."]
    with pytest.raises(RecordError, match=r"^all of its runs are in first already\.$"):
        group.add(replace(first, name="fifth"))


def test_the_references_of_all_bundles_must_agree() -> None:
    group, first, second = Group(), submission("first", campaign()), submission("second", campaign(new=0.2))
    forged = [replace(one, digest="forged") if one.manager == "oracle" else one for one in second.runs]

    group.add(first)
    with pytest.raises(
        RecordError,
        match=r"^its run of oracle in timed/a, seed 1, has other messages than the same run in first: ",
    ):
        group.add(replace(second, runs=forged))
    assert group.systems.keys() == {"none", "oracle"}


def test_who_looked_at_images_is_ranked_apart() -> None:
    runs = [
        replace(one, evidence="images") if one.manager == "seeing" else one
        for one in campaign(seeing=0.9, half=0.5)
    ]
    _, *tables = page(submission("first", runs)).split("<h2>Suite timed, seeds 1 to 3, by ")

    assert [[table.partition("<")[0], *rows(table)][:4] for table in tables] == [
        ["symptoms", "oracle", "half", "none"],
        ["images", "oracle", "seeing", "none"],
    ]
    assert rows(tables[1])["seeing"]["pairs won"].startswith("0.00 (p ")


def test_of_campaigns_that_only_diagnose_the_diagnosis_ranks() -> None:
    figures = {"none": 0, "oracle": 0, "dull": 1, "keen": 3}
    runs = [
        replace(
            one,
            settings={**SETTINGS, "task": DIAGNOSE},
            metrics={
                **one.metrics,
                "diagnoses": 1,
                "faults_identified": figures[one.manager],
                "faults_injected": 4,
            },
        )
        for one in campaign(dull=0.0, keen=0.0)
    ]
    table = rows(page(submission("first", runs, structs.replace(PLAN, task=DIAGNOSE))))

    assert [*table][:2] == ["keen", "dull"]
    assert table["keen"]["identified ↑"] == "36/48"
    assert table["keen"]["score ↑"] == table["keen"]["pairs won"] == "N/A"


def test_the_split_and_its_salt_are_named_and_the_names_of_strangers_do_no_harm() -> None:
    split = SplitDescription(
        split="test",
        count=4,
        seed=1,
        flights=False,
        salt_sha256="9" * 64,
        rule=1,
        extensions={},
        sha256="a" * 64,
    )
    evil = "<script>evil"
    text = page(submission("first", campaign(**{evil: 0.5}), split=split), refused={evil: evil})

    assert f"split test: SHA-256 {'a' * 64}\n" in text
    assert f"salt: SHA-256 {'9' * 64}; the scenarios were not drawn from it again<" in text
    assert "<script>" not in text
    assert text.count("&lt;script&gt;") >= 3


def test_a_page_without_a_bundle_says_what_was_refused() -> None:
    text = page(refused={"forged": "it does not pass."})

    assert "<li><b>forged</b>: it does not pass.</li>" in text
    assert "The bundles" not in text
