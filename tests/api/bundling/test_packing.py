"""A campaign becomes one file, always the same; what is not fit to be published is not packed."""

import hashlib
import json
import re
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest
import yaml
from tests.api.bundling.conftest import DATE

import sunset
from sunset import ManagingSystem, Symptoms
from sunset.api.bundling import bundle, verify
from sunset.api.bundling.citation import parse_author, references
from sunset.cli import main
from sunset.errors import SunsetError
from sunset.files.sources import package_version

pytestmark = pytest.mark.xdist_group("bundling")

ROOT = Path(__file__).parents[3]
api: Any = sunset  # the mistakes are of types, too


@pytest.mark.thorough
def test_the_same_campaign_and_date_give_the_same_bytes(results: Path, packed: Path, tmp_path: Path) -> None:
    again = bundle(results, tmp_path / "again.zip", date=DATE)
    later = bundle(results, tmp_path / "later.zip", date="2026-03-15")

    assert again.path.read_bytes() == packed.read_bytes()
    assert again.sha256 == hashlib.sha256(packed.read_bytes()).hexdigest() != later.sha256
    assert (again.runs, again.size, again.left_out) == (4, packed.stat().st_size, ())
    assert str(again).startswith(f"{again.path}: 4 runs, 0.")


def test_the_metadata_describe_every_file(packed: Path) -> None:
    with zipfile.ZipFile(packed) as archive:
        sizes = {info.filename: str(info.file_size) for info in archive.infolist()}
        crate = json.loads(archive.read("ro-crate-metadata.json"))
    graph = {entity["@id"]: entity for entity in crate["@graph"]}
    files = {unquote(name): entity for name, entity in graph.items() if entity["@type"] == "File"}
    root = graph["./"]

    assert crate["@context"] == "https://w3id.org/ro/crate/1.1/context"
    assert graph["ro-crate-metadata.json"]["about"] == {"@id": "./"}
    assert graph["ro-crate-metadata.json"]["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert root["datePublished"] == DATE
    assert {unquote(part["@id"]) for part in root["hasPart"]} == files.keys()
    assert files.keys() == sizes.keys() - {"ro-crate-metadata.json", "SHA256SUMS"}
    assert all(entity["contentSize"] == sizes[name] for name, entity in files.items())
    assert graph[root["mentions"]["@id"]]["version"] == package_version()
    assert graph[root["author"][0]["@id"]]["name"] == "anonymous"
    assert root["license"].startswith("No licence is given")


def test_who_made_it_stands_in_the_metadata_and_the_citation(results: Path, tmp_path: Path) -> None:
    ada = "Ada Lovelace 0000-0002-1825-0097"
    bundle(results, tmp_path / "x.zip", date=DATE, title="Rain", authors=[ada, "Bob"], licence="CC-BY-4.0")

    with zipfile.ZipFile(tmp_path / "x.zip") as archive:
        citation = yaml.safe_load(archive.read("CITATION.cff"))
        readme = archive.read("README.md").decode()
        crate = json.loads(archive.read("ro-crate-metadata.json"))
    root = next(entity for entity in crate["@graph"] if entity["@id"] == "./")

    assert citation["authors"] == [
        {"name": "Ada Lovelace", "orcid": "https://orcid.org/0000-0002-1825-0097"},
        {"name": "Bob"},
    ]
    assert (citation["title"], citation["license"], citation["date-released"]) == ("Rain", "CC-BY-4.0", DATE)
    assert "It may be used under CC-BY-4.0." in readme
    assert root["author"] == [{"@id": "https://orcid.org/0000-0002-1825-0097"}, {"@id": "#author-2"}]
    assert root["license"] == {"@id": "https://spdx.org/licenses/CC-BY-4.0"}


def test_what_a_bundle_cites_is_what_the_repository_does() -> None:
    ours = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    software, paper = references()

    assert [paper] == ours["references"]
    assert software == {"type": "software"} | {
        name: ours[name] for name in ("title", "version", "license", "authors")
    }


@pytest.mark.parametrize(
    ("text", "name", "orcid"),
    [
        ("Ada Lovelace", "Ada Lovelace", ""),
        ("Ada Lovelace (0000-0002-1825-0097)", "Ada Lovelace", "097"),
        ("Ada, https://orcid.org/0000-0002-1694-233X", "Ada", "33X"),
    ],
)
def test_authors(text: str, name: str, orcid: str) -> None:
    author = parse_author(text)

    assert author["name"] == name
    assert author.get("orcid", "").endswith(orcid)
    assert ("orcid" in author) == bool(orcid)


def unfinished(results: Path, folder: Path) -> Path:
    shutil.copytree(results, folder / "results")
    shutil.rmtree(next((folder / "results").glob("runs/*/*/*/seed-2")))
    return folder / "results"


def in_parts(results: Path, folder: Path) -> Path:
    for part in ("1", "2"):
        shutil.copytree(results, folder / "parts" / part)
    return folder / "parts"


def edited(results: Path, folder: Path) -> Path:
    shutil.copytree(results, folder / "results")
    for file in (folder / "results").glob("runs/*/*/*/*/run.json"):
        content = json.loads(file.read_text())
        content["metrics"]["t_down_s"] = 0.5
        file.write_text(json.dumps(content))
    return folder / "results"


def of_another_version(results: Path, folder: Path) -> Path:
    shutil.copytree(results, folder / "results")
    plan = folder / "results/bench.json"
    plan.write_text(json.dumps(json.loads(plan.read_text()) | {"plan_version": 9}))
    return folder / "results"


def without_source(results: Path, folder: Path) -> Path:
    shutil.copytree(results, folder / "results")
    plan = folder / "results/bench.json"
    plan.write_text(plan.read_text().replace("mine.py", "gone.py"))
    for file in (folder / "results").glob("runs/*/*/*/*/run.json"):
        file.write_text(file.read_text().replace("mine.py", "gone.py"))
    return folder / "results"


def filled(folder: Path) -> Path:
    (folder / "x.zip").write_text("mine")
    return folder / "x.zip"


Mistake = Callable[[Path, Path], object]

MISTAKES: dict[str, tuple[Mistake, str]] = {
    "no folder": (lambda _, folder: api.bundle(folder / "gone", folder / "x.zip"), "There is no campaign in"),
    "empty folder": (
        lambda _, folder: api.bundle(folder, folder / "x.zip"),
        "since bench.json is missing: name the folder that 'sunset bench --out' wrote",
    ),
    "folder of parts": (
        lambda results, folder: api.bundle(in_parts(results, folder), folder / "x.zip"),
        r"parts has 2 folders of campaigns: .* copy the runs into one folder first \(cp -r .*/2/runs .*/1\)",
    ),
    "folder of one run": (
        lambda results, folder: api.bundle(next(results.glob("runs/*/*/*/*")), folder / "x.zip"),
        "There is no campaign in",
    ),
    "unfinished campaign": (
        lambda results, folder: api.bundle(unfinished(results, folder), folder / "x.zip"),
        "is not finished: 3 of 4 runs are there; the command that began it continues it",
    ),
    "edited campaign": (
        lambda results, folder: api.bundle(edited(results, folder), folder / "x.zip"),
        r"cannot be packed \(and 3 other problems\): runs/own/mine/.*its t_down_s is stored as 0.5",
    ),
    "plan of another version": (
        lambda results, folder: api.bundle(of_another_version(results, folder), folder / "x.zip"),
        "is of version 9, expected 1; read it with the SUNSET that wrote it",
    ),
    "managing system that is gone": (
        lambda results, folder: api.bundle(without_source(results, folder), folder / "x.zip"),
        "The source of the managing system mine is needed: There is no file .*gone.py. Call it in the folder",
    ),
    "file that exists": (
        lambda results, folder: api.bundle(results, filled(folder)),
        "exists already: remove it, or name another one with --out",
    ),
    "no folder to write to": (
        lambda results, folder: api.bundle(results, folder / "gone/x.zip"),
        "cannot be written: No such file or directory",
    ),
    "number as file": (lambda results, _: api.bundle(results, 3), "The bundle must be a path, got 3"),
    "mistyped ORCID": (
        lambda results, folder: api.bundle(results, folder / "x.zip", authors=["Ada 0000-0002-1825-0098"]),
        "The ORCID 0000-0002-1825-0098 of Ada is mistyped",
    ),
    "ORCID without a name": (
        lambda results, folder: api.bundle(results, folder / "x.zip", authors=["0000-0002-1825-0097"]),
        "An author must be a name, with an ORCID behind it",
    ),
    "authors as text": (
        lambda results, folder: api.bundle(results, folder / "x.zip", authors="Ada"),
        "The authors must be a list of names, got 'Ada'",
    ),
    "licence in words": (
        lambda results, folder: api.bundle(results, folder / "x.zip", licence="use it well"),
        "The licence must be a name of SPDX's, such as CC-BY-4.0",
    ),
    "title of two lines": (
        lambda results, folder: api.bundle(results, folder / "x.zip", title="a\nb"),
        "The title must be one line",
    ),
    "date in words": (
        lambda results, folder: api.bundle(results, folder / "x.zip", date="today"),
        "The date must be a day, written as 2026-03-14, got 'today'",
    ),
    "date as number": (
        lambda results, folder: api.bundle(results, folder / "x.zip", date=2026),
        "The date must be a day",
    ),
    "extension too many": (
        lambda results, folder: api.bundle(results, folder / "x.zip", extensions=[darker(folder)]),
        "was made without the extension darker.py: leave it out",
    ),
    "less than no run": (
        lambda _, folder: api.verify(folder / "x.zip", run_again=-1),
        "The number of runs to run again must be at least 0, got -1",
    ),
    "missing bag": (
        lambda _, folder: api.verify(folder / "x.zip", bag=folder / "gone"),
        "There is no bag .*gone: name the campaign's, or leave it out",
    ),
    "unknown model": (lambda _, folder: api.verify(folder / "x.zip", model="lit"), "did you mean 'lite'"),
    "seed below 0": (
        lambda _, folder: api.verify(folder / "x.zip", seed=-1),
        "A seed must be a whole number",
    ),
}


def darker(folder: Path) -> Path:
    text = "from sunset.system import Extension\n\nEXTENSION = Extension()\n"
    (folder / "darker.py").write_text(text)
    return folder / "darker.py"


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_sentence(name: str, results: Path, tmp_path: Path) -> None:
    mistake, expected = MISTAKES[name]

    with pytest.raises(SunsetError, match=expected) as caught:
        mistake(results, tmp_path)

    assert re.fullmatch(r"[^\n]*\.", str(caught.value))
    assert [file.name for file in tmp_path.glob(".*")] == []


def test_the_command_line_says_whether_a_bundle_is_verified(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "x.zip"
    assert main(["bundle", str(results), "--out", str(out), "--date", DATE]) == 0
    assert re.fullmatch(rf"{out}: 4 runs, 0\.\d MB\nSHA-256 [0-9a-f]{{64}}\n", capsys.readouterr().out)

    assert main(["verify", str(out), "--run-again", "1", "--seed", "1"]) == 0
    assert capsys.readouterr().out.endswith("\nVerified.\n")

    with zipfile.ZipFile(out, "a") as archive:
        archive.writestr("more.txt", "")
    assert main(["verify", str(out), "--run-again", "0", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert (told["verified"], told["runs_recomputed"], told["runs_again"]) == (False, 4, [])
    assert told["problems"] == ["more.txt: SHA256SUMS does not list it."]


class Passed(ManagingSystem):
    def adapt(self, symptoms: Symptoms) -> None:
        del symptoms


def test_a_class_that_was_passed_is_packed_with_its_source_and_cannot_be_run_by_others(
    tmp_path: Path,
) -> None:
    sunset.bench(
        "nofault",
        {"own": Passed},
        out=tmp_path / "results",
        references=False,
        score=False,
        repetitions=1,
        duration=2,
        jobs=1,
    )
    told: list[tuple[int, int]] = []
    sunset.bundle(tmp_path / "results", tmp_path / "x.zip", date=DATE, progress=lambda *one: told.append(one))

    found = verify(tmp_path / "x.zip", run_again=3, seed=1, trust=True)

    assert told[-1] == (1, 1)
    verify(tmp_path / "x.zip", run_again=10**30, seed=1, progress=lambda *one: told.append(one))
    assert max(total for _, total in told) == 2
    with zipfile.ZipFile(tmp_path / "x.zip") as archive:
        assert archive.read("managers/own/tests/api/bundling/test_packing.py") == Path(__file__).read_bytes()
    assert (found.passed, found.runs_recomputed, found.runs_again) == (True, 1, ())
    assert found.unchecked == (
        "What the managing system read and did in 1 run, without Landlock, seccomp, namespaces around it.",
        "1 run could not be run again: own was a class of a program or notebook, which only its process can load.",
    )


@pytest.mark.thorough
def test_a_program_is_packed_with_the_files_of_its_command_and_run_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    source = Path(__file__).parents[3] / "docs" / "programs" / "focus.sh"
    Path("mine").mkdir()
    shutil.copy(source, "mine/focus.sh")
    Path("mine/data.txt").write_text("1")
    sunset.bench(
        "nofault",
        "focus=exec:mine/focus.sh 'mine/data.txt' \"a,b\"",
        out="results",
        references=False,
        score=False,
        repetitions=1,
        duration=2,
        jobs=1,
    )
    sunset.bundle("results", "x.zip", date=DATE)
    Path("mine").rename("gone")

    found = verify(Path("x.zip"), run_again=3, seed=1, trust=True)

    assert (found.problems, found.unchecked, len(found.runs_again)) == ((), (), 1)
    with zipfile.ZipFile("x.zip") as archive:
        place = json.loads(archive.read("bundle.json"))["managers"]["focus"]
    assert place["load"] == "exec:managers/focus/focus.sh managers/focus/data.txt a,b"
    assert place["files"] == ["managers/focus/data.txt", "managers/focus/focus.sh"]
