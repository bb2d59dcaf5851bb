"""What a run prints of what happened."""

from pathlib import Path

import pytest

from sunset.cli import main

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

    assert main(["run", "autofocus_needed", "--manager", f"{tmp_path / 'hasty.py'}:Hasty"]) == 0

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
    assert main(["run", "nofault", "--manager", "none"]) == 0

    assert "the injection" not in capsys.readouterr().out
