"""SynDrone's folders: their flights, and the frames of a flight.

Source: G. Rizzoli, F. Barbato, M. Caligiuri, P. Zanuttigh: SynDrone – Multi-modal UAV Dataset for Urban
Scenarios, ICCV Workshops 2023. A flight is a folder `TownNN_Opt_120/<weather>/heightHm` with the folders
`rgb`, `depth` and `semantic`, whose files have the frame's number for a name.
"""

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Final, NoReturn

from sunset.data.conventions import SYNDRONE
from sunset.data.pixels import (
    COLOUR_JPEG,
    DEPTH_PNG,
    LABEL_PNG,
    dimensions,
    read_ahead,
    read_picture,
    resample,
)
from sunset.errors import DataError
from sunset.files.image_digests import Pixels
from sunset_town import FRAME_SIZE, Frame

TOWNS: Final = ("01", "02", "03", "04", "05", "06", "07", "10HD")
SIZE: Final = (1080, 1920)

_TOWN: Final = re.compile(r"Town(\d\d(?:HD)?)_Opt_120")
_HEIGHT: Final = re.compile(r"height(\d+)m")
_NUMBER: Final = re.compile(r"\d{5}")
_PICTURES: Final = frozenset({".jpg", ".jpeg", ".png"})


@dataclass(frozen=True, slots=True)
class _Modality:
    suffix: str
    kind: str
    archive: str
    """The name of its archive at SynDrone."""


_MODALITIES: Final = {
    "rgb": _Modality("jpg", COLOUR_JPEG, "color"),
    "depth": _Modality("png", DEPTH_PNG, "depth"),
    "semantic": _Modality("png", LABEL_PNG, "color"),
}


@dataclass(frozen=True, slots=True)
class SynDroneFlight:
    """A flight over a town of SynDrone, or a part of it.

    Attributes:
        town: as SynDrone names it, such as "01" or "10HD".
        weather: with the time of day, such as "ClearNoon".
        height: above the ground in metres.
        folder: the parent of `rgb`, `depth` and `semantic`.
        numbers: of its frames, in order.
    """

    town: str
    weather: str
    height: int
    folder: Path
    numbers: tuple[int, ...]

    def __len__(self) -> int:
        return len(self.numbers)

    @property
    def gaps(self) -> int:
        """Number of missing frames between the first and the last."""
        return self.numbers[-1] - self.numbers[0] + 1 - len(self.numbers)

    def frames(self, size: tuple[int, int] = FRAME_SIZE, *, jobs: int | None = None) -> Iterator[Frame]:
        """Return the frames in order, resampled to a height and width in pixels; `jobs` threads read ahead.

        Raises:
            DataError: a picture is missing, damaged, of another kind or size, or has unknown ids.
        """
        return read_ahead(partial(self._frame, size), self.numbers, jobs=jobs)

    def _frame(self, size: tuple[int, int], number: int) -> Frame:
        rgb, depth, labels = (self._pixels(name, number) for name in _MODALITIES)
        SYNDRONE.labels(labels, str(self._file("semantic", number)))
        return resample(Frame(rgb, depth, labels), size)

    def _pixels(self, name: str, number: int) -> Pixels:
        path = self._file(name, number)
        pixels = read_picture(path, [_MODALITIES[name].kind], remedy=_unpack(self.town, name))
        if pixels.shape[:2] != SIZE:
            got = dimensions((pixels.shape[0], pixels.shape[1]))
            raise DataError(
                f"The image {path} must have SynDrone's size, {dimensions(SIZE)}, got {got}; "
                f"{_unpack(self.town, name)}."
            )
        return pixels

    def _file(self, name: str, number: int) -> Path:
        return self.folder / name / f"{number:05}.{_MODALITIES[name].suffix}"


def _unpack(town: str, *names: str) -> str:
    """Return the instruction to get the folders of some modalities, by default of all."""
    archives = sorted({_MODALITIES[name].archive for name in names or _MODALITIES})
    return "unpack " + " and ".join(f"Town{town}_Opt_120_{archive}.zip" for archive in archives)


def find_syndrone(
    root: Path,
    *,
    town: str,
    height: int,
    weather: str | None = None,
    first: int | None = None,
    last: int | None = None,
) -> SynDroneFlight:
    """Return a flight in SynDrone's folders, after a check that its frames are complete.

    Args:
        root: the parent of the folders `TownNN_Opt_120`.
        town: "1" to "7" or "10HD".
        height: above the ground in metres.
        weather: SynDrone's name; None where the town has a single weather.
        first: number of the first wanted frame; None for the beginning.
        last: number of the last wanted frame; None for the end.

    Raises:
        DataError: the flight, a modality or a wanted frame is missing.
    """
    name = town.zfill(2).upper()
    name = "10HD" if name == "10" else name
    if name not in TOWNS:
        raise DataError(f"SynDrone has the towns 1 to 7 and 10HD, got {town!r}.")
    if not root.is_dir():
        raise DataError(f"There is no folder {root}: give the one that holds SynDrone's TownNN_Opt_120.")
    home = root / f"Town{name}_Opt_120"
    if not home.is_dir():
        _lacks(root, home.name, [child.name for child in _folders(root, _TOWN).values()], _unpack(name))
    chosen = weather or _only_weather(home)
    if not (home / chosen).is_dir():
        _lacks(home, f"the weather {chosen}", _weathers(home), "choose another --weather")
    folder = home / chosen / f"height{height}m"
    if not folder.is_dir():
        heights = [child.name for child in _folders(home / chosen, _HEIGHT).values()]
        _lacks(home / chosen, folder.name, heights, "choose another --height")
    return SynDroneFlight(name, chosen, height, folder, _numbers(folder, name, first, last))


def _lacks(folder: Path, wanted: str, present: Collection[str], remedy: str) -> NoReturn:
    got = ", ".join(present) or "nothing of SynDrone"
    raise DataError(f"The folder {folder} must hold {wanted}, got {got}; {remedy}.")


def _folders(folder: Path, pattern: re.Pattern[str]) -> dict[str, Path]:
    """Return the folders in a folder whose names match, by the pattern's group, in order of names."""
    matches = ((pattern.fullmatch(path.name), path) for path in sorted(folder.iterdir()))
    return {match[1]: path for match, path in matches if match and path.is_dir()}


def _weathers(home: Path) -> list[str]:
    return sorted(path.name for path in home.iterdir() if path.is_dir() and _folders(path, _HEIGHT))


def _only_weather(home: Path) -> str:
    names = _weathers(home)
    if len(names) != 1:
        got = f"{', '.join(names)}; name one with --weather" if names else "none; unpack its archives again"
        raise DataError(f"The folder {home} must hold one weather where none is named, got {got}.")
    return names[0]


def _present(folder: Path, name: str) -> set[int]:
    """Return the numbers of a modality's frames."""
    suffix = f".{_MODALITIES[name].suffix}"
    paths = (folder / name).iterdir() if (folder / name).is_dir() else ()
    return {int(path.stem) for path in paths if path.suffix == suffix and _NUMBER.fullmatch(path.stem)}


def _check_suffixes(folder: Path, name: str, present: Collection[int]) -> None:
    """Check that no other frames have a name with another suffix."""
    suffix = _MODALITIES[name].suffix
    for path in sorted(folder.iterdir()):
        is_picture = path.suffix.lower() in _PICTURES and _NUMBER.fullmatch(path.stem)
        if is_picture and int(path.stem) not in present:
            raise DataError(
                f"The folder {folder} must hold files such as {path.stem}.{suffix}, got {path.name}: "
                f"SynDrone's are {_MODALITIES[name].kind} under that name; take them unconverted."
            )


def _numbers(folder: Path, town: str, first: int | None, last: int | None) -> tuple[int, ...]:
    """Return the numbers of the wanted frames, after a check that every modality has them."""
    for modality in _MODALITIES:
        if not (folder / modality).is_dir():
            others = [other for other in _MODALITIES if (folder / other).is_dir()]
            _lacks(folder, f"the folder {modality}", others, _unpack(town, modality))
    present = {name: _present(folder, name) for name in _MODALITIES}
    for name in _MODALITIES:
        _check_suffixes(folder / name, name, present[name])
    everything = sorted(set().union(*present.values()))
    if not everything:
        raise DataError(
            f"The folder {folder} must hold frames such as rgb/00000.jpg, depth/00000.png and "
            f"semantic/00000.png, got none; {_unpack(town)}."
        )
    low, high = everything[0] if first is None else first, everything[-1] if last is None else last
    if not everything[0] <= low <= high <= everything[-1]:
        raise DataError(
            f"The folder {folder} must hold frames from {low:05} to {high:05}, got {everything[0]:05} to "
            f"{everything[-1]:05}; choose --frames among these."
        )
    wanted = set(everything if first is None and last is None else range(low, high + 1))
    for name, numbers in present.items():
        if missing := sorted(wanted - numbers):
            counts = ", ".join(f"{len(wanted & own)} in {other}" for other, own in present.items())
            raise DataError(
                f"The folder {folder} must hold every chosen frame in all three folders, got {counts}, and "
                f"{name} lacks {missing[0]:05}; {_unpack(town, name)}, or choose complete ones with --frames."
            )
    return tuple(sorted(wanted))


def is_syndrone(path: Path) -> bool:
    """Return whether a path is a folder with towns of SynDrone."""
    return path.is_dir() and bool(_folders(path, _TOWN))


def survey_syndrone(root: Path) -> Mapping[tuple[str, str, int], Mapping[str, int]]:
    """Return the number of images of each modality, by town, weather and height in metres.

    `root` is the parent of the folders `TownNN_Opt_120`.
    """
    counts: dict[tuple[str, str, int], Mapping[str, int]] = {}
    for town, home in _folders(root, _TOWN).items():
        for weather in _weathers(home):
            folders = {int(height): path for height, path in _folders(home / weather, _HEIGHT).items()}
            for height, folder in sorted(folders.items()):
                images = {name: len(_present(folder, name)) for name in _MODALITIES}
                counts[town, weather, height] = MappingProxyType(images)
    return MappingProxyType(counts)
