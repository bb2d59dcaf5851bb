"""The figures as a part of a page and as files: in browsers where they are installed, and without matplotlib."""

import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import cv2
import pytest
from tests.evaluation.test_charts import runs
from tests.evaluation.test_report import Page
from tests.viewing.browsers import PROGRAMS, Browser, program_of, started

import sunset
from sunset.cli import main
from sunset.evaluation import RunRow, format_runs, score_tables
from sunset.evaluation.chart_drawing import looks_of, save_chart
from sunset.evaluation.report_charts import report_charts

UGLY = "my<b>$x_1$ & 中:Mine"
NAMES = ["differences", "scores", "profiles", "cures", "fates", "costs"]
Store = Callable[..., Path]


def campaign() -> list[RunRow]:
    """Return runs of four managing systems, one of which has an ugly name."""
    found = [run for name in ("none", "baseline", "oracle") for run in runs(name)]
    return [*found, *(replace(run, manager=UGLY) for run in runs("baseline"))]


@pytest.fixture(scope="module")
def text() -> str:
    return format_runs(campaign(), "html")


def drawings(text: str) -> dict[str, int]:
    """Return how many panels each figure of a page has."""
    figures = re.findall(r'<figure id="(\w+)">(.*?)</figure>', text, re.DOTALL)
    return {name: content.count('role="img"') for name, content in figures}


def test_a_page_has_every_figure_in_its_own_colours_and_loads_nothing(text: str) -> None:
    page = Page()
    page.feed(text)
    assert page.open == []
    assert drawings(text) == {
        "differences": 1,
        "scores": 1,
        "profiles": 2,
        "cures": 3,
        "fates": 3,
        "costs": 1,
    }
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


def test_names_may_be_long_and_faults_few(tmp_path: Path) -> None:
    named = {"baseline": "very_" * 20 + "long", UGLY: "quite_" * 20 + "long"}
    long = [
        replace(run, manager=named.get(run.manager, run.manager), outcomes=run.outcomes and run.outcomes[:1])
        for run in campaign()
    ]
    assert drawings(format_runs(long, "html"))["fates"] == 3
    found = report_charts(long, score_tables(long))
    for chart in found:
        save_chart(chart, looks_of(found), tmp_path / f"{chart.name}.png")  # what does not fit is warned of


def test_what_cannot_be_drawn_is_said_in_its_place() -> None:
    text = format_runs([replace(run, outcomes=None) for run in runs("baseline", seeds=(1,))], "html")
    assert drawings(text) == {
        "differences": 0,
        "scores": 0,
        "profiles": 2,
        "cures": 0,
        "fates": 0,
        "costs": 1,
    }
    assert "There is nothing to compare" in text
    assert (
        text.count("baseline: 1 of 1 runs are of a version that did not say what became of the faults") == 2
    )


def test_without_matplotlib_a_page_says_so_and_has_the_data(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    text = format_runs(campaign(), "html")
    assert text.count("Figures need matplotlib, which is not installed") == 1
    assert "<svg" not in text
    assert text.count("Data as CSV") == 6


def test_figures_are_written_with_their_data(
    store: Store, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    store("runs/1", seed=1)
    store("runs/2", manager="reactive", seed=1, iou=0.4)
    main(["report", str(tmp_path), "--figures", str(tmp_path / "out")])
    told = capsys.readouterr()
    assert told.out == ""
    assert "5 of 6 figures drawn, and the data of all: " in told.err
    assert "Score by suite and by flight: There is no score" in told.err
    files = {file.name for file in (tmp_path / "out").iterdir()}
    drawn = [name for name in NAMES if name != "scores"]
    assert files == {f"{name}.csv" for name in NAMES} | {
        f"{name}.{form}" for name in drawn for form in ("pdf", "png")
    }
    for name in drawn:
        picture = cv2.imread(str(tmp_path / "out" / f"{name}.png"))
        assert picture is not None
        assert picture.shape[1] in {990, 2100}  # a column or a page of a paper, 300 dots an inch
        assert len(picture.reshape(-1, 3)[::97]) > 0
        assert picture.std() > 5
    sunset.write_figures(tmp_path / "runs", tmp_path / "again")
    for file in sorted((tmp_path / "out").iterdir()):
        assert file.read_bytes() == (tmp_path / "again" / file.name).read_bytes(), file.name


def test_without_matplotlib_the_data_is_written(
    store: Store, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    store("runs/1", seed=1)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    main(["report", str(tmp_path), "--figures", str(tmp_path / "out")])
    assert {file.name for file in (tmp_path / "out").iterdir()} == {f"{name}.csv" for name in NAMES}
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
    [...figure.querySelectorAll(".panels svg")].map(svg => {
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
    assert {name: len(panels) for name, panels in shown.items()} == {
        "differences": 1,
        "scores": 1,
        "profiles": 2,
        "cures": 3,
        "fates": 3,
        "costs": 1,
    }
    for panels in shown.values():
        for left, right, height, strokes in panels:
            assert 0 <= left < right <= inner
            assert right - left > 280
            assert height > 80
            assert strokes > 8
    assert browser.complaints() == []
    assert browser.requests() == []
