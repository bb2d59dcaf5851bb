"""Runs that are shown: one with ten faults and everything done about them, and two of the eleventh."""

import json
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest

import sunset

HANDYMAN = '''\
from sunset.managing import ManagingSystem

class Handyman(ManagingSystem):
    """Redeploys what is dead, then tries every modality, then the enhancement."""

    def __init__(self, **options):
        super().__init__(**options)
        self.began = None
        self.steps = [
            (0.0, lambda: self.redeploy("camera")),
            (0.0, lambda: self.redeploy("sensor_fusion")),
            (0.0, lambda: self.redeploy("segmentation")),
            (4.6, lambda: self.set_parameter("sensor_fusion", "modality", 1)),
            (5.2, lambda: self.set_parameter("sensor_fusion", "modality", 2)),
            (5.8, lambda: self.set_parameter("sensor_fusion", "modality", 0)),
            (6.0, lambda: self.activate("image_enhancement")),
            (6.0, lambda: self.set_parameter("sensor_fusion", "topic_camera_input", "rgb_enhanced")),
        ]

    def adapt(self, symptoms):
        now = self.get_clock().now().nanoseconds / 1e9
        if self.began is None and symptoms.stopped("rgb_camera"):
            self.began = now
        while self.began is not None and self.steps and now >= self.began + self.steps[0][0]:
            self.get_logger().info("</script><script>document.title = 'hurt'</script>")
            self.steps.pop(0)[1]()
'''
TEN = (
    "camera_driver_issue+hardware_disconnect+sync_issue+memory_leakage+cuda_out_of_memory+gpu_failure+"
    "image_degradation+image_shift+depth_degradation+autofocus_needed"
)


class Both(NamedTuple):
    """Two runs, the page of both, and the progress that was told while it was made."""

    runs: tuple[sunset.Run, sunset.Run]
    page: Path
    told: list[tuple[str, int, int]]


class Shown(NamedTuple):
    """A run and its page."""

    run: sunset.Run
    page: Path

    @property
    def data(self) -> dict[str, Any]:
        """What the page knows."""
        return data_of(self.page.read_text(encoding="utf-8"))


def data_of(text: str) -> dict[str, Any]:
    """Return the JSON that stands in a page."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    assert found is not None
    data: dict[str, Any] = json.loads(found[1])
    return data


def attributes_of(text: str) -> Any:
    """Return the JSON that stands in a page, whose keys are attributes."""
    return json.loads(json.dumps(data_of(text)), object_hook=lambda content: SimpleNamespace(**content))


@pytest.fixture(scope="session")
def ten(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> Shown:
    """A run of ten faults that keeps its images."""
    assert flight.exists()
    folder = tmp_path_factory.mktemp("ten")
    (folder / "handyman.py").write_text(HANDYMAN, encoding="utf-8")
    run = sunset.run(TEN, f"{folder / 'handyman.py'}:Handyman", out=folder / "run", images=True, duration=8.5)
    return Shown(run, run.view(out=folder / "ten.html", show=False))


@pytest.fixture(scope="session")
def pair(flight: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[sunset.Run, sunset.Run]:
    """Two runs of the eleventh fault, which keep no images."""
    assert flight.exists()
    folder = tmp_path_factory.mktemp("pair")

    def run(manager: str) -> sunset.Run:
        return sunset.run("unneeded_enhancement", manager, out=folder / manager, duration=2)

    return run("none"), run("baseline")


@pytest.fixture(scope="session")
def both(pair: tuple[sunset.Run, sunset.Run], tmp_path_factory: pytest.TempPathFactory) -> Both:
    """The page of the two, for which they are run again."""
    told: list[tuple[str, int, int]] = []
    file = tmp_path_factory.mktemp("both") / "page.html"
    sunset.view(*pair, out=file, show=False, progress=lambda *one: told.append(one))
    return Both(pair, file, told)
