"""The figures as a part of a page and as files: in browsers where they are installed, and without matplotlib."""

import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import pytest
from tests.evaluation.test_report import Page
from tests.evaluation.test_report_figures import runs
from tests.viewing.browsers import PROGRAMS, Browser, program_of, started

import sunset
from sunset.cli import main
from sunset.evaluation.report import format_runs
from sunset.evaluation.results import RunRow

UGLY = "my<b>$x_1$ & 中:Mine"
NAMES = ["scores", "differences", "fates", "uncured"]
Store = Callable[..., Path]


def campaign() -> list[RunRow]:
    """Return runs of four managing systems, one of which has an ugly name."""
    found = [run for name in ("none", "baseline", "oracle") for run in runs(name)]
    return [*found, *(replace(run, manager=UGLY) for run in runs("baseline"))]


@pytest.fixture(scope="module")
def text() -> str:
    return format_runs(campaign(), "html")


def drawings(text: str) -> dict[str, int]:
    """Return how many pictures each figure of a page has."""
    figures = re.findall(r'<figure id="(\w+)">(.*?)</figure>', text, re.DOTALL)
    return {name: content.count('role="img"') for name, content in figures}


def test_a_page_has_every_figure_in_its_own_colours_and_loads_nothing(text: str) -> None:
    page = Page()
    page.feed(text)
    assert page.open == []
    assert drawings(text) == dict.fromkeys(NAMES, 1)
    assert "my&lt;b&gt;$x_1$ &amp; 中:Mine" in text
    assert "currentColor" in text
    assert not {"#1b1b1b", "#666666", "#cccccc"} & set(re.findall(r"(?:fill|stroke): (#\w{6})", text))
    ids = re.findall(r' id="([^"]+)"', text)
    assert len(ids) == len(set(ids))


def test_print_keeps_a_figure_with_its_caption_on_one_page(text: str) -> None:
    printed = text.partition("@media print {")[2].partition("</style>")[0]
    (kept,) = re.findall(r"(\S[^{}]*) \{ break-inside: avoid; \}", printed)
    assert "figure" in kept.split(", ")


def test_the_same_runs_give_the_same_page(text: str) -> None:
    assert format_runs(campaign(), "html") == text


def test_without_matplotlib_a_page_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    text = format_runs(campaign(), "html")
    assert text.count("Figures need matplotlib, which is not installed") == 1
    assert "<svg" not in text


def test_figures_are_written_with_their_data(
    store: Store, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store("runs/1", seed=1)
    store("runs/2", manager="reactive", seed=1, iou=0.4)
    main(["report", str(tmp_path), "--figures", str(tmp_path / "out")])
    told = capsys.readouterr()
    assert told.out == ""
    assert "3 of 4 figures drawn, and the data of all: " in told.err
    assert "Score by suite and by flight: A score needs" in told.err
    files = {file.name for file in (tmp_path / "out").iterdir()}
    drawn = [name for name in NAMES if name != "scores"]
    assert files == {"captions.txt"} | {f"{name}.csv" for name in NAMES} | {
        f"{name}.{form}" for name in drawn for form in ("pdf", "svg", "png")
    }
    for name in drawn:
        picture = cv2.imread(str(tmp_path / "out" / f"{name}.png"))
        assert picture is not None
        assert picture.shape[1] in {1050, 2100}  # a column or a page of a paper, 300 dots an inch
        assert picture.std() > 5
    sunset.write_figures(tmp_path / "runs", tmp_path / "again")
    for file in sorted((tmp_path / "out").iterdir()):
        assert file.read_bytes() == (tmp_path / "again" / file.name).read_bytes(), file.name


def test_without_matplotlib_no_figures_are_written(
    store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    store("runs/1", seed=1)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert main(["report", str(tmp_path), "--figures", str(tmp_path / "out")]) == 2
    assert not (tmp_path / "out").exists()
    assert "Figures need matplotlib" in capsys.readouterr().err


@pytest.mark.parametrize("option", [["--json"], ["--runs"], ["--site", "x"]])
def test_figures_have_no_other_format(
    store: Store, tmp_path: Path, option: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    store("runs/1", seed=1)
    assert main(["report", str(tmp_path), "--figures", str(tmp_path / "out"), *option]) == 2
    assert "Figures have formats of their own: leave out" in capsys.readouterr().err


SVG = """
return [...document.querySelectorAll("figure")].map(figure => [figure.id,
    [...figure.querySelectorAll("svg")].map(svg => {
        const box = svg.getBoundingClientRect();
        return [box.left, box.right, box.height, svg.querySelectorAll("path, use").length];
    })]);
"""


@pytest.fixture(scope="module", params=sorted(PROGRAMS))
def browser(
    request: pytest.FixtureRequest, text: str, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Browser]:
    if program_of(request.param) is None:
        pytest.skip(f"needs {request.param}, which is not installed")
    page = tmp_path_factory.mktemp("page") / "report.html"
    page.write_text(text, encoding="utf-8")
    with started(request.param) as browser:
        browser.resize(1000, 900)
        browser.open(page.as_uri())
        yield browser


@pytest.mark.thorough
@pytest.mark.xdist_group("viewing")
@pytest.mark.parametrize("width", [1000, 400])
def test_every_figure_is_drawn_within_the_width_of_a_window(browser: Browser, width: int) -> None:
    browser.resize(width, 900)
    shown = dict(browser.evaluate(SVG))
    inner, page = browser.evaluate("return [innerWidth, document.documentElement.scrollWidth]")
    assert page <= inner
    assert {name: len(pictures) for name, pictures in shown.items()} == dict.fromkeys(NAMES, 1)
    for ((left, right, height, strokes),) in shown.values():
        assert 0 <= left < inner  # a picture that is wider than the window is scrolled by itself
        assert right - left > 280
        assert height > 80
        assert strokes > 8
    assert browser.complaints() == []
    assert browser.requests() == []
