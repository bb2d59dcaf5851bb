import os
import re
import resource
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, unquote_to_bytes

import pytest

import sunset
from sunset.cli import main
from sunset.errors import OutputError, RecordError
from sunset.managing import ManagingSystem, Symptoms

pytestmark = [
    pytest.mark.usefixtures("flight"),
    pytest.mark.xdist_group("site"),  # the campaign that is shown is run once
]


class Broken(ManagingSystem):
    """Raises as soon as it is asked."""

    def adapt(self, symptoms: Symptoms) -> None:
        raise RuntimeError("</table><script>alert(1)</script>")


@pytest.fixture(scope="module")
def campaign(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    assert flight.exists()
    folder = tmp_path_factory.mktemp("site") / "campaign"
    sunset.bench(
        "artifact",
        {"none": "none", "broken": Broken},
        out=folder,
        scenarios=["gpu_failure+image_shift+autofocus_needed"],
        references=False,
        score=False,
        repetitions=1,
        duration=2,
        jobs=1,
    )
    return folder


class _Links(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for name, value in attrs if (tag, name) == ("a", "href")]


def links(page: Path) -> list[str]:
    parser = _Links()
    parser.feed(page.read_text(encoding="utf-8"))
    return parser.links


def test_each_run_is_a_link_away_and_failed_ones_are_named(campaign: Path, tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    first = sunset.write_site(campaign, tmp_path / "a site", progress=lambda *done: seen.append(done))

    text = first.read_text(encoding="utf-8")
    assert len(links(first)) == 2
    for link in links(first):
        page = (first.parent / unquote(link)).read_text(encoding="utf-8")
        assert "gpu_failure+image_shift+autofocus_needed" in page
        assert "<script>alert(1)</script>" not in page
    assert text.count("(managing system failed)") == 1
    assert "<script>alert(1)</script>" not in text
    assert "comparison of managing systems" in text
    assert not re.search(r"""(?:src|href)=["']?(?:https?:)?//""", text)
    assert seen == [(0, 2), (1, 2), (2, 2)]
    assert [path.name for path in tmp_path.iterdir()] == ["a site"]


def test_one_run_and_its_pictures(tmp_path: Path) -> None:
    sunset.run("gpu_failure", duration=2, images=True, out=tmp_path / "run")

    with_pictures = sunset.write_site(tmp_path / "run", tmp_path / "site")
    (tmp_path / "run" / "images.mcap").unlink()
    without = sunset.write_site(tmp_path / "run", tmp_path / "other")

    assert links(with_pictures) == ["run.html"]
    pages = [page.with_name("run.html").read_text(encoding="utf-8") for page in (with_pictures, without)]
    assert len(pages[0]) > len(pages[1]) + 100_000
    assert "The record has no images" in pages[1]


def test_what_cannot_be_written_leaves_nothing(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").touch()
    with pytest.raises(
        OutputError, match=r"The site .*full exists already; remove it or name another folder"
    ):
        sunset.write_site(campaign, tmp_path / "full")
    with pytest.raises(OutputError, match=r"cannot be written: Not a directory"):
        sunset.write_site(campaign, tmp_path / "full" / "mine.txt" / "site")
    with pytest.raises(RecordError, match="There is no folder"):
        sunset.write_site(tmp_path / "nothing", tmp_path / "site")
    assert main(["report", str(campaign), "--site", str(tmp_path / "site"), "--runs"]) == 2
    assert "leave out --format, --json, --runs and --recompute" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["full"]


@pytest.mark.thorough
def test_the_names_of_records_and_of_other_files_do_no_harm(tmp_path: Path) -> None:
    names = ["index", os.fsdecode(b"\xff"), "#1 100%?", "l" * 240]
    for seed, name in enumerate(names):
        sunset.run("nofault", duration=1, seed=seed, out=tmp_path / "results" / name)
    (tmp_path / ".site.partial").mkdir()
    (tmp_path / ".site.partial" / "mine.txt").touch()

    first = sunset.write_site(tmp_path / "results", tmp_path / "site")

    assert "comparison of managing systems" in first.read_text(encoding="utf-8")
    pages = [first.parent / os.fsdecode(unquote_to_bytes(link)) for link in links(first)]
    assert {page.parent.name for page in pages} == set(names)
    assert all('id="data"' in page.read_text(encoding="utf-8") for page in pages)
    assert (tmp_path / ".site.partial" / "mine.txt").exists()
    with pytest.raises(OutputError, match="The site / exists already"):
        sunset.write_site(tmp_path / "results", "/")


def test_a_disk_that_is_full_is_said_of_the_site(campaign: Path, tmp_path: Path) -> None:
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, limits[1]))
    try:
        with pytest.raises(
            OutputError, match=r"^The site .*/site cannot be written: File too large; free some"
        ):
            sunset.write_site(campaign, tmp_path / "site")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert not list(tmp_path.iterdir())
