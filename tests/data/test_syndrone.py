import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from tests.data.material import FLIGHT, blocks, picture_file, put_frame

from sunset.data import PictureFolder, find_syndrone, is_syndrone, survey_syndrone
from sunset.errors import DataError

COUNT = 3


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("syndrone")
    for number in range(COUNT):
        put_frame(root / FLIGHT, number)
    return root


@pytest.fixture
def root(tmp_path: Path, kept: Path) -> Path:
    """Return SynDrone's folders, to be changed by adding and removing files."""
    shutil.copytree(kept, tmp_path / "syndrone", copy_function=os.link)
    return tmp_path / "syndrone"


def _stems(flight: PictureFolder) -> list[str]:
    return [files[0].stem for files in flight.files]


def test_frames_are_those_of_the_pictures(kept: Path) -> None:
    flight = find_syndrone(kept, town="1", height=50)
    assert _stems(flight) == ["00000", "00001", "00002"]
    assert flight.folder == kept / FLIGHT
    for number, frame in enumerate(flight.frames((72, 128))):
        colour, depth, labels = blocks(number)
        np.testing.assert_array_equal(frame.depth, depth)
        np.testing.assert_array_equal(frame.labels, labels)
        # a block's mean survives the JPEG but for what leaks in from its neighbours
        assert np.abs(frame.rgb.astype(int) - colour).mean() < 6


def test_frames_have_the_models_size_by_default(kept: Path) -> None:
    frame = next(find_syndrone(kept, town="1", height=50).frames())
    assert frame.size == (144, 256)
    # centres of the first four rows of 7.5 pixels: 3.75, 11.25, 18.75, 26.25, in blocks of 15
    _, _, labels = blocks(0)
    np.testing.assert_array_equal(frame.labels[:4, 0], labels[[0, 0, 1, 1], 0])


def test_the_number_of_threads_changes_nothing(kept: Path) -> None:
    flight = find_syndrone(kept, town="1", height=50)
    one, many = (list(flight.frames(jobs=jobs)) for jobs in (1, 5))
    for first, second in zip(one, many, strict=True):
        np.testing.assert_array_equal(first.rgb, second.rgb)
        np.testing.assert_array_equal(first.depth, second.depth)
        np.testing.assert_array_equal(first.labels, second.labels)


def test_frames_are_read_a_few_at_a_time(root: Path) -> None:
    for number in range(COUNT, 40):
        for name, suffix in (("rgb", "jpg"), ("depth", "png"), ("semantic", "png")):
            os.link(root / FLIGHT / name / f"00000.{suffix}", root / FLIGHT / name / f"{number:05}.{suffix}")
    frames = find_syndrone(root, town="1", height=50).frames(jobs=2)
    next(frames)
    # nobody has read this far ahead
    (root / FLIGHT / "depth" / "00039.png").unlink()
    (root / FLIGHT / "depth" / "00020.png").unlink()
    with pytest.raises(DataError, match=r"00020.png cannot be read"):
        list(frames)


@pytest.mark.parametrize(
    ("first", "last", "stems"),
    [(1, None, ["00001", "00002"]), (None, 1, ["00000", "00001"]), (1, 1, ["00001"])],
)
def test_a_part_can_be_chosen(kept: Path, first: int | None, last: int | None, stems: list[str]) -> None:
    assert _stems(find_syndrone(kept, town="01", height=50, first=first, last=last)) == stems


@pytest.mark.parametrize("town", ["10", "10HD", "10hd"])
def test_the_tenth_town_has_a_name_of_its_own(root: Path, town: str) -> None:
    (root / "Town01_Opt_120").rename(root / "Town10HD_Opt_120")
    assert find_syndrone(root, town=town, height=50).folder.parts[-3] == "Town10HD_Opt_120"


def test_a_weather_is_named_where_there_are_several(root: Path) -> None:
    shutil.copytree(root / FLIGHT, root / "Town01_Opt_120" / "HardRainNoon" / "height50m")
    assert find_syndrone(root, town="1", height=50, weather="HardRainNoon").folder.parts[-2] == "HardRainNoon"
    with pytest.raises(DataError, match="got ClearNoon, HardRainNoon; name one with --weather"):
        find_syndrone(root, town="1", height=50)


def test_other_files_are_passed_over(root: Path) -> None:
    (root / FLIGHT / "rgb" / "Thumbs.db").write_bytes(b"x")
    (root / FLIGHT / "lidar").mkdir()
    (root / "Town01_Opt_120" / "bboxes").mkdir()
    (root / "readme.txt").write_text("x")
    assert len(find_syndrone(root, town="1", height=50)) == 3


def test_a_survey_counts_what_is_there(root: Path) -> None:
    other = root / "Town10HD_Opt_120" / "WetNoon"
    (other / "height80m" / "rgb").mkdir(parents=True)
    (other / "height20m" / "depth").mkdir(parents=True)
    (root / FLIGHT / "depth" / "00001.png").unlink()
    assert {flight: dict(counts) for flight, counts in survey_syndrone(root).items()} == {
        ("01", "ClearNoon", 50): {"rgb": 3, "depth": 2, "semantic": 3},
        ("10HD", "WetNoon", 20): {"rgb": 0, "depth": 0, "semantic": 0},
        ("10HD", "WetNoon", 80): {"rgb": 0, "depth": 0, "semantic": 0},
    }
    assert is_syndrone(root)
    assert not is_syndrone(root / "Town01_Opt_120")
    assert not is_syndrone(root / "nowhere")


def _without(*names: str) -> Callable[[Path], None]:
    def remove(root: Path) -> None:
        path = root.joinpath(*names)
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()

    return remove


def _empty(root: Path) -> None:
    for path in (root / FLIGHT).glob("*/*"):
        path.unlink()


FOLDERS: dict[str, tuple[Callable[[Path], None], dict[str, Any], str]] = {
    "town unknown": (lambda _: None, {"town": "8"}, "SynDrone has the towns 1 to 7 and 10HD, got '8'"),
    "town missing": (lambda _: None, {"town": "3"}, r"Town03_Opt_120, got Town01_Opt_120; unpack"),
    "folder missing": (_without(), {}, "There is no folder"),
    "nothing there": (_without("Town01_Opt_120"), {}, "got nothing of SynDrone; unpack Town01_Opt_120_color"),
    "weather missing": (lambda _: None, {"weather": "WetNoon"}, "the weather WetNoon, got ClearNoon"),
    "no weather": (_without("Town01_Opt_120", "ClearNoon"), {}, "got none; unpack"),
    "height missing": (lambda _: None, {"height": 80}, "height80m, got height50m"),
    "no depth": (_without(*FLIGHT.parts, "depth"), {}, "folder depth, got rgb, semantic; .*120_depth.zip"),
    "no labels": (_without(*FLIGHT.parts, "semantic"), {}, "folder semantic, got rgb, depth; .*_color.zip"),
    "labels one less": (
        _without(*FLIGHT.parts, "semantic", "00001.png"),
        {},
        "labels of every frame, got 2 of 3; unpack Town01_Opt_120_color.zip",
    ),
    "one less": (
        _without(*FLIGHT.parts, "depth", "00001.png"),
        {},
        "got 3 in rgb, 2 in depth, 3 in semantic, and depth lacks 00001",
    ),
    "none": (_empty, {}, "rgb must hold pictures in .* got nothing"),
    "none chosen": (lambda _: None, {"first": 5, "last": 9}, "has frames 0 to 2, got --frames from 5 to 9"),
}


@pytest.mark.parametrize("case", FOLDERS)
def test_an_incomplete_folder_is_refused(case: str, root: Path) -> None:
    spoil, options, message = FOLDERS[case]
    spoil(root)
    with pytest.raises(DataError, match=message) as caught:
        find_syndrone(root, **{"town": "1", "height": 50, **options})
    assert str(caught.value).endswith(".")


def _plain(shape: tuple[int, ...], kind: type[np.generic], value: int = 7) -> npt.NDArray[Any]:
    return np.full(shape, value, dtype=kind)


PICTURES: dict[str, tuple[str, bytes, str]] = {
    "depth of 8 bits": (
        "depth/00001.png",
        picture_file(_plain((1080, 1920), np.uint8), ".png"),
        "of the kind 16-bit greyscale PNG, got 8-bit greyscale PNG",
    ),
    "labels of 16 bits": (
        "semantic/00001.png",
        picture_file(_plain((1080, 1920), np.uint16), ".png"),
        "of the kind 8-bit greyscale PNG, got 16-bit greyscale PNG",
    ),
    "labels in colour": (
        "semantic/00001.png",
        picture_file(_plain((1080, 1920, 3), np.uint8), ".png"),
        "got 8-bit colour PNG",
    ),
    "grey picture": (
        "rgb/00001.jpg",
        picture_file(_plain((1080, 1920), np.uint8), ".jpg"),
        "got 8-bit greyscale JPEG",
    ),
    "impossible ids": (
        "semantic/00001.png",
        picture_file(_plain((1080, 1920), np.uint8, 57), ".png"),
        "label ids .* got 57",
    ),
    "small": (
        "rgb/00001.jpg",
        picture_file(_plain((720, 1280, 3), np.uint8), ".jpg"),
        "size of the flight's first colour picture, 1920x1080, got 1280x720",
    ),
    "small labels": (
        "semantic/00001.png",
        picture_file(_plain((720, 1280), np.uint8), ".png"),
        "size of the flight's first colour picture, 1920x1080, got 1280x720",
    ),
    "empty": ("depth/00001.png", b"", "got no data"),
    "no picture": ("rgb/00001.jpg", b"<html>404</html>", "got neither JPEG nor PNG"),
}


@pytest.mark.parametrize("case", PICTURES)
def test_a_wrong_picture_is_refused(case: str, root: Path) -> None:
    name, data, message = PICTURES[case]
    path = root / FLIGHT / name
    path.unlink()
    path.write_bytes(data)
    frames = find_syndrone(root, town="1", height=50).frames(jobs=3)
    next(frames)
    with pytest.raises(DataError, match=message) as caught:
        list(frames)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize("name", ["rgb/00002.jpg", "depth/00002.png", "semantic/00002.png"])
def test_a_truncated_picture_is_refused(name: str, root: Path) -> None:
    path = root / FLIGHT / name
    data = path.read_bytes()
    path.unlink()
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(DataError, match="a damaged one: it ends before the picture does") as caught:
        list(find_syndrone(root, town="1", height=50).frames())
    assert str(path) in str(caught.value)
