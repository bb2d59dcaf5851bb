"""Labels and depths of other conventions: read where they are named."""

from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
import pytest
from rosbags.rosbag2 import StoragePlugin
from tests.data.material import put_pictures, record, rows_of

from sunset.classes import CARLA_IDS, CLASS_OF_CARLA_ID, IGNORED
from sunset.cli import main
from sunset.data import Frame, Reading, read_bag
from sunset.errors import DataError

NEWER: Final = {
    "building": 3, "fence": 5, "other": 22, "pole": 6, "road line": 24, "road": 1, "sidewalk": 2, "vegetation": 9,
    "wall": 4, "traffic sign": 8, "sky": 11, "ground": 25, "bridge": 26, "rail track": 27, "guard rail": 28,
    "traffic light": 7, "static": 20, "dynamic": 21, "water": 23, "terrain": 10, "person": 12, "rider": 13, "car": 14,
    "truck": 15, "bus": 16, "train": 17, "motorcycle": 18, "bicycle": 19,
}  # fmt: skip
"""Class → id, of the documentation of CARLA 0.9.14."""


def as_newer(labels: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    table = np.zeros(256, np.uint8)
    for name, number in CARLA_IDS.items():
        table[number] = NEWER[name]
    return table[labels]


def as_classes(labels: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    return CLASS_OF_CARLA_ID[labels]


@pytest.fixture(scope="module")
def seen(flight: Path) -> list[Frame]:
    with read_bag(flight) as bag:
        return [bag.frame(40 * index) for index in range(10)]


def test_every_class_of_the_newer_ids_and_of_class_indices_is_read() -> None:
    recorded = np.array([list(CARLA_IDS.values())], np.uint8)
    np.testing.assert_array_equal(Reading("carla").labels(as_newer(recorded), "x"), recorded)
    np.testing.assert_array_equal(Reading("classes").labels(as_classes(recorded), "x"), recorded)
    assert CLASS_OF_CARLA_ID[Reading("classes").labels(np.array([[255]], np.uint8), "x")] == IGNORED
    with pytest.raises(
        DataError,
        match=r"image x must hold class indices \(0 to 27; 255 for none\), got 28; say what they are",
    ):
        Reading("classes").labels(np.array([[28]], np.uint8), "x")


def test_millimetres_become_counts_and_unknown_ones_the_largest() -> None:
    millimetres = np.array([[0, 1000, 50_000, 65_535]], np.uint16)
    assert Reading(depth_unit="mm").depth(millimetres).tolist() == [[65_535, 66, 3277, 65_535]]
    assert Reading().depth(millimetres) is millimetres


@pytest.mark.parametrize("source", ["--pictures", "--bag"])
def test_a_recording_of_another_convention_is_imported(
    seen: list[Frame], source: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    frames = [
        Frame(frame.rgb, np.minimum(frame.depth / 0.065535, 65_535).astype(np.uint16), as_newer(frame.labels))
        for frame in seen[:3]
    ]
    place = tmp_path / "recorded"
    if source == "--bag":
        record(place, rows_of(frames), StoragePlugin.MCAP)
    else:
        for number, frame in enumerate(frames):
            put_pictures(place, str(number), frame)
    named = ["--ids", "carla", "--depth-unit", "mm"]

    assert main(["data", "import", source, str(place), *named, "--out", str(tmp_path / "flight")]) == 0

    assert (
        "Labels are read as label ids of CARLA since 0.9.14 (0 to 28; 255 for none), whole numbers of depth as "
        "millimetres." in capsys.readouterr().err
    )
    with read_bag(tmp_path / "flight") as bag:
        for number, frame in enumerate(seen[:3]):
            known = CLASS_OF_CARLA_ID[frame.labels] != IGNORED
            np.testing.assert_array_equal(bag.frame(number).labels[known], frame.labels[known])
            near = frame.depth < 4294  # counts, of 65.5 m
            depth = bag.frame(number).depth.astype(int)
            np.testing.assert_allclose(depth[near], frame.depth[near].astype(int), atol=1)
            assert (depth[frame.depth > 4295] == 65_535).all()
