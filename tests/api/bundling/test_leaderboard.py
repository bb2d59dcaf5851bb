"""Bundles become rows of a leaderboard; a forged bundle is named with a reason, and the others are listed."""

import hashlib
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from tests.api.bundling.conftest import DATE, IMPORTED, SETTINGS, Forge
from tests.api.bundling.test_verifying import (
    MINE,
    OTHER_SEED,
    WET,
    Edit,
    changed,
    replaced,
    with_messages,
    without_last_clock,
)

import sunset
from sunset.api.bundling import bundle
from sunset.api.leaderboard import Leaderboard
from sunset.cli import main
from sunset.errors import InvalidInputError, RecordError
from sunset.experiments import BenchSpec, bench
from sunset.system import DIAGNOSE

pytestmark = pytest.mark.xdist_group("bundling")

SALT = b"a salt of sixteen bytes"
SPLIT = "scenarios/split"


def listed(*bundles: Path, out: Path, run_again: int = 0, salt_file: Path | None = None) -> Leaderboard:
    return sunset.leaderboard(bundles, out, run_again=run_again, seed=1, salt_file=salt_file)


@pytest.fixture(scope="module")
def salt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("salt") / "salt"
    file.write_bytes(SALT)
    return file


@pytest.fixture(scope="module")
def sealed(flight: Path, salt: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the bundle of a campaign over a sealed split."""
    assert flight.exists()
    folder = tmp_path_factory.mktemp("sealed")
    sunset.generate_split("train", 1, folder / "round", seed=4, salt_file=salt)
    suite = str(folder / "round")
    bench(
        BenchSpec(suite=suite, managers=("none",), references=False, score=False, repetitions=1),
        folder / "results",
        jobs=1,
    )
    return bundle(folder / "results", folder / "sealed.zip", date=DATE).path


def test_each_managing_system_of_a_bundle_has_a_row_and_the_page_loads_nothing(
    packed: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    board = listed(packed, out=tmp_path / "site", run_again=1)

    text = board.page.read_text(encoding="utf-8")
    rows = re.findall(r'<tr><th scope="row">(.*?)</th>(.*?)</tr>', text)
    assert [name for name, _ in rows[:2]] == ["mine", "none"]
    assert all(f"<td>{DATE}</td>" in cells and ">1/4</a>" in cells for _, cells in rows[:2])
    assert (board.listed, board.refused) == (("results",), ())
    assert set(re.findall(r'href="(.*?)"', text)) == {"bundles/results.zip", "bundles/results.txt"}
    assert not re.search(r"<script|<link|src=|url\(|https?:", text)
    copy = board.page.parent / "bundles/results.zip"
    assert copy.read_bytes() == packed.read_bytes()
    result = copy.with_suffix(".txt").read_text(encoding="utf-8")
    assert result.startswith("results.zip: 4 runs")
    assert result.endswith("\nVerified.\n")
    assert IMPORTED not in capfd.readouterr().err


def dropped(folder: Path) -> None:
    shutil.rmtree(folder / MINE)


FORGED: dict[str, tuple[Edit, str]] = {
    "figure": (
        changed(f"{WET}/run.json", metrics__t_down_s=0.5),
        "its t_down_s is stored as 0.5, and the messages give 2",
    ),
    "messages": (with_messages(without_last_clock, digest=False), "gives the digest"),
    "exchanged record": (replaced(WET, OTHER_SEED), "it is the record of seed 2 of wet with none"),
    "dropped run": (dropped, "it has 4 runs, and 3 can be read"),
    "label of the oracle": (
        changed("campaign/bench.json", managers=["none", "oracle=mine.py:Mine"]),
        "The label 'oracle' is the name of a managing system that comes with SUNSET",
    ),
    "plan": (lambda folder: (folder / "campaign/bench.json").unlink(), "cannot be verified"),
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_bundle_is_named_and_the_others_are_listed(
    name: str, packed: Path, forge: Forge, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edit, reason = FORGED[name]
    forged = forge(packed, edit)

    code = main(
        ["leaderboard", str(forged), str(packed), "--out", str(tmp_path / "site"), "--run-again", "0"]
    )

    (sentence, _) = capsys.readouterr().out.splitlines()
    assert sentence.startswith("forged is refused: ")
    assert reason in sentence
    assert str(tmp_path) not in sentence.replace(str(forged), "")
    text = (tmp_path / "site/index.html").read_text(encoding="utf-8")
    assert "<li>forged is refused: " in text
    assert ">mine</th>" in text
    assert sorted(file.name for file in (tmp_path / "site/bundles").iterdir()) == [
        "results.txt",
        "results.zip",
    ]
    assert code == 1


def test_a_run_that_never_happened_is_found_by_running_it_again(
    packed: Path, forge: Forge, tmp_path: Path
) -> None:
    forged = forge(packed, with_messages(without_last_clock, digest=True))

    board = listed(forged, out=tmp_path / "site", run_again=99)

    assert "was run again, and left other messages" in board.refused[0]
    assert board.listed == ()


def test_a_campaign_that_only_diagnoses_is_refused(results: Path, tmp_path: Path) -> None:
    spec = BenchSpec(
        suite=str(results.with_name("rain")),
        managers=("none",),
        references=False,
        score=False,
        repetitions=1,
        settings=replace(SETTINGS, task=DIAGNOSE),
    )
    bench(spec, tmp_path / "results", jobs=1)
    diagnosis = bundle(tmp_path / "results", tmp_path / "diagnosis.zip").path

    board = listed(diagnosis, out=tmp_path / "site")

    assert board.listed == ()
    assert "repairs, and a leaderboard ranks repairs." in board.refused[0]


def test_bundles_of_one_name_are_told_apart(packed: Path, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    other = shutil.copyfile(packed, tmp_path / "other/results.zip")

    assert listed(packed, other, out=tmp_path / "site").listed == ("results", "results-2")


def test_a_sealed_split_is_drawn_again_from_its_published_salt(
    sealed: Path, salt: Path, tmp_path: Path
) -> None:
    described = hashlib.sha256(SALT).hexdigest()

    before = listed(sealed, out=tmp_path / "before").page.read_text(encoding="utf-8")
    after = listed(sealed, out=tmp_path / "after", salt_file=salt).page.read_text(encoding="utf-8")

    assert re.search(r"; split: SHA-256 [0-9a-f]{64}\.", before)
    assert described not in before
    assert f"All scenarios were drawn again from a salt: SHA-256 {described}." in after


def test_a_split_that_the_salt_does_not_make_is_refused(
    packed: Path, sealed: Path, forge: Forge, salt: Path, tmp_path: Path
) -> None:
    def edit(folder: Path) -> None:
        shutil.rmtree(folder / SPLIT)
        sunset.generate_split("train", 1, folder / SPLIT, seed=5)

    board = listed(packed, forge(sealed, edit), sealed, out=tmp_path / "site", salt_file=salt)

    assert board.listed == ("sealed",)
    without, other = board.refused
    assert without.startswith("results is refused: There is no split.json in scenarios/split: ")
    assert "was made with no salt, got a salt of the SHA-256" in other


def test_bad_input_leaves_nothing(packed: Path, tmp_path: Path) -> None:
    (tmp_path / "notes.zip").write_text("notes")
    out = tmp_path / "site"

    assert main(["leaderboard", str(tmp_path / "notes.zip"), "--out", str(tmp_path / "none")]) == 1
    with pytest.raises(RecordError, match=r"There is no bundle .*gone\.zip: name files that"):
        listed(packed, tmp_path / "gone.zip", out=out)
    with pytest.raises(InvalidInputError, match="must be at least 0, got -1"):
        listed(packed, out=out, run_again=-1)
    with pytest.raises(InvalidInputError, match="must be a list of files, got "):
        sunset.leaderboard(str(packed), out)
    assert main(["leaderboard", str(tmp_path / "gone.zip"), "--out", str(out)]) == 2
    assert not out.exists()
