"""The source of managing systems and extensions: found where a campaign is packed, compared where one is opened."""

import hashlib
import json
import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath
from typing import Final

from sunset import __version__
from sunset.bundling.layout import CAMPAIGN, ManagerSources, Manifest
from sunset.errors import ManagerError, RecordError
from sunset.experiments import EXTERNAL, isolate
from sunset.input_files import file_digest
from sunset.managing import (
    MANAGERS,
    checksum,
    is_registered,
    load_manager,
    manager_sources,
    sources_digest,
    split_label,
    unfiled_sources,
)
from sunset.output_files import folder_name
from sunset.recording import PLAN_FILE, CampaignPlan
from sunset.system import loaded_extensions
from sunset.texts import printable

_LIMIT_S: Final = 30.0
"""Wall time that loading a managing system may take."""


def campaign_managers(described: CampaignPlan) -> dict[str, str]:
    """Return the managing systems of a campaign: the name in tables → as what it was loaded."""
    return {label or manager: manager for label, manager in map(split_label, described.managers)}


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
            found, load = _find(manager)
        except ManagerError as error:
            raise ManagerError(
                f"The source of the managing system {name} is needed: {error} Call it in the folder from which the "
                "campaign was run; of a class that was passed, call sunset.bundle where it was."
            ) from error
        contents = [part if isinstance(part, bytes) else part.read_bytes() for part in found.values()]
        if sources_digest(contents) != known:
            raise RecordError(
                f"The managing system {name} has changed since the campaign was run: restore its source, and call this "
                "again."
            )
        folder = f"managers/{folder_name(name)}"
        own = {f"{folder}/{part}": content for part, content in found.items()}
        load = f"{folder}/{load}" if load.rpartition(":")[0].endswith(".py") else load
        places[name] = ManagerSources(files=tuple(own), load=load, folder=folder)
        files |= own
    return places, files, lacking


def _find(manager: str) -> tuple[dict[str, Path | bytes], str]:
    """Return the files and texts that a managing system's checksum is made of, by name, and as what they load."""
    paths = _paths(manager) if is_registered(manager) else _isolated_paths(manager)
    where, _, kind = manager.rpartition(":")
    root = _root(paths, "" if where.endswith(".py") else where.partition(".")[0])
    parts: dict[str, Path | bytes] = {Path(path).relative_to(root).as_posix(): Path(path) for path in paths}
    if is_registered(manager):
        others = unfiled_sources(manager) or []
        return parts | {f"unfiled-{number}.py": text for number, text in enumerate(others, 1)}, ""
    if manager in MANAGERS:
        return parts, manager
    main = Path(where).resolve().relative_to(root).as_posix() if where.endswith(".py") else where
    return parts, f"{main}:{kind}"


def _paths(manager: str) -> list[str]:
    return list(map(str, manager_sources(manager, load_manager(manager))))


def _isolated_paths(manager: str) -> list[str]:
    """Return the files of a managing system, which is loaded in a process of its own; they may be very many."""
    with tempfile.TemporaryDirectory(prefix="sunset-") as room:
        told = Path(room) / "paths.json"
        isolate(
            manager,
            "cannot be loaded",
            lambda watch: told.write_text(json.dumps(watch.call(lambda: _paths(manager))), encoding="utf-8"),
            limit_s=_LIMIT_S,
        )
        return list(map(str, json.loads(told.read_text(encoding="utf-8"))))


def _root(paths: list[str], package: str) -> Path:
    """Return the folder that holds all files, and of a package, the package."""
    root = Path(os.path.commonpath([Path(path).parent for path in paths])) if paths else Path("/")
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
        files = manifest.managers[name].files if name in manifest.managers else ()
        contents = [_content(folder, file) for file in files]
        if known and sources_digest(contents) != known:
            yield f"managers: the source of {name} ({_listed(files)}) is not what the plan says it was run with."
        if manager in MANAGERS and described.versions.get("sunset") == __version__:
            made = load_manager(manager)
            if known != checksum(manager, manager_sources(manager, made)):
                yield f"{CAMPAIGN}/{PLAN_FILE}: its {name} is not the one of SUNSET {__version__}."
    for name, known in described.extensions.items():
        file = manifest.extensions.get(name, "")
        if hashlib.sha256(_content(folder, file)).hexdigest() != known:
            yield f"extensions: the source of {name} ({_listed([file])}) is not what the plan says it was run with."


def _listed(files: Sequence[str]) -> str:
    return printable(", ".join(files)) or "which is missing"


def bundle_file(folder: Path, name: str) -> Path | None:
    """Return the file of an opened bundle that something in it names; None if there is none in its folder."""
    inside = not PurePosixPath(name).is_absolute() and ".." not in PurePosixPath(name).parts
    return folder / name if inside and (folder / name).is_file() else None


def _content(folder: Path, name: str) -> bytes:
    file = bundle_file(folder, name)
    return file.read_bytes() if file is not None else b""
