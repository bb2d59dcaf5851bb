"""What a user brings can be run on: folders of SynDrone, recordings of ROS 2 tools."""

import json
import os
from collections.abc import Iterator
from dataclasses import astuple
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from rosbags.rosbag2 import CompressionMode, StoragePlugin
from tests.data.material import (
    FLIGHT,
    Rows,
    image_message,
    make_frames,
    picture_file,
    put_frame,
    record,
    rows_of,
)

from sunset.cli import main
from sunset.data import Frame, read_bag

FLOWN = 100
"""Frames of an experiment of four seconds, with its warm-up."""


@pytest.fixture(scope="module")
def seen(flight: Path) -> list[Frame]:
    """Five frames of the default flight."""
    with read_bag(flight) as bag:
        return [bag.frame(80 * index) for index in range(5)]


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert main([*arguments, "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def enlarged(frame: Frame, name: str) -> npt.NDArray[Any]:
    """Return one of a frame's images in SynDrone's size."""
    images: dict[str, npt.NDArray[Any]] = {"rgb": frame.rgb, "depth": frame.depth, "semantic": frame.labels}
    how = cv2.INTER_LINEAR if name == "rgb" else cv2.INTER_NEAREST
    return np.asarray(cv2.resize(images[name], (1920, 1080), interpolation=how))


@pytest.mark.thorough
def test_a_flight_of_syndrone_is_imported_and_played(
    seen: list[Frame], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "syndrone" / FLIGHT
    for name, suffix in (("rgb", ".jpg"), ("depth", ".png"), ("semantic", ".png")):
        (folder / name).mkdir(parents=True)
        for number, frame in enumerate(seen):
            image = enlarged(frame, name)
            (folder / name / f"{number:05}{suffix}").write_bytes(picture_file(image, suffix))
        for number in range(len(seen), FLOWN):
            os.link(folder / name / f"{number % 5:05}{suffix}", folder / name / f"{number:05}{suffix}")
    bag = tmp_path / "flight.mcap"
    place = ["--syndrone", str(tmp_path / "syndrone"), "--town", "1", "--height", "50"]

    assert main(["data", "import", *place, "--out", str(bag)]) == 0

    capsys.readouterr()
    told = printed(capsys, "run", "nofault", "--manager", "none", "--duration", "4", "--bag", str(bag))
    assert told["valid"]
    assert told["metrics"]["availability"] == 1.0
    # what was seen is what the model knows: had the three images come apart, it would know nothing
    assert told["metrics"]["iou"] > 0.3


def converted(frames: list[Frame]) -> Iterator[tuple[str, int, Any]]:
    """Yield messages as a camera's drivers publish them, from some moment of this century on."""
    for number in range(FLOWN + 5):
        frame = Frame(*(np.repeat(np.repeat(image, 2, 0), 2, 1) for image in astuple(frames[number % 5])))
        stamp = 1_760_000_000_000_000_000 + number * 100_000_000
        metres = (frame.depth / 65.535).astype(np.float32)
        metres[frame.depth == 65535] = np.nan
        yield "/rgb_raw", stamp, image_message(np.ascontiguousarray(frame.rgb[..., ::-1]), "rgb8", stamp)
        yield "/depth_raw", stamp + 9, image_message(metres, "32FC1", stamp + 8_000_000)
        # the labels of some frames are lost
        if number % 50 != 49:
            yield "/gt_segmentation", stamp + 5, image_message(frame.labels, "mono8", stamp)


@pytest.mark.thorough
def test_a_recording_of_other_encodings_and_size_is_played(
    seen: list[Frame], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows: Rows = list(converted(seen))
    record(tmp_path / "bag", rows, StoragePlugin.SQLITE3, CompressionMode.MESSAGE)

    told = printed(
        capsys, "run", "nofault", "--manager", "none", "--duration", "4", "--bag", str(tmp_path / "bag")
    )

    assert told["valid"]
    assert told["metrics"]["availability"] == 1.0
    assert told["metrics"]["iou"] > 0.3


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """SynDrone's folders with three frames."""
    root = tmp_path_factory.mktemp("folders")
    for number in range(3):
        put_frame(root / FLIGHT, number)
    return root


def test_the_number_of_jobs_changes_no_byte(folders: Path, tmp_path: Path) -> None:
    made = set()
    for jobs in ("1", "3"):
        out = tmp_path / jobs / "flight.mcap"
        arguments = ["--syndrone", str(folders), "--jobs", jobs, "--out", str(out)]
        assert main(["data", "import", *arguments]) == 0
        made.add(out.read_bytes())
    assert len(made) == 1


@pytest.mark.parametrize(("rate", "period_ns"), [([], 10**8), (["--rate", "25"], 4 * 10**7)])
def test_frames_are_a_tenth_of_a_second_apart_or_as_asked(
    rate: list[str], period_ns: int, folders: Path, tmp_path: Path
) -> None:
    out = tmp_path / "flight"
    assert main(["data", "import", "--syndrone", str(folders), "--out", str(out), *rate]) == 0
    with read_bag(out) as bag:
        assert bag.stamps_ns == (period_ns, 2 * period_ns, 3 * period_ns)


def test_a_folder_of_pictures_is_imported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    frames = make_frames(3, (90, 160))
    for number, frame in enumerate(frames):
        for name, image in (("rgb", frame.rgb), ("depth", frame.depth), ("labels", frame.labels)):
            (tmp_path / "mine" / name).mkdir(parents=True, exist_ok=True)
            (tmp_path / "mine" / name / f"{number}.png").write_bytes(picture_file(image, ".png"))
    place = ["--pictures", str(tmp_path / "mine"), "--frames", "1:2", "--rate", "20", "--size", "160x90"]

    assert main(["data", "import", *place, "--out", str(tmp_path / "flight.mcap")]) == 0

    assert "The flight of 2 frames is in" in capsys.readouterr().err
    with read_bag(tmp_path / "flight.mcap") as bag:
        assert bag.stamps_ns == (5 * 10**7, 10**8)
        for number, frame in enumerate(frames[1:]):
            for ours, theirs in zip(astuple(bag.frame(number)), astuple(frame), strict=True):
                np.testing.assert_array_equal(ours, theirs)


def test_another_bag_is_imported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    frames = make_frames(4, (90, 160))
    stamps = [10**9, 2 * 10**9, 3 * 10**9, 4 * 10**9]
    source = record(tmp_path / "bag", rows_of(frames, stamps), StoragePlugin.SQLITE3)
    arguments = ["--bag", str(source), "--size", "32x18", "--frames", "1:2", "--out", str(tmp_path / "out")]

    assert main(["data", "import", *arguments]) == 0

    assert "The flight of 2 frames is in" in capsys.readouterr().err
    with read_bag(tmp_path / "out") as bag:
        assert bag.stamps_ns == (2 * 10**9, 3 * 10**9)
        np.testing.assert_array_equal(bag.frame(0).labels, frames[1].labels[2::5, 2::5])


def test_info_tells_what_a_bag_holds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    frames = make_frames(3, (4, 8))
    for frame in frames:
        frame.labels[:] = [[7] * 8, [7] * 8, [9] * 8, [0] * 8]
        frame.depth[:] = 32768
        frame.depth[0, 0] = 65535
    rows = rows_of(frames, [0, 10**9, 2 * 10**9])
    folder = record(tmp_path / "bag", [*rows, ("/other", 7, rows[0][2])])

    found = printed(capsys, "data", "info", str(folder))

    assert (found["frames"], found["width"], found["height"]) == (3, 8, 4)
    assert (found["seconds"], found["rate_hz"]) == (2.0, 1.0)
    assert found["classes"] == {"road": 0.5, "vegetation": 0.25}
    assert found["ignored"] == 0.25
    assert found["depth_m"] == pytest.approx([500, 500], abs=0.02)
    assert found["depth_far"] == 1 / 32
    assert found["encodings"] == {"/rgb_raw": "bgr8", "/depth_raw": "16UC1", "/gt_segmentation": "8UC1"}
    assert found["topics"]["/other"] == {"type": "sensor_msgs/msg/Image", "messages": 1}
    assert set(found["dropped"].values()) == {0}

    assert main(["data", "info", str(folder)]) == 0
    text = capsys.readouterr().out
    for part in (
        "3 frames of 8 x 4 pixels over 2.0 s at 1 Hz",
        "/depth_raw: 3 x",
        "16UC1",
        "50.000%",
        "500.0 m",
    ):
        assert part in text


def test_info_tells_what_a_folder_of_syndrone_holds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("rgb/00000.jpg", "rgb/00001.jpg", "semantic/00000.png"):
        path = tmp_path / "Town10HD_Opt_120" / "WetNoon" / "height20m" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()

    found = printed(capsys, "data", "info", str(tmp_path))

    images = {"rgb": 2, "depth": 0, "semantic": 1}
    assert found["flights"] == [{"town": "10HD", "weather": "WetNoon", "height_m": 20, "images": images}]
    assert main(["data", "info", str(tmp_path)]) == 0
    line = capsys.readouterr().out.splitlines()[-1]
    assert line.split() == ["10HD", "WetNoon", "20", "m", "2", "0", "1"]


def test_an_import_tells_of_images_without_a_partner(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = record(tmp_path / "bag", [*rows_of(make_frames())[:-2], rows_of(make_frames())[-1]])
    assert main(["data", "import", "--bag", str(bag), "--out", str(tmp_path / "flight")]) == 0
    told = capsys.readouterr().err
    assert "are left out: 1 on /rgb_raw, 0 on /depth_raw, 1 on /gt_segmentation." in told
