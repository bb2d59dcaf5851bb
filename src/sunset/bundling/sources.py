"""The source of managing systems and extensions: found where a campaign is packed, compared where one is opened."""

import hashlib
import os
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath
from typing import Final

from sunset.bundling.layout import MANIFEST_FILE, ManagerSources, Manifest
from sunset.errors import ManagerError, RecordError
from sunset.experiments import campaign_managers
from sunset.input_files import file_digest
from sunset.managing import (
    EXTERNAL,
    PREFIX,
    checksum,
    is_registered,
    parse_command,
    sources_digest,
)
from sunset.managing.sources import partial_arguments, source_files
from sunset.output_files import folder_name
from sunset.recording import CampaignPlan
from sunset.system import loaded_extensions
from sunset.texts import printable

_ARGUMENTS: Final = "arguments.txt"
"""The file with the arguments of a `functools.partial`, behind the source files."""


def find_manager_sources(
    described: CampaignPlan,
) -> tuple[dict[str, ManagerSources], dict[str, Path | bytes], list[str]]:
    """Return where a bundle has the sources of a campaign's managing systems, its files, and what it cannot have.

    Raises:
        ManagerError: one cannot be loaded.
        RecordError: one is not the one that the campaign was run with.
    """
    places: dict[str, ManagerSources] = {}
    files: dict[str, Path | bytes] = {}
    lacking: list[str] = []
    for name, manager in campaign_managers(described).items():
        known = described.manager_checksums.get(name, "")
        if not known:
            reason = "it is another process" if manager == EXTERNAL else "nothing says what it runs"
            lacking.append(f"The source of {name} is not in the bundle: {reason}.")
            continue
        try:
            paths = list(source_files(manager)) if checksum(manager) == known else None
        except (ManagerError, OSError) as error:
            raise ManagerError(
                f"The source of the managing system {name} is needed: {str(error).rstrip('.')}. Call it in the folder "
                "from which the campaign was run; of a class that was passed, call sunset.bundle where it was."
            ) from error
        if paths is None:
            raise RecordError(
                f"The managing system {name} has changed since the campaign was run: restore its source, and call this "
                "again."
            )
        found = _named(manager, paths)
        folder = f"managers/{folder_name(name)}"
        own = {f"{folder}/{part}": content for part, content in found.items()}
        places[name] = ManagerSources(files=tuple(own), load=_load(manager, found, folder), folder=folder)
        files |= own
    return places, files, lacking


def _named(manager: str, paths: list[Path]) -> dict[str, Path | bytes]:
    """Return the files and texts that a managing system's checksum is made of, by name."""
    where = manager.rpartition(":")[0]
    if manager.startswith(PREFIX):
        named = (Path(word) for word in parse_command(manager).words[1:])
        root = _root([*paths, *(path / "inside" for path in named if path.is_dir())], "")
    else:
        root = _root(paths, "" if where.endswith(".py") else where.partition(".")[0])
    arguments = b"".join(partial_arguments(manager))
    parts: dict[str, Path | bytes] = {path.relative_to(root).as_posix(): path for path in paths}
    return parts | dict.fromkeys([_ARGUMENTS] if arguments else (), arguments)


def _load(manager: str, parts: Mapping[str, Path | bytes], folder: str) -> str:
    """Return as what a managing system is loaded whose files are in a folder of the bundle; empty if it cannot be."""
    if is_registered(manager):
        return ""
    if manager.startswith(PREFIX):
        (root,) = {str(path).removesuffix(part) for part, path in parts.items()}
        words = _words(manager)
        found = parse_command(manager).words[-len(words) :]  # without what runs a script
        words = [
            str(PurePosixPath(folder, f"{word}/".removeprefix(root)))
            if _holds(word, parts.values())
            else typed
            for typed, word in zip(words, found, strict=True)
        ]
        return PREFIX + shlex.join(words)
    where, _, kind = manager.rpartition(":")
    (main,) = [part for part, path in parts.items() if path == Path(where).resolve()] or [""]
    return f"{folder}/{main}:{kind}" if where.endswith(".py") else manager


def _words(manager: str) -> list[str]:
    """Return the words of a command as they were typed; none of one that no shell can read."""
    try:
        return shlex.split(manager.removeprefix(PREFIX))
    except ValueError:
        return []


def _holds(word: str, files: Iterable[object]) -> bool:
    """Return whether a word names one of some files, or a folder with such."""
    return any(str(file) == word or str(file).startswith(f"{word}/") for file in files)


def _root(paths: list[Path], package: str) -> Path:
    """Return the folder that holds all files, and of a package, the package."""
    root = Path(os.path.commonpath([path.parent for path in paths])) if paths else Path("/")
    inside = [folder for folder in (root, *root.parents) if package and folder.name == package]
    return inside[0].parent if inside else root


def find_extension_sources(described: CampaignPlan) -> tuple[dict[str, str], dict[str, Path | bytes]]:
    """Return where a bundle has the sources of a campaign's extensions, which are loaded, and these files.

    Raises:
        RecordError: the source of one is not there any more.
    """
    places: dict[str, str] = {}
    files: dict[str, Path | bytes] = {}
    for one in loaded_extensions():
        source = Path(one.source)
        if not source.is_file() or file_digest(source) != described.extensions[one.name]:
            raise RecordError(f"The source of the extension {one.name} has changed since it was loaded.")
        places[one.name] = f"extensions/{folder_name(one.name)}/{source.name}"
        files[places[one.name]] = source
    return places, files


def differing_sources(folder: Path, described: CampaignPlan, manifest: Manifest) -> Iterator[str]:
    """Yield a sentence for each managing system and extension whose source in an opened bundle is not the plan's."""
    for name, manager in campaign_managers(described).items():
        known = described.manager_checksums.get(name, "")
        place = manifest.managers.get(name, ManagerSources(files=()))
        if known and not _fits(name, manager, place):
            yield f"{MANIFEST_FILE}: the sources of {name} and how it is loaded do not fit {manager}."
        if known and sources_digest([_content(folder, file) for file in place.files]) != known:
            yield f"managers: the source of {name} ({_listed(place.files)}) is not what the plan says it was run with."
    yield from _differing_extensions(folder, described, manifest)


def _differing_extensions(folder: Path, described: CampaignPlan, manifest: Manifest) -> Iterator[str]:
    for name, known in described.extensions.items():
        file = manifest.extensions.get(name, "")
        if PurePosixPath(file).parent.as_posix() != f"extensions/{folder_name(name)}":
            yield f"{MANIFEST_FILE}: the source of {name} lies in the place of something else."
        if hashlib.sha256(_content(folder, file)).hexdigest() != known:
            yield f"extensions: the source of {name} ({_listed([file])}) is not what the plan says it was run with."


def _fits(name: str, manager: str, place: ManagerSources) -> bool:
    """Return whether the files of a managing system lie where they are packed, and give the class that the plan names.

    What was passed as a class is loaded as nothing. The order of the files is that of which the checksum is made.
    """
    folder = f"managers/{folder_name(name)}"
    parts = [PurePosixPath(file) for file in place.files if PurePosixPath(file).name != _ARGUMENTS]
    inside = all(file.startswith(f"{folder}/") for file in place.files) and place.folder == folder
    ordered = parts == sorted(set(parts))
    where, _, kind = manager.rpartition(":")
    loaded, _, loaded_kind = place.load.rpartition(":")
    if manager.startswith(PREFIX):
        typed, packed = _words(manager), _words(place.load)
        fits = place.load.startswith(PREFIX) and len(typed) == len(packed) > 0
        for word, other in zip(typed, packed, strict=False):
            same_name = other == folder or PurePosixPath(word).name == PurePosixPath(other).name
            fits &= word == other or (same_name and _holds(other, place.files))
    elif where.endswith(".py"):
        fits = loaded in place.files and (PurePosixPath(loaded).name, loaded_kind) == (Path(where).name, kind)
    else:
        fits = place.load in {"", manager}
    return inside and ordered and fits


def _listed(files: Sequence[str]) -> str:
    return printable(", ".join(files)) or "which is missing"


def bundle_file(folder: Path, name: str) -> Path | None:
    """Return the file of an opened bundle that something in it names; None if there is none in its folder."""
    inside = not PurePosixPath(name).is_absolute() and ".." not in PurePosixPath(name).parts
    return folder / name if inside and (folder / name).is_file() else None


def _content(folder: Path, name: str) -> bytes:
    file = bundle_file(folder, name)
    return file.read_bytes() if file is not None else b""
