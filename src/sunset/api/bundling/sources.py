"""The source of managing systems and extensions: collected for a bundle, and compared with the plan."""

import hashlib
import os
import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath

from sunset.api.bundling.layout import ManagerSources, OpenedBundle, manager_folder
from sunset.errors import ManagerError, RecordError
from sunset.experiments import campaign_managers
from sunset.files.outputs import folder_name
from sunset.managing import (
    EXTERNAL,
    MANAGERS,
    PREFIX,
    checksum,
    is_registered,
    parse_command,
    sources_digest,
)
from sunset.managing.sources import partial_arguments, source_files
from sunset.recording import CampaignPlan
from sunset.system import loaded_extensions
from sunset_ros.texts import printable

Files = dict[str, Path | bytes]
"""Name in the bundle → a file, or its content."""


def find_manager_sources(plan: CampaignPlan) -> tuple[dict[str, ManagerSources], Files, list[str]]:
    """Return the sources of a campaign's managing systems, their files, and a sentence for each missing source.

    Raises:
        ManagerError: a managing system cannot be loaded.
        RecordError: a managing system has changed since the campaign was run.
    """
    sources: dict[str, ManagerSources] = {}
    files: Files = {}
    lacking: list[str] = []
    for name, manager in campaign_managers(plan).items():
        known = plan.manager_checksums.get(name, "")
        if not known:
            reason = "it is another process" if manager == EXTERNAL else "nothing says what it runs"
            lacking.append(f"The source of {name} is not in the bundle: {reason}.")
            continue
        parts = _parts(manager, _paths(name, manager, known))
        folder = manager_folder(name)
        own = {f"{folder}/{part}": content for part, content in parts.items()}
        sources[name] = ManagerSources(files=tuple(own), load=_load(manager, parts, folder))
        files |= own
    return sources, files, lacking


def _paths(name: str, manager: str, known: str) -> Sequence[Path]:
    """Return the files of a managing system that has the known checksum, without running its code."""
    try:
        paths = list(source_files(manager)) if checksum(manager) == known else None
    except (ManagerError, OSError) as error:
        raise ManagerError(
            f"The source of the managing system {name} is needed: {str(error).rstrip('.')}. Call it in the folder "
            "from which the campaign was run; of a class that was passed, call sunset.bundle where it was."
        ) from error
    if paths is None:
        shipped = "bundle the campaign with the version of SUNSET that ran it"
        remedy = shipped if manager in MANAGERS else "restore its source, and call this again"
        raise RecordError(f"The managing system {name} has changed since the campaign was run: {remedy}.")
    return paths


def _parts(manager: str, paths: Sequence[Path]) -> Files:
    """Return the files and texts of a managing system's checksum, by their names below its folder."""
    where = manager.rpartition(":")[0]
    folders = [path.parent for path in paths]
    if manager.startswith(PREFIX):  # a folder that the command names is packed under its name
        folders += [path for word in parse_command(manager).words[1:] if (path := Path(word)).is_dir()]
    root = Path(os.path.commonpath(folders)) if folders else Path("/")
    package = "" if where.endswith(".py") or manager.startswith(PREFIX) else where.partition(".")[0]
    inside = [folder for folder in (root, *root.parents) if package and folder.name == package]
    root = inside[0].parent if inside else root
    parts: Files = {path.relative_to(root).as_posix(): path for path in paths}
    arguments = b"".join(partial_arguments(manager))
    return parts | dict.fromkeys(["arguments.txt"] if arguments else (), arguments)


def _load(manager: str, parts: Mapping[str, Path | bytes], folder: str) -> str:
    """Return the name by which a managing system is loaded from its folder in the bundle; empty if it cannot be."""
    if is_registered(manager):
        return ""
    if manager.startswith(PREFIX):
        return PREFIX + shlex.join(_packed_words(manager, parts, folder))
    where, _, kind = manager.rpartition(":")
    (main,) = [part for part, path in parts.items() if path == Path(where).resolve()] or [""]
    return f"{folder}/{main}:{kind}" if where.endswith(".py") else manager


def _packed_words(manager: str, parts: Mapping[str, Path | bytes], folder: str) -> Iterator[str]:
    """Yield the words of a command, with paths in the bundle for its files and their folders."""
    (root,) = {str(path).removesuffix(part) for part, path in parts.items()}
    typed = shlex.split(manager.removeprefix(PREFIX))
    words = parse_command(manager).words[-len(typed) :]  # without the interpreter of a script
    for word, text in zip(words, typed, strict=True):
        is_packed = any(str(path) == word or str(path).startswith(f"{word}/") for path in parts.values())
        yield str(PurePosixPath(folder, f"{word}/".removeprefix(root))) if is_packed else text


def find_extension_sources() -> tuple[dict[str, str], Files]:
    """Return the places of the sources of the loaded extensions, by name, and these files."""
    places: dict[str, str] = {}
    files: Files = {}
    for extension in loaded_extensions():
        source = Path(extension.source)
        place = f"extensions/{folder_name(extension.name)}/{source.name}"
        places[extension.name], files[place] = place, source
    return places, files


def differing_sources(opened: OpenedBundle) -> Iterator[str]:
    """Yield a sentence for each managing system and extension whose source differs from the plan's checksum."""
    for name, known in opened.plan.manager_checksums.items():
        sources = opened.manifest.managers.get(name, ManagerSources(files=()))
        if known and sources_digest(_content(opened, file) for file in sources.files) != known:
            yield _difference("managers", name, ", ".join(sources.files))
    for name, known in opened.plan.extensions.items():
        file = opened.manifest.extensions.get(name, "")
        if hashlib.sha256(_content(opened, file)).hexdigest() != known:
            yield _difference("extensions", name, file)


def _difference(kind: str, name: str, files: str) -> str:
    return f"{kind}: the source of {name} ({printable(files) or 'which is missing'}) differs from the plan's checksum."


def _content(opened: OpenedBundle, name: str) -> bytes:
    file = opened.file(name)
    return file.read_bytes() if file is not None else b""
