"""The source of managing systems and extensions: collected for a bundle, and compared with its plan."""

import hashlib
import os
import shlex
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Final

import msgspec

from sunset.api.bundling.archive import CAMPAIGN, CARD_FILE, MANIFEST_FILE
from sunset.errors import ManagerError, RecordError
from sunset.experiments import campaign_managers
from sunset.files.outputs import folder_name
from sunset.files.schemas import convert, read_json
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
from sunset.perception import ModelCard
from sunset.recording import CampaignPlan, read_plan
from sunset.system import System, extended_system, loaded_extensions

Files = dict[str, Path | bytes]
"""Name in the bundle → a file, or its content."""

_VERSION: Final = 1
"""The version of the layout of bundles."""


class ManagerSources(msgspec.Struct, frozen=True, kw_only=True):
    """The source of a managing system in a bundle.

    Attributes:
        files: the files of its checksum, in their order.
        load: its name for loading, with paths in the bundle; empty for a class that was passed in Python.
    """

    files: tuple[str, ...]
    load: str = ""


class Manifest(msgspec.Struct, frozen=True, kw_only=True):
    """The content of `bundle.json`: the sources of managing systems, and the source file of each extension, by name.

    The `date` of publication and the `authors` are as `bundle` got them.
    """

    bundle_version: int = _VERSION
    date: str = ""
    authors: tuple[str, ...] = ()
    managers: dict[str, ManagerSources]
    extensions: dict[str, str]


def manager_folder(name: str) -> str:
    """Return the folder of a bundle with the source of a managing system."""
    return f"managers/{folder_name(name)}"


@dataclass(frozen=True)
class OpenedBundle:
    """A bundle that was opened into a folder, `root`."""

    root: Path
    manifest: Manifest
    plan: CampaignPlan
    card: ModelCard

    @classmethod
    def read(cls, root: Path) -> "OpenedBundle":
        """Read the manifest, the plan and the model's card.

        Raises:
            InvalidInputError: a file is missing, damaged, or of another version.
        """
        file = root / MANIFEST_FILE
        missing = f"It is not a bundle: {MANIFEST_FILE} is missing; name a file that 'sunset bundle' wrote."
        content = read_json(file, "The manifest", RecordError, missing=missing)
        version = content.get("bundle_version") if isinstance(content, dict) else _VERSION
        if version != _VERSION:
            raise RecordError(
                f"The bundle is of version {version!r}, expected {_VERSION}; verify it with the SUNSET that wrote it."
            )
        manifest = convert(
            content, Manifest, str(file), RecordError, remedy="take the bundle as it was published"
        )
        return cls(root, manifest, read_plan(root / CAMPAIGN), ModelCard.read(root / CARD_FILE))

    def file(self, name: str) -> Path | None:
        """Return a file that the manifest names; None if the bundle lacks it."""
        file = self.root / name
        return file if file.is_file() and file.is_relative_to(self.root) else None

    def extended(self) -> AbstractContextManager[System]:
        """Return a context in which the managed system has the campaign's extensions; their code runs.

        Raises:
            ExtensionError: on entering the context: an extension cannot be loaded.
        """
        files = {name: self.file(self.manifest.extensions.get(name, "")) for name in self.plan.extensions}
        # an installed extension is not named after a file, and must be installed here, too
        return extended_system(
            [file if file and name.endswith(".py") else name for name, file in files.items()]
        )

    def text(self, error: object) -> str:
        """Return a sentence without the name of the temporary folder."""
        return str(error).replace(f"{self.root}/", "")


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
            "from which the campaign was run; for a class, call sunset.bundle in the program that has it."
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
    sources = {extension.name: Path(extension.source) for extension in loaded_extensions()}
    places = {name: f"extensions/{folder_name(name)}/{file.name}" for name, file in sources.items()}
    return places, {places[name]: file for name, file in sources.items()}


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
    return f"{kind}: the source of {name} ({files or 'which is missing'}) differs from the plan's checksum."


def _content(opened: OpenedBundle, name: str) -> bytes:
    file = opened.file(name)
    return file.read_bytes() if file is not None else b""
