"""Folders of pictures: the frames of a flight in `rgb`, `depth` and `labels`."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from sunset.data.conventions import SYNDRONE, Reading
from sunset.data.pixels import (
    COLOUR_JPEG,
    COLOUR_PNG,
    DEPTH_PNG,
    LABEL_PNG,
    dimensions,
    read_ahead,
    read_picture,
    resample,
)
from sunset.errors import DataError
from sunset_town import FRAME_SIZE, Frame

_KINDS: Final = {"rgb": (COLOUR_JPEG, COLOUR_PNG), "depth": (DEPTH_PNG,), "labels": (LABEL_PNG,)}
"""Folder → the kinds of its pictures."""
_SUFFIXES: Final = frozenset({".jpg", ".jpeg", ".png"})
_NUMBERS: Final = re.compile(r"([0-9]+)")
_DECIMAL: Final = re.compile(r"[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")


@dataclass(frozen=True, slots=True)
class PictureFolder:
    """The pictures of a flight or a part of it: each frame's files of colour, depth and, if any, labels."""

    folder: Path
    files: tuple[tuple[Path, ...], ...]

    def __len__(self) -> int:
        return len(self.files)

    @property
    def unlabelled(self) -> int:
        """Number of frames without labels."""
        return sum(len(files) < len(_KINDS) for files in self.files)

    def frames(
        self, size: tuple[int, int] = FRAME_SIZE, *, jobs: int | None = None, reading: Reading = SYNDRONE
    ) -> Iterator[Frame]:
        """Return the frames in order, resampled to a height and width in pixels; `jobs` threads read ahead.

        Raises:
            DataError: a picture cannot be read, is damaged, of another kind or of another size than the first, or has
                ids outside the convention `reading`.
        """
        first = read_picture(self.files[0][0], _KINDS["rgb"]).shape
        return read_ahead(partial(_frame, (first[0], first[1]), size, reading), self.files, jobs=jobs)


def _frame(
    recorded: tuple[int, int], size: tuple[int, int], reading: Reading, files: tuple[Path, ...]
) -> Frame:
    pictures = []
    for name, path in zip(_KINDS, files, strict=False):
        pixels = read_picture(path, _KINDS[name])
        if (got := (pixels.shape[0], pixels.shape[1])) != recorded:
            raise DataError(
                f"The image {path} must have the size of the flight's first colour picture, {dimensions(recorded)}, "
                f"got {dimensions(got)}; record colour, depth and labels aligned and of one size."
            )
        pictures.append(pixels)
    rgb, depth, *others = pictures
    labels = reading.labels(others[0], str(files[-1])) if others else np.zeros(depth.shape, np.uint8)
    return resample(Frame(rgb, reading.depth(depth), labels), size)


def find_pictures(
    folder: Path, *, first: int | None = None, last: int | None = None, labels: str = "labels"
) -> PictureFolder:
    """Return a flight's pictures in `rgb`, `depth` and `labels`, after a check that its frames are complete.

    The pictures of a frame have the same name but for the suffix. Frames may lack labels. Frames are in the order of
    their names, in which numbers count by their value: `9` comes before `10`.

    Args:
        folder: the parent of the three folders.
        first: index of the first wanted frame, from 0; None for the beginning.
        last: index of the last wanted frame; None for the end.
        labels: the name of the folder of labels.

    Raises:
        DataError: a folder is missing, has no pictures or two of the same name, names differ between folders or are in
            another order as decimal numbers, or wanted frames are missing.
    """
    pictures = _folders_of_pictures(folder, ("rgb", "depth", labels))
    names = sorted(set().union(*pictures.values()), key=_order)
    for name, own in pictures.items():
        if missing := [stem for stem in names if stem not in own and name != labels]:
            counts = ", ".join(f"{len(files)} in {other}" for other, files in pictures.items())
            raise DataError(
                f"The folder {folder} must hold pictures of the same names in all folders, got {counts}, and "
                f"{name} lacks {missing[0]}; name the pictures of a frame alike."
            )
    _check_order(names, folder)
    low, high = first or 0, len(names) - 1 if last is None else last
    if not low <= high < len(names):
        raise DataError(
            f"The folder {folder} has frames 0 to {len(names) - 1}, got --frames from {low} to {high}; "
            "choose them among these."
        )
    frames = (tuple(own[stem] for own in pictures.values() if stem in own) for stem in names[low : high + 1])
    return PictureFolder(folder, tuple(frames))


def _folders_of_pictures(folder: Path, names: Sequence[str]) -> dict[str, dict[str, Path]]:
    if not folder.is_dir():
        raise DataError(
            f"There is no folder {folder}: give the one that holds the folders {', '.join(names)}."
        )
    for name in names[:2]:
        if not (folder / name).is_dir():
            raise DataError(
                f"The folder {folder} must hold the folders {', '.join(names)}, got no {name}; "
                "put the pictures of the three kinds into one each, and leave out labels if there are none."
            )
    return {name: _pictures(folder / name) for name in names if (folder / name).is_dir()}


def _pictures(folder: Path) -> dict[str, Path]:
    """Return the pictures in a folder by their names without the suffix."""
    pictures: dict[str, Path] = {}
    others = set()
    for path in sorted(folder.iterdir()):
        if path.suffix.lower() not in _SUFFIXES or path.name.startswith(".") or not path.is_file():
            others.add(path.suffix or path.name)
        elif pictures.setdefault(path.stem, path) != path:
            raise DataError(
                f"The folder {folder} must hold one picture of each name, got {pictures[path.stem].name} and "
                f"{path.name}; remove one."
            )
    if not pictures:
        got = ", ".join(sorted(others)[:5]) or "nothing"
        raise DataError(
            f"The folder {folder} must hold pictures in {', '.join(sorted(_SUFFIXES))}, got {got}; convert them."
        )
    return pictures


def _check_order(ordered: Sequence[str], folder: Path) -> None:
    """Check that names have the same order as decimal numbers."""
    if not all(map(_DECIMAL.fullmatch, ordered)):
        return
    for name, following in pairwise(ordered):
        if float(name) > float(following):
            raise DataError(
                f"The folder {folder} must hold pictures whose names have one order, got {name} and "
                f"{following}, whose order as decimal numbers is another; name them by their places, such as "
                "00000 and 00001."
            )


def _order(name: str) -> tuple[list[str | int], str]:
    """Return the sort key of a name: texts and numbers in turns, then the name itself.

    >>> sorted(["10", "9", "b2", "09"], key=_order)
    ['09', '9', '10', 'b2']
    """
    parts = _NUMBERS.split(name)
    return [int(part) if place % 2 else part for place, part in enumerate(parts)], name
