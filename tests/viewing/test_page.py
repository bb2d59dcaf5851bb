"""The page as a file: what it may not do, how large it is, and what is said of what cannot be shown."""

import pickle
import re
from collections.abc import Callable
from dataclasses import replace
from html import unescape
from pathlib import Path

import cv2
import msgspec
import numpy as np
import pytest
from tests.viewing.conftest import Both, Shown, attributes_of, data_of
from tests.viewing.unpacking import unpack

import sunset
from sunset.errors import OutputError, RecordError
from sunset.recording import StoredImage
from sunset.viewing import Viewed, page_text
from sunset.viewing.pictures import Source, make_pictures
from sunset.viewing.words import compared

pytestmark = pytest.mark.xdist_group("viewing")  # the runs that are shown are made once

Pair = tuple[sunset.Run, sunset.Run]


def test_a_page_loads_nothing_and_lets_nothing_be_loaded(ten: Shown) -> None:
    text = ten.page.read_text(encoding="utf-8")
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    data = re.search(r'id="data">.*?</script>', text, re.DOTALL)
    assert data is not None

    assert policy.startswith("default-src 'none'; img-src data:; ")
    assert "unsafe" not in policy
    assert re.findall(r"""(?:src|href)=["']?(?!#|data:)[^\s"'>]+""", text.replace(data[0], "")) == []
    assert len(text.encode()) <= 5_000_000


def test_a_page_opens_while_all_is_well_a_second_before_the_first_fault(ten: Shown, both: Both) -> None:
    came = ten.run.timeline.injections[0].time

    assert ten.data["opening"] == pytest.approx(max(came - 1.0, ten.data["runs"][0]["start"]))
    shown = data_of(both.page.read_text(encoding="utf-8"))
    faults = [since for run in shown["runs"] for fault in run["faults"] for since, _ in fault["spans"]]
    assert shown["opening"] < min(faults)


def test_what_others_wrote_stays_text(ten: Shown) -> None:
    text = ten.page.read_text(encoding="utf-8")

    assert text.count("<script") == text.count("</script>") == 2  # the data, and the page's own
    assert "</script><script>document.title = 'hurt'</script>" in str(ten.data["runs"][0]["log"])


def test_names_of_managers_and_scenarios_stay_text(pair: Pair) -> None:
    name = "<script>alert(1)</script><!--"
    record = msgspec.structs.replace(pair[0].record, manager=name, scenario=name)

    text = page_text([Viewed(replace(pair[0], record=record), None)])

    assert text.count("<script") == text.count("</script>") == 2
    assert "<!--" not in text
    assert data_of(text)["title"] == data_of(text)["runs"][0]["manager"] == name
    assert "<title>&lt;script&gt;alert(1)" in text


@pytest.mark.thorough
def test_the_same_run_gives_the_same_page(ten: Shown, tmp_path: Path) -> None:
    again = sunset.view(ten.run.folder, out=tmp_path / "again.html", show=False)

    assert again.read_bytes() == ten.page.read_bytes()


def test_the_images_of_a_run_without_any_are_made_by_its_commands_and_two_share_their_pictures(
    both: Both,
) -> None:
    page = attributes_of(both.page.read_text(encoding="utf-8"))
    truths = [{panel.name: panel.pictures for panel in run.frames.panels}["truth"] for run in page.runs]
    assert truths[0] == truths[1]
    assert min(truths[0]) >= 0
    assert len(page.pictures.data) == len(set(page.pictures.data))
    assert page.comparison[0] == "The same faults, flight and seed, managed by A (none) and by B (baseline)."
    assert {what for what, _, _ in both.told} == {"Playing back", "Making pictures"}
    assert all(0 <= done <= total for _, done, total in both.told)


@pytest.mark.thorough
@pytest.mark.parametrize("pickled", [False, True])
def test_a_run_that_was_not_kept_is_shown_too(pickled: bool, flight: Path, tmp_path: Path) -> None:
    assert flight.exists()
    run = sunset.run("gpu_failure", "baseline", duration=2)
    assert not run.folder.exists()
    run = pickle.loads(pickle.dumps(run)) if pickled else run  # noqa: S301  its own

    html = run._repr_html_()
    page = run.view(out=tmp_path / "page.html", show=False)

    assert html is not None
    assert html.startswith("<iframe srcdoc=")
    assert len(html) < 300_000
    shown = data_of(unescape(html))
    seen = data_of(page.read_text(encoding="utf-8"))
    assert shown["pictures"]["data"] == []
    assert len(seen["pictures"]["data"]) > 100
    assert shown["runs"][0]["faults"] == seen["runs"][0]["faults"]
    assert shown["runs"][0]["nodes"] == seen["runs"][0]["nodes"]


def test_a_run_whose_record_is_gone_shows_as_text(pair: Pair, tmp_path: Path) -> None:
    run = replace(pair[0], folder=tmp_path / "gone")

    assert run._repr_html_() is None
    with pytest.raises(RecordError, match="is not a complete record"):
        run.view(out=tmp_path / "page.html", show=False)


@pytest.mark.thorough
def test_a_run_with_images_shows_them_in_a_notebook(ten: Shown) -> None:
    html = ten.run._repr_html_()

    assert html is not None
    assert len(html) > 500_000


def test_a_run_of_an_extension_that_is_not_there_shows_as_text(pair: Pair) -> None:
    run = pair[0]
    record = msgspec.structs.replace(run.record, extensions={"rain": "0" * 64})

    assert replace(run, record=record)._repr_html_() is None


@pytest.mark.thorough
def test_large_images_are_made_smaller_until_they_fit_and_the_page_says_so() -> None:
    generator = np.random.default_rng(1)
    noise = generator.integers(0, 256, (360, 640, 3), dtype=np.uint8)
    labels = np.repeat(np.arange(28, dtype=np.uint8), 360 * 640 // 28 + 1)[: 360 * 640].reshape(360, 640)

    def images() -> list[StoredImage]:
        return [
            _stored(topic, number, encoding, np.roll(pixels, number, axis=0))
            for number in range(30)
            for topic, encoding, pixels in (
                ("/managed_subsystem/rgb_camera", "bgr8", noise),
                ("/managed_subsystem/segmentation", "8UC1", labels),
            )
        ]

    budget = 400_000
    pictures, (placed,) = make_pictures([Source(images, 30, lambda _: True)], budget)

    assert sum(len(text) * 3 // 4 for text in pictures.data) <= budget * 1.01
    assert len(placed) == 60
    assert f"from 640 × 360 to {pictures.width} × {pictures.height} pixels" in pictures.note or (
        pictures.width == 640 and "Labels and truth are exact" in pictures.note
    )
    data = msgspec.json.decode(f'"{pictures.data[placed[1].place]}"', type=bytes)
    shown = unpack(data, pictures.height, pictures.width)
    assert set(np.unique(shown)) <= set(range(28))


def test_images_that_no_size_makes_fit_are_refused() -> None:
    images = [_stored("/a", number, "8UC1", np.full((2, 2), number, np.uint8)) for number in range(20)]

    with pytest.raises(RecordError, match="The images of 20 frames have no room in a page"):
        make_pictures([Source(lambda: images, 20, lambda _: True)], 20)


def _stored(topic: str, number: int, encoding: str, pixels: np.ndarray) -> StoredImage:
    png = cv2.imencode(".png", pixels)[1].tobytes()
    return StoredImage(topic, number * 10**8, number * 10**8, encoding, png)


def _other_seed(pair: Pair) -> object:
    record = msgspec.structs.replace(pair[1].record, seed=2)
    return sunset.view(pair[0], replace(pair[1], record=record), show=False)


def _other_scenario(pair: Pair) -> object:
    record = msgspec.structs.replace(pair[1].record, scenario="rain")
    return sunset.view(pair[0], replace(pair[1], record=record), show=False)


def _another_file(pair: Pair) -> object:
    file = pair[0].folder.parent / "mine.html"
    file.write_text("<p>mine</p>", encoding="utf-8")
    return pair[0].view(out=file, show=False)


def _folder(pair: Pair) -> object:
    return pair[0].view(out=pair[0].folder.parent, show=False)


def _below_a_file(pair: Pair) -> object:
    return pair[0].view(out=pair[0].folder / "run.json" / "page.html", show=False)


MISTAKES: dict[str, tuple[Callable[[Pair], object], type[Exception], str]] = {
    "another seed": (_other_seed, RecordError, "if their seed is the same, got 1 and 2"),
    "another scenario": (_other_scenario, RecordError, "their scenario is the same, got unneeded_enh"),
    "another file": (_another_file, OutputError, "exists, and is not a page of 'sunset view': name another"),
    "a folder": (_folder, OutputError, "which is a folder: name a file in it"),
    "below a file": (_below_a_file, OutputError, "cannot be written: "),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_cannot_be_shown_or_written_is_said_in_a_sentence(pair: Pair, mistake: str) -> None:
    make, error, words = MISTAKES[mistake]

    with pytest.raises(error, match=re.escape(words)):
        make(pair)


def test_a_page_is_written_over(pair: Pair, tmp_path: Path) -> None:
    file = tmp_path / "new" / "page.html"

    assert pair[0].view(out=file, show=False) == file
    first = file.read_bytes()
    pair[0].view(out=file, show=False)

    assert file.read_bytes() == first
    assert [path.name for path in file.parent.iterdir()] == ["page.html"]


def test_a_page_says_why_it_has_no_pictures(pair: Pair) -> None:
    text = page_text([Viewed(pair[0], None, "No pictures.")])

    assert data_of(text)["runs"][0]["remark"] == "No pictures."


def test_runs_thresholds_and_events_have_colours_of_their_own(ten: Shown) -> None:
    text = ten.page.read_text(encoding="utf-8")
    themes = re.findall(r':root(?:\[data-theme="dark"\])? \{(.*?)\}', text, re.DOTALL)
    assert len(themes) == 2
    for theme in themes:
        colours = dict(re.findall(r"--(\w+): (#\w+);", theme))
        named = ("line0", "line1", "threshold", "fault", "symptom", "adaptation", "cured")
        assert len({colours[name] for name in named}) == len(named)


def test_different_numbers_of_failures_are_explained(ten: Shown, pair: Pair) -> None:
    reason = "since one failure may hide or bring about another"

    assert reason in compared(ten.run, pair[0])[-1]
    assert not any(reason in sentence for sentence in compared(pair[0], pair[0]))
