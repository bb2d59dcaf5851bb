"""Scenarios drawn for training, validation and test: reproducible, and disjoint in the parts that they are made of."""

import hashlib
import json
from collections.abc import Iterator
from functools import cache
from itertools import combinations
from pathlib import Path

import pytest

import sunset
from sunset.cli import main
from sunset.errors import InvalidInputError, OutputError, ScenarioError
from sunset.scenarios import Scenario, SplitSpec, draw_split, load_suite, split_hash

COUNT = 1000
SPLITS = ("train", "validation", "test")
SALT = b"0123456789abcdef0123456789abcdef\n"


@cache
def drawn(name: str) -> tuple[Scenario, ...]:
    return draw_split(SplitSpec(split=name, count=COUNT, seed=1, flights=True))


def courses(scenarios: tuple[Scenario, ...]) -> set[str]:
    return {repr(scenario.faults) for scenario in scenarios}


def pairs(scenario: Scenario) -> set[frozenset[str]]:
    return {frozenset({one.name, other.name}) for one, other in combinations(scenario.faults, 2)}


def values(scenarios: tuple[Scenario, ...], what: str) -> set[object]:
    def of(scenario: Scenario) -> Iterator[object]:
        assert scenario.flight is not None
        faults = scenario.faults
        match what:
            case "pairs":
                yield from pairs(scenario)
            case "profiles":
                yield from (fault.profile.kind for fault in faults)
            case "severities":
                yield from (fault.severity for fault in faults if fault.severity is not None)
            case _:
                yield getattr(scenario.flight, what)

    return {value for scenario in scenarios for value in of(scenario)}


def test_splits_never_share_a_scenario_whatever_their_seeds() -> None:
    for other in (1, 2):
        again = {
            name: draw_split(SplitSpec(split=name, count=COUNT, seed=other))
            for name in ("train", "validation")
        }
        assert not courses(drawn("train")) & courses(again["validation"])
        assert not courses(drawn("validation")) & courses(again["train"])
    assert not courses(drawn("test")) & (courses(drawn("train")) | courses(drawn("validation")))
    assert [len(courses(scenarios)) for scenarios in map(drawn, SPLITS)] == [COUNT] * 3
    assert [len({one.name for one in scenarios}) for scenarios in map(drawn, SPLITS)] == [COUNT] * 3


@pytest.mark.parametrize("what", ["towns", "heights", "weathers", "severities"])
def test_test_is_drawn_from_values_that_train_and_validation_never_have(what: str) -> None:
    one = what if what == "severities" else what.removesuffix("s")
    known = values(drawn("train"), one)
    assert known == values(drawn("validation"), one)
    assert known
    assert values(drawn("test"), one)
    assert not known & values(drawn("test"), one)


def test_every_scenario_of_test_has_a_pair_and_a_profile_that_train_and_validation_never_have() -> None:
    for what in ("pairs", "profiles"):
        known = values(drawn("train"), what) | values(drawn("validation"), what)
        for scenario in drawn("test"):
            assert values((scenario,), what) - known
    # and all others are in train: 55 pairs of 11 faults, less one that cannot be and 18 of test
    assert len(values(drawn("train"), "pairs")) == 55 - 1 - 18
    assert values(drawn("train"), "profiles") == {"step", "ramp"}


def test_every_fault_is_in_every_split_and_faults_heal_stay_and_follow_one_another() -> None:
    for scenarios in map(drawn, SPLITS):
        faults = [fault for scenario in scenarios for fault in scenario.faults]
        assert {fault.name for fault in faults} == {fault.name for fault in sunset.list_faults()}
        assert 0.2 < sum(fault.until is not None for fault in faults) / len(faults) < 0.5
        assert sum(fault.after is not None for fault in faults) > COUNT / 50


def test_a_split_is_the_same_again_and_begins_as_a_larger_one() -> None:
    twice = [draw_split(SplitSpec(split="train", count=50, seed=1, flights=True)) for _ in range(2)]
    assert twice[0] == twice[1] == drawn("train")[:50]
    others = [
        SplitSpec(split="train", count=50, seed=2, flights=True),
        SplitSpec(split="train", count=50, seed=1, flights=True, salt=SALT),
    ]
    for spec in others:
        assert not courses(draw_split(spec)) & courses(twice[0])


def test_every_scenario_of_wild_has_a_fault_that_no_catalogue_lists_and_only_a_salt_draws_the_sealed_ones() -> (
    None
):
    listed = {fault.name for fault in sunset.list_faults()}

    def causes(salt: bytes) -> list[set[str]]:
        scenarios = draw_split(SplitSpec(split="wild", count=200, seed=1, salt=salt))
        return [{fault.name for fault in scenario.faults} - listed for scenario in scenarios]

    in_suite = {fault.name for scenario in load_suite("wild") for fault in scenario.faults}
    assert {len(found) for found in causes(b"") + causes(SALT)} == {1}
    assert set().union(*causes(b"")) == in_suite
    assert len(set().union(*causes(SALT)) - in_suite) == 2
    assert in_suite.isdisjoint(listed)
    assert len(in_suite) >= 8


def test_the_first_scenarios_are_what_they_always_were(tmp_path: Path) -> None:
    # whoever publishes a hash relies on this: a change needs another RULE
    hashes = {
        name: sunset.generate_split(name, 20, tmp_path / name, seed=7, flights=True).sha256[:16]
        for name in SPLITS
    }
    assert hashes == {
        "train": "e733602a493799d0",
        "validation": "3aa83eb4d1a21c49",
        "test": "07e5001401a4c265",
    }


def test_the_hash_is_that_of_the_files_as_other_tools_compute_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "made"
    (salt := tmp_path / "salt").write_bytes(SALT)
    words = ["--split", "test", "--count", "5", "--seed", "3", "--salt-file", str(salt), "--out", str(out)]
    assert main(["scenarios", "generate", *words]) == 0

    files = sorted(out.glob("*.yaml"))
    lines = "".join(f"{hashlib.sha256(file.read_bytes()).hexdigest()}  {file.name}\n" for file in files)
    expected = hashlib.sha256(lines.encode()).hexdigest()
    of_salt = hashlib.sha256(SALT).hexdigest()
    printed = capsys.readouterr()
    assert printed.out == f"scenarios  SHA-256 {expected}\nsalt       SHA-256 {of_salt}\n"
    assert "5 scenarios of test are in" in printed.err
    described = json.loads((out / "split.json").read_text())
    assert (described["sha256"], described["salt_sha256"]) == (expected, of_salt)
    assert SALT.decode().strip() not in (out / "split.json").read_text()
    assert [scenario.name for scenario in load_suite(out)] == [file.stem for file in files]
    assert split_hash(out) == expected
    assert split_hash("paper") == ""

    assert main(["scenarios", "check", str(out), "--salt-file", str(salt)]) == 0
    assert capsys.readouterr().out == printed.out


def test_what_was_changed_is_found(tmp_path: Path) -> None:
    (salt := tmp_path / "salt").write_bytes(SALT)
    (other := tmp_path / "other").write_bytes(SALT[::-1])
    sealed, plain = tmp_path / "sealed", tmp_path / "plain"
    sunset.generate_split("test", 3, sealed, salt_file=salt)
    sunset.generate_split("train", 3, plain)
    for folder, file, sentence in (
        (sealed, None, "made with a salt of the SHA-256 .*, got no salt: name its file"),
        (sealed, other, "made with a salt of the SHA-256 .*, got a salt of .*: name its file"),
        (plain, salt, "made with no salt, got a salt of .*: leave --salt-file out"),
    ):
        with pytest.raises(InvalidInputError, match=sentence):
            sunset.check_split(folder, salt_file=file)

    text = (plain / "split.json").read_text()
    for old, new, sentence in (
        ('"seed": 0', '"seed": 1', r"does not have the scenarios that its split.json makes"),
        ('"count": 3', '"count": 0', "number of scenarios must be a whole number from 1 to 9999, got 0"),
        ('"split": "train"', '"split": "exam"', "There is no split 'exam'"),
        ('"rule": 1', '"rule": 9', "does not have the scenarios that its split.json makes"),
        ('"extensions": {}', '"extensions": {"a.py": "00"}', r"made with other extensions \(a.py\)"),
        ('"sha256": "', '"sha256": "0', "are not those of its split.json"),
        ('"count": 3', '"count": "3"', "must be a whole number, got '3'; generate the split again"),
        ("{", "", "is damaged and cannot be read as JSON"),
    ):
        (plain / "split.json").write_text(text.replace(old, new, 1))
        with pytest.raises(InvalidInputError, match=sentence):
            sunset.check_split(plain)
    (plain / "split.json").write_text(text)
    assert sunset.check_split(plain).count == 3

    (plain / "mine.yaml").write_text("name: mine\nfaults: []\n")
    with pytest.raises(
        ScenarioError, match=r"are not those of its split\.json: generate the split again, or remove"
    ):
        load_suite(plain)
    (plain / "split.json").unlink()
    assert len(load_suite(plain)) == 4
    with pytest.raises(ScenarioError, match=r"There is no split\.json in .*: name a folder that"):
        sunset.check_split(plain)


def test_a_folder_with_other_files_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match="exists already; remove it or name another folder"):
        sunset.generate_split("train", 2, tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["mine.txt"]


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ([], "A scenario is made of faults: name some, or draw scenarios with --split."),
        (
            ["--split", "tests", "--count", "2", "--out", "x"],
            "no split 'tests': did you mean 'test', or choose one of",
        ),
        (["--split", "test", "--out", "x"], "add --count."),
        (["--split", "test", "--count", "2"], "add --out."),
        (["--count", "2", "--out", "x"], "add --split."),
        (["--split", "test", "--count", "10000", "--out", "x"], "a whole number from 1 to 9999, got 10000"),
        (
            ["--split", "test", "--count", "2", "--seed", "-1", "--out", "x"],
            "A seed must be a whole number from 0",
        ),
        (["gpu_failure", "--split", "test"], "leave out the faults and --name, or --split."),
        (["gpu_failure", "--seed", "3"], "leave out the faults and --name, or --seed."),
        (
            ["--split", "test", "--count", "2", "--out", "x", "--salt-file", "no"],
            "The salt no cannot be read: No such",
        ),
        (["--split", "test", "--count", "2", "--out", "x", "--salt-file", "short"], "at least 16 bytes"),
    ],
)
def test_what_makes_no_split_gets_one_sentence(
    words: list[str],
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("short").write_text("secret\n")
    assert main(["scenarios", "generate", *words]) == 2
    printed = capsys.readouterr().err
    assert sentence in printed
    assert len(printed.splitlines()) == 1
    assert [file.name for file in tmp_path.iterdir()] == ["short"]
