"""The page in browsers, where they are installed: it shows each moment as it was, and does what is asked of it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest
from tests.viewing.browsers import PROGRAMS, Browser, program_of, started
from tests.viewing.conftest import Both, Shown, attributes_of

from sunset.classes import CLASS_OF_CARLA_ID, COLOURS
from sunset.recording import read_images

pytestmark = [pytest.mark.thorough, pytest.mark.xdist_group("viewing")]

DRAWN = """
const stage = document.getElementById("stage").dataset;
while (!stage.asked || stage.time !== stage.asked) await new Promise(requestAnimationFrame);
"""
"""Wait until the moment that is asked for is drawn."""
PIXELS = """
const canvas = document.querySelector(`[data-panel="${NAME}"] canvas`);
const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
return btoa(String.fromCharCode(...data.filter((_, index) => index % 4 < 3).slice(FROM, FROM + 30000)));
"""


@pytest.fixture(scope="module", params=sorted(PROGRAMS))
def browser(request: pytest.FixtureRequest, ten: Shown) -> Iterator[Browser]:
    if program_of(request.param) is None:
        pytest.skip(f"needs {request.param}, which is not installed")
    with started(request.param) as browser:
        browser.resize(1400, 900)
        browser.open(ten.page.as_uri())
        yield browser


def page_of(ten: Shown) -> Any:
    return attributes_of(ten.page.read_text(encoding="utf-8"))


def go(browser: Browser, time: float) -> None:
    browser.evaluate(f"location.hash = 't={time}'; await new Promise(done => setTimeout(done, 50)); {DRAWN}")


def pixels(browser: Browser, panel: str) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Return what a picture shows (144, 256, 3), red first."""
    size = 144 * 256 * 3
    texts = [
        browser.evaluate(PIXELS.replace("${NAME}", panel).replace("FROM", str(start)))
        for start in range(0, size, 30000)
    ]
    data = b"".join(msgspec.json.decode(f'"{text}"', type=bytes) for text in texts)
    return np.frombuffer(data, np.uint8).reshape(144, 256, 3)


def test_a_moment_of_the_address_is_the_frame_of_that_stamp(browser: Browser, ten: Shown) -> None:
    frames = page_of(ten).runs[0].frames
    images = {(one.topic, str(one.stamp_ns)): one for one in read_images(ten.run.folder)}
    palette = np.zeros((256, 3), np.uint8)
    palette[: len(COLOURS)] = COLOURS
    segmented = ("/managed_subsystem/segmentation", "/managed_subsystem/rgb_camera")
    for place in (3, len(frames.times) - 2):
        stamp = frames.stamps[place]

        go(browser, frames.times[place])

        truth = images["/gt_segmentation", stamp].pixels
        assert np.array_equal(pixels(browser, "truth"), palette[CLASS_OF_CARLA_ID[truth]])
        assert np.array_equal(pixels(browser, "labels"), palette[images[segmented[0], stamp].pixels])
        camera = cv2.cvtColor(images[segmented[1], stamp].pixels, cv2.COLOR_BGR2RGB)
        assert np.abs(pixels(browser, "camera") - camera.astype(np.int16)).mean() < 6
        wrong = pixels(browser, "difference").max(axis=2) == 255
        differs = images[segmented[0], stamp].pixels != CLASS_OF_CARLA_ID[truth]
        assert np.array_equal(wrong, differs & (CLASS_OF_CARLA_ID[truth] != 255))


def test_what_did_not_come_is_seen_as_missing(browser: Browser) -> None:
    script = "return [...document.querySelectorAll('.gone')].map(one => one.dataset.panel)"
    said = "return document.querySelector('[data-panel=labels] .missing').textContent"

    go(browser, -1.0)
    assert browser.evaluate(script) == []
    go(browser, 1.5)
    assert browser.evaluate(script) == ["camera", "given", "labels", "difference"]
    assert browser.evaluate(said) in {"no image for 1.4 s", "no image for 1.5 s"}
    assert "F3 for 1.5 s: the segmentation sends no results" in browser.evaluate(
        "return document.querySelector('.now').textContent"
    )


def test_keys_move_the_moment(browser: Browser, ten: Shown) -> None:
    def press(key: str) -> float:
        browser.evaluate(
            "document.activeElement.dispatchEvent("
            f"new KeyboardEvent('keydown', {{key: '{key}', bubbles: true}}))"
        )
        time: float = browser.evaluate(f"{DRAWN} return Number(stage.time)")
        return time

    page = page_of(ten)
    times = page.runs[0].frames.times
    go(browser, times[10])

    assert press("ArrowRight") == times[11]
    assert press("ArrowLeft") == times[10]
    chosen = "document.getElementById('speed')"
    browser.evaluate(f"{chosen}.focus(); {chosen}.value = '2'; {chosen}.dispatchEvent(new Event('change'))")
    assert press("ArrowRight") == times[11]
    browser.evaluate(f"{chosen}.value = '1'; {chosen}.dispatchEvent(new Event('change'))")
    assert press("End") == page.runs[0].end
    assert press("Home") == page.runs[0].start
    events = sorted({one.time for one in page.runs[0].events if one.kind != "log"})
    assert press("n") == events[0]
    current = browser.evaluate("return document.querySelector('[aria-current] time').textContent")
    assert current == f"{events[0]:.2f} s"
    assert press("n") == events[1]
    assert press("p") == events[0]
    press(" ")
    browser.evaluate(
        f"{DRAWN} while (Number(stage.time) < {events[0] + 0.2}) await new Promise(requestAnimationFrame)"
    )
    assert press(" ") > events[0]
    assert browser.evaluate("return document.querySelectorAll('.playing').length") == 0


@pytest.mark.parametrize("width", [400, 800, 1400])
def test_nothing_is_wider_than_the_window(browser: Browser, width: int) -> None:
    browser.resize(width, 900)

    drawn = "for (let frame = 0; frame < 2; frame++) await new Promise(requestAnimationFrame);"
    assert browser.evaluate(f"{drawn} return document.documentElement.scrollWidth <= innerWidth")
    browser.resize(1400, 900)


def test_the_page_asks_for_nothing_complains_of_nothing_and_runs_nothing_of_others(
    browser: Browser, ten: Shown
) -> None:
    browser.evaluate("document.getElementById('theme').click()")

    assert browser.evaluate("return document.title").endswith(" · SUNSET")
    assert browser.evaluate("return document.scripts.length") == 2
    names = "return [...document.querySelectorAll('.picture canvas')].map(one => one.ariaLabel)"
    assert browser.evaluate(names) == [panel.title for panel in page_of(ten).runs[0].frames.panels]
    assert browser.requests() == []
    assert browser.complaints() == []


def test_two_runs_are_shown_in_step(browser: Browser, both: Both) -> None:
    browser.open(f"{both.page.as_uri()}#t=1.25")
    frames = browser.evaluate(f"{DRAWN} return stage.frames")

    first, second = frames.split(",")
    assert first == second
    assert browser.evaluate(
        "return [...document.querySelectorAll('article h2')].map(one => one.textContent)"
    ) == [
        "A: none",
        "B: baseline",
    ]
    named = "return [...document.querySelectorAll('#lanes .name small, #figures th.of1')].map(one => one.textContent)"
    assert set(browser.evaluate(named)) == {"A: none", "B: baseline"}
    assert browser.complaints() == []


def test_a_gap_of_one_run_stays_open_among_the_moments_of_another(browser: Browser, both: Both) -> None:
    browser.open(both.page.as_uri())
    line = browser.evaluate(
        "const tables = [withGaps([0, 1, 5, 6], [[7, 7, 7, 7]], 2), [[2, 4], [8, 8]]];"
        "return uPlot.join(tables, tables.map(withoutBridges))[1]"
    )
    assert line == [
        7,
        7,
        None,
        None,
        None,
        7,
        7,
    ]  # at 2 s, in the middle of the gap and at 4 s there is nothing


def test_an_address_without_a_moment_and_many_samples_stop_nothing(browser: Browser, ten: Shown) -> None:
    for address in ("t=1.2.3", "t=-", "t=."):
        browser.open("about:blank")
        browser.open(f"{ten.page.as_uri()}#{address}")
        browser.evaluate(DRAWN)
    assert browser.evaluate("return most(1, new Array(1_000_000).fill(2))") == 2


def test_what_holds_to_the_end_is_said_of_the_end(browser: Browser, ten: Shown) -> None:
    view = page_of(ten).runs[0]
    (lasting, *_) = (one.name for one in view.faults if one.spans and one.spans[-1][1] == view.end)

    go(browser, view.end)

    assert lasting in browser.evaluate("return document.querySelector('.now').textContent")


def test_a_link_and_an_event_lead_to_the_very_frame_and_event(browser: Browser, ten: Shown) -> None:
    view = page_of(ten).runs[0]
    link = "return document.getElementById('link').getAttribute('href')"
    places = range(20, len(view.frames.times), 15)
    for place in places:
        go(browser, view.frames.times[place])
        address = browser.evaluate(link)
        go(browser, view.start)
        browser.evaluate(f"location.hash = '{address}'")
        browser.evaluate("await new Promise(done => setTimeout(done, 50))")
        assert browser.evaluate(f"{DRAWN} return stage.frames") == str(place)

    current = "[...document.querySelectorAll('.events li')].findLastIndex(one => one.ariaCurrent)"
    for number, event in enumerate(view.events):
        click = f"document.querySelectorAll('.events a')[{number}].click()"
        time, shown = browser.evaluate(f"{click}; {DRAWN} return [Number(stage.time), {current}]")
        assert time == event.time
        assert shown >= number  # the last of those of the same moment


@pytest.mark.parametrize("width", [400, 1400])
def test_all_that_holds_is_seen(browser: Browser, ten: Shown, width: int) -> None:
    browser.resize(width, 900)
    heights = "const now = document.querySelector('.now'); return [now.scrollHeight, now.clientHeight]"
    for time in (1.5, 5.0, page_of(ten).runs[0].end):
        go(browser, time)
        whole, seen = browser.evaluate(heights)
        assert whole <= seen
    browser.resize(1400, 900)


def test_the_scrubber_lies_above_the_lanes(browser: Browser) -> None:
    edges = browser.evaluate(
        "return ['#scrubber', '#lanes .track'].map(one => document.querySelector(one).getBoundingClientRect())"
        ".flatMap(({left, right}) => [left, right])"
    )
    left, right, first, last = edges
    assert (left + 8, right - 8) == pytest.approx((first, last), abs=1)  # half of the thumb


def test_what_makes_up_for_a_fault_leaves_its_words_legible(browser: Browser) -> None:
    bottom, top = browser.evaluate(
        "const around = document.querySelector('.bar.around'), words = document.createRange();"
        "words.selectNodeContents(around.parentElement.querySelector('.bar.fault'));"
        "return [words.getBoundingClientRect().bottom, around.getBoundingClientRect().top]"
    )
    assert bottom <= top + 1


def test_a_browser_that_does_not_understand_the_script_says_so(
    browser: Browser, ten: Shown, tmp_path: Path
) -> None:
    shown = "return document.body.innerText.includes('a browser of 2023 or newer')"
    assert not browser.evaluate(shown)
    (tmp_path / "old.html").write_text(
        ten.page.read_text(encoding="utf-8").replace("setTheme(", "setTheme (", 1), encoding="utf-8"
    )  # the page's policy does not let this script run, as an old browser cannot
    browser.open((tmp_path / "old.html").as_uri())
    assert browser.evaluate(shown)
    browser.complaints()
    browser.open(ten.page.as_uri())
