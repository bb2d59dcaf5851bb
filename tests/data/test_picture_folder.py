"""A plain folder of pictures: which frames it holds, and what is said of one that is not as it must be."""

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from tests.data.material import make_frames, picture_file, put_pictures

from sunset.data import Frame, find_pictures, read_bag
from sunset.errors import DataError

SIZE = (18, 32)
NAMES = ("a9", "a10", "a8")
IN_ORDER = (2, 0, 1)
"""Of the frames, which are written under these names."""


@pytest.fixture(scope="module")
def frames() -> list[Frame]:
    return make_frames(len(NAMES), SIZE)


@pytest.fixture
def folder(tmp_path: Path, frames: list[Frame]) -> Path:
    """Return a folder of pictures, to be changed."""
    for name, frame in zip(NAMES, frames, strict=True):
        put_pictures(tmp_path / "pictures", name, frame)
    return tmp_path / "pictures"


@pytest.mark.parametrize("jobs", [1, 3])
def test_frames_are_those_of_the_pictures_in_the_order_of_their_names(
    folder: Path, frames: list[Frame], jobs: int
) -> None:
    flight = find_pictures(folder)
    assert [path.stem for path, _, _ in flight.files] == ["a8", "a9", "a10"]
    for number, frame in zip(IN_ORDER, flight.frames(SIZE, jobs=jobs), strict=True):
        np.testing.assert_array_equal(frame.rgb, frames[number].rgb)
        np.testing.assert_array_equal(frame.depth, frames[number].depth)
        np.testing.assert_array_equal(frame.labels, frames[number].labels)


def test_colour_may_be_jpeg_and_frames_have_the_models_size_by_default(tmp_path: Path) -> None:
    put_pictures(tmp_path, "0", make_frames(1, (90, 160))[0], colour=".JPG")
    (frame,) = find_pictures(tmp_path).frames()
    assert frame.size == (144, 256)


@pytest.mark.parametrize("kept", [("a8", "a10"), ()])
def test_pictures_may_lack_some_labels_or_all(
    folder: Path, frames: list[Frame], kept: tuple[str, ...]
) -> None:
    for path in (folder / "labels").iterdir():
        if path.stem not in kept:
            path.unlink()
    if not kept:
        (folder / "labels").rmdir()
    flight = find_pictures(folder)
    assert flight.unlabelled == len(NAMES) - len(kept)
    for name, number, frame in zip(("a8", "a9", "a10"), IN_ORDER, flight.frames(SIZE), strict=True):
        np.testing.assert_array_equal(frame.rgb, frames[number].rgb)
        np.testing.assert_array_equal(frame.labels, frames[number].labels * (name in kept))


@pytest.mark.parametrize(
    ("first", "last", "stems"), [(1, None, ["a9", "a10"]), (None, 0, ["a8"]), (1, 1, ["a9"])]
)
def test_a_part_can_be_chosen(folder: Path, first: int | None, last: int | None, stems: list[str]) -> None:
    assert [path.stem for path, _, _ in find_pictures(folder, first=first, last=last).files] == stems


def remove_depth(folder: Path) -> None:
    for path in (folder / "depth").iterdir():
        path.unlink()
    (folder / "depth").rmdir()


def make_pipe(folder: Path) -> None:
    (folder / "depth" / "a9.png").unlink()
    os.mkfifo(folder / "depth" / "a9.png")


def convert_depth(folder: Path) -> None:
    for path in (folder / "depth").iterdir():
        path.rename(path.with_suffix(".npy"))


def write(name: str, image: npt.NDArray[Any]) -> Callable[[Path], object]:
    return lambda folder: (folder / name).write_bytes(picture_file(image, Path(name).suffix.lower()))


MISTAKES: dict[str, tuple[Callable[[Path], object], str]] = {
    "no depth": (remove_depth, "must hold the folders rgb, depth, labels, got no depth; put"),
    "another format": (
        convert_depth,
        r"depth must hold pictures in \.jpeg, \.jpg, \.png, got \.npy; convert",
    ),
    "a gap": (
        lambda folder: (folder / "rgb" / "a9.png").unlink(),
        "got 2 in rgb, 3 in depth, 3 in labels, and rgb lacks a9; name the pictures",
    ),
    "labels of another name": (
        lambda folder: (folder / "labels" / "a9.png").rename(folder / "labels" / "b9.png"),
        "got 3 in rgb, 3 in depth, 3 in labels, and rgb lacks b9; name the pictures",
    ),
    "a pipe": (make_pipe, "got 3 in rgb, 2 in depth, 3 in labels, and depth lacks a9; name the pictures"),
    "two of one name": (
        write("rgb/a9.jpg", np.zeros((*SIZE, 3), np.uint8)),
        r"one picture of each name, got a9\.jpg and a9\.png; remove one",
    ),
    "depth of 8 bits": (
        write("depth/a10.png", np.zeros(SIZE, np.uint8)),
        r"a10\.png must be of the kind 16-bit greyscale PNG, got 8-bit greyscale PNG",
    ),
    "labels in colour": (
        write("labels/a10.png", np.zeros((*SIZE, 3), np.uint8)),
        r"a10\.png must be of the kind 8-bit greyscale PNG, got 8-bit colour PNG",
    ),
    "another size": (
        write("depth/a10.png", np.zeros((18, 30), np.uint16)),
        r"a10\.png must have the size of the flight's first colour picture, 32x18, got 30x18; record",
    ),
    "ids of another data set": (
        write("labels/a10.png", np.full(SIZE, 99, np.uint8)),
        r"a10\.png must hold SynDrone's label ids .*, got 99",
    ),
    "half a picture": (
        lambda folder: (folder / "rgb" / "a9.png").write_bytes(
            (folder / "rgb" / "a9.png").read_bytes()[:100]
        ),
        r"a9\.png must be a whole picture",
    ),
}


def test_a_folder_that_is_not_there_is_said_to_be_missing(tmp_path: Path) -> None:
    with pytest.raises(
        DataError, match=r"There is no folder .*nowhere: give the one that holds the folders rgb, "
    ):
        find_pictures(tmp_path / "nowhere")


def test_who_takes_pictures_for_a_bag_is_told_what_makes_one_of_them(folder: Path) -> None:
    with pytest.raises(
        DataError, match=r"of pictures in rgb, depth and labels 'sunset data import --pictures'"
    ):
        read_bag(folder)


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_is_not_as_it_must_be_is_said_in_one_sentence(folder: Path, mistake: str) -> None:
    make, sentence = MISTAKES[mistake]
    make(folder)
    with pytest.raises(DataError, match=sentence) as told:
        list(find_pictures(folder).frames(SIZE))
    assert str(told.value).endswith(".")
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(("first", "last"), [(3, None), (None, 3), (2, 1)])
def test_frames_that_are_not_there_are_refused(folder: Path, first: int | None, last: int | None) -> None:
    with pytest.raises(DataError, match=r"has frames 0 to 2, got --frames from"):
        find_pictures(folder, first=first, last=last)


def test_what_is_no_picture_is_passed_over(folder: Path) -> None:
    (folder / "rgb" / ".thumbnail.png").write_bytes(b"")
    (folder / "depth" / "notes.txt").write_bytes(b"")
    (folder / "labels" / "more.png").mkdir()
    assert len(find_pictures(folder)) == 3


def with_names(folder: Path, names: Sequence[str]) -> Path:
    for name, frame in zip(names, make_frames(len(names), SIZE), strict=True):
        put_pictures(folder, name, frame)
    return folder


@pytest.mark.parametrize(
    ("names", "kind"),
    [
        (["0.05", "0.1"], "decimal"),
        (["1.9", "1.10"], "decimal"),
        (["-2", "-1", "0"], "decimal"),
        (["1e-05", "0.01"], "decimal"),
    ],
)
def test_names_whose_order_is_not_clear_are_refused(names: list[str], kind: str, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=f"as {kind} numbers is another; name them by their places"):
        find_pictures(with_names(tmp_path, names))


@pytest.mark.parametrize(
    "names",
    [["9", "10"], ["0.05", "0.10"], ["9.5", "10.5"], ["1_9", "1_10"], ["2026-03-04 9.05", "2026-03-04 9.10"]],
)
def test_names_whose_order_is_clear_are_taken(names: list[str], tmp_path: Path) -> None:
    flight = find_pictures(with_names(tmp_path, names))
    assert [path.stem for path, _, _ in flight.files] == names
