"""SynDrone's folders, and their flights.

Source: G. Rizzoli, F. Barbato, M. Caligiuri, P. Zanuttigh: SynDrone – Multi-modal UAV Dataset for Urban
Scenarios, ICCV Workshops 2023. A flight is a folder `TownNN_Opt_120/<weather>/heightHm` with the folders
`rgb`, `depth` and `semantic`, whose files have the frame's number for a name.
"""

import re
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Final, NoReturn

from sunset.data.picture_folder import PictureFolder, find_pictures
from sunset.errors import DataError

TOWNS: Final = ("01", "02", "03", "04", "05", "06", "07", "10HD")

_TOWN: Final = re.compile(r"Town(\d\d(?:HD)?)_Opt_120")
_HEIGHT: Final = re.compile(r"height(\d+)m")
_ARCHIVES: Final = {"rgb": "color", "depth": "depth", "semantic": "color"}
"""Folder → the name of its archive at SynDrone."""


def find_syndrone(
    root: Path,
    *,
    town: str,
    height: int,
    weather: str | None = None,
    first: int | None = None,
    last: int | None = None,
) -> PictureFolder:
    """Return a flight in SynDrone's folders, after a check that its frames are complete.

    Args:
        root: the parent of the folders `TownNN_Opt_120`.
        town: "1" to "7" or "10HD".
        height: above the ground in metres.
        weather: SynDrone's name; None where the town has a single weather.
        first: index of the first wanted frame, from 0; None for the beginning.
        last: index of the last wanted frame; None for the end.

    Raises:
        DataError: the flight, a folder or a wanted frame is missing.
    """
    name = "10HD" if town == "10" else town.zfill(2).upper()
    if name not in TOWNS:
        raise DataError(f"SynDrone has the towns 1 to 7 and 10HD, got {town!r}.")
    if not root.is_dir():
        raise DataError(f"There is no folder {root}: give the one that holds SynDrone's TownNN_Opt_120.")
    home = root / f"Town{name}_Opt_120"
    if not home.is_dir():
        _lacks(root, home.name, [child.name for child in _folders(root, _TOWN).values()], _unpack(name))
    folder = _height_folder(home, weather or _only_weather(home), height)
    present = [kind for kind in _ARCHIVES if (folder / kind).is_dir()]
    for kind in _ARCHIVES:
        if kind not in present:
            _lacks(folder, f"the folder {kind}", present, _unpack(name, kind))
    flight = find_pictures(folder, first=first, last=last, labels="semantic")
    if flight.unlabelled:
        labelled = f"{len(flight) - flight.unlabelled} of {len(flight)}"
        _lacks(folder, "the labels of every frame", [labelled], _unpack(name, "semantic"))
    return flight


def _height_folder(home: Path, weather: str, height: int) -> Path:
    if not (home / weather).is_dir():
        _lacks(home, f"the weather {weather}", _weathers(home), "choose another --weather")
    folder = home / weather / f"height{height}m"
    if not folder.is_dir():
        heights = [child.name for child in _folders(home / weather, _HEIGHT).values()]
        _lacks(home / weather, folder.name, heights, "choose another --height")
    return folder


def _unpack(town: str, *folders: str) -> str:
    """Return the instruction to get some folders, by default all."""
    archives = sorted({_ARCHIVES[folder] for folder in folders or _ARCHIVES})
    return "unpack " + " and ".join(f"Town{town}_Opt_120_{archive}.zip" for archive in archives)


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


def is_syndrone(path: Path) -> bool:
    """Return whether a path is a folder with towns of SynDrone."""
    return path.is_dir() and bool(_folders(path, _TOWN))


def survey_syndrone(root: Path) -> Mapping[tuple[str, str, int], Mapping[str, int]]:
    """Return the number of images in each folder of a flight, by town, weather and height in metres.

    `root` is the parent of the folders `TownNN_Opt_120`.
    """
    counts: dict[tuple[str, str, int], Mapping[str, int]] = {}
    for town, home in _folders(root, _TOWN).items():
        for weather in _weathers(home):
            folders = {int(height): path for height, path in _folders(home / weather, _HEIGHT).items()}
            for height, folder in sorted(folders.items()):
                counts[town, weather, height] = {
                    kind: len([*(folder / kind).glob("*.[jp][pn]g")]) for kind in _ARCHIVES
                }
    return counts
