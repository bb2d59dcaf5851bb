"""What a run prints of what happened."""

import re
from collections.abc import Sequence
from pathlib import Path

import pytest
from tests.recording.runs import RUN

from sunset.cli import main
from sunset.metrics import Timeline, score
from sunset.recording.story import Event, print_story

pytestmark = pytest.mark.usefixtures("flight")

HASTY = """\
from sunset.managing import ManagingSystem

class Hasty(ManagingSystem):
    begun = False

    def adapt(self, symptoms):
        now_s = self.get_clock().now().nanoseconds / 1e9
        if not self.begun:
            self.begun, self.first_s = True, now_s
            self.set_parameter("camera", "perform_autofocus", True)
        elif now_s - self.first_s > 6:
            self.activate("image_enhancement")
            self.set_parameter("sensor_fusion", "topic_camera_input", "rgb_enhanced")
"""


def test_what_came_before_the_injection_stands_under_a_heading_of_its_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "hasty.py").write_text(HASTY, encoding="utf-8")

    assert (
        main(["run", "autofocus_needed", "--manager", f"{tmp_path / 'hasty.py'}:Hasty", "--duration", "8"])
        == 0
    )

    told = capsys.readouterr().out
    lines = [" ".join(line.split()) for line in told.splitlines()]
    before, start = lines.index("before the injection"), lines.index("from the injection on")
    early, late = lines[before + 1 : start], lines[start + 1 :]
    assert early
    assert all(line.startswith("-") and " s adaptation " in line for line in early)
    assert late[0].startswith("0.00 s fault autofocus_needed")
    assert "F4 (not injected) segmentation unsure" in told


def test_where_nothing_came_before_the_injection_there_is_no_heading(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["run", "nofault", "--manager", "none", "--duration", "1"]) == 0

    assert "the injection" not in capsys.readouterr().out


CHATTY = """\
from sunset.managing import ManagingSystem

class Chatty(ManagingSystem):
    def adapt(self, symptoms):
        self.get_logger().info("Looking " + "again and " * 20 + "again.")
        self.get_logger().info("Nothing there.")
"""


def test_what_repeats_is_stated_once_and_no_line_is_wrapped_for_a_pipe(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "chatty.py").write_text(CHATTY, encoding="utf-8")

    assert main(["run", "nofault", "--manager", f"{tmp_path / 'chatty.py'}:Chatty", "--duration", "5"]) == 0

    lines = capsys.readouterr().out.splitlines()
    assert all(line == line.rstrip() for line in lines)
    for said in ("Looking " + "again and " * 20 + "again.", "Nothing there."):
        found = [line for line in lines if said in line]
        assert len(found) == 3  # before the injection, from then on, and after the end
        # every 0.2 s until the end
        assert re.search(r"log +.*\. … (24|25) times more until (4\.[89]|5\.0)\d s$", found[1]), found[1]


def printed(events: Sequence[Event], capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Return the lines of a time line with these events."""
    print_story(RUN, events, (), score(Timeline(thresholds=RUN.thresholds)), ())
    return capsys.readouterr().out.splitlines()


def test_a_terminal_shows_a_table_in_colours_and_wrapped(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, value in (("FORCE_COLOR", "1"), ("TERM", "xterm"), ("COLUMNS", "40"), ("LINES", "10")):
        monkeypatch.setenv(name, value)

    lines = printed([(1.0, "fault", "again " * 20)], capsys)

    (first,) = [line for line in lines if "1.00 s" in line]
    assert "\x1b[31mfault\x1b[0m" in first
    assert sum("again" in line for line in lines) > 3


def test_what_happened_between_two_repetitions_is_not_moved(capsys: pytest.CaptureFixture[str]) -> None:
    events = [
        (0.5, "log", "a"),
        (1.0, "log", "b"),
        (1.5, "log", "a"),
        (2.0, "symptom", "F1"),
        (2.5, "log", "a"),
    ]

    lines = [" ".join(line.split()) for line in printed(events, capsys)]

    first = lines.index("0.50 s log a … 1 time more until 1.50 s")
    assert lines[first + 1 : first + 4] == ["1.00 s log b", "2.00 s symptom F1", "2.50 s log a"]


EARLY = """\
from sunset.managing import ManagingSystem

class Early(ManagingSystem):
    done = False

    def adapt(self, symptoms):
        if not self.done:
            self.done = True
            self.deactivate("camera")
"""


def test_a_symptom_that_held_at_the_injection_is_said_to_be_older(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "early.py").write_text(EARLY, encoding="utf-8")

    assert main(["run", "gpu_failure", "--manager", f"{tmp_path / 'early.py'}:Early", "--duration", "4"]) == 0

    symptoms = [line for line in capsys.readouterr().out.splitlines() if " s  symptom  " in line]
    since = [" ".join(line.split()) for line in symptoms if "since before" in line]
    assert since[0] == "0.00 s symptom F1 (ripple) no camera image for 1 s, since before the injection"
    assert len(since) == len(symptoms) == 3  # the fusion and the segmentation likewise
