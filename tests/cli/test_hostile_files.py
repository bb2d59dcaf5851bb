"""Pipes and devices in the place of files neither block nor end in a traceback."""

import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from sunset.perception import load_model

pytestmark = pytest.mark.thorough

Complaint = Callable[[Sequence[str]], str]


@pytest.fixture(params=["a pipe", "a device"])
def trap(request: pytest.FixtureRequest) -> Callable[[Path], Path]:
    """Put what never ends in the place of a file."""

    def put(path: Path) -> Path:
        path.unlink(missing_ok=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        if request.param == "a pipe":
            os.mkfifo(path)
        else:
            path.symlink_to("/dev/zero")
        return path

    return put


PLACES: dict[str, Sequence[str]] = {
    "mine.yaml": ["scenarios", "show", "mine.yaml"],
    "suite/mine.yaml": ["scenarios", "list", "--suite", "suite"],
    "flight.mcap": ["data", "info", "flight.mcap"],
    "flight.db3": ["data", "info", "flight.db3"],
    "flight/metadata.yaml": ["data", "info", "flight"],
    "results/run.json": ["report", "results"],
    "model/card.json": ["models", "show", "model"],
    "model/rgb.onnx": ["models", "show", "model"],
    "model/rgb.bin": ["models", "show", "model"],
}


@pytest.mark.parametrize("place", PLACES)
def test_what_never_ends_is_refused_in_the_place_of(
    place: str, trap: Callable[[Path], Path], tmp_path: Path, complaint: Complaint
) -> None:
    if place.startswith("model"):
        shutil.copytree(load_model("lite").folder, tmp_path / "model")
    trap(tmp_path / place)

    sentence = complaint(PLACES[place])

    assert place.rpartition("/")[2] in sentence
    assert "not a regular file" in sentence
