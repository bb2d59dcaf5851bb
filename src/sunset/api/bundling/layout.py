"""The files of a bundle, its manifest, and a bundle that was opened into a folder."""

from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Final

import msgspec

from sunset.errors import RecordError
from sunset.files.outputs import folder_name
from sunset.files.schemas import convert, read_json
from sunset.perception import ModelCard
from sunset.recording import CampaignPlan, read_plan
from sunset.system import System, extended_system

BUNDLE_VERSION: Final = 1
"""The version of the layout of bundles."""

MANIFEST_FILE: Final = "bundle.json"
CHECKSUMS_FILE: Final = "SHA256SUMS"
CRATE_FILE: Final = "ro-crate-metadata.json"
CITATION_FILE: Final = "CITATION.cff"
README_FILE: Final = "README.md"
REPORT_FILE: Final = "report.txt"
CARD_FILE: Final = "model/card.json"
CAMPAIGN: Final = "campaign"
"""The folder of the plan and the runs."""
SCENARIOS: Final = "scenarios"
"""The folder of the scenarios of all runs, by suite, and of a split."""


class ManagerSources(msgspec.Struct, frozen=True, kw_only=True):
    """The source of a managing system in a bundle.

    Attributes:
        files: the files of its checksum, in their order.
        load: its name for loading, with paths in the bundle; empty for a class that was passed in Python.
    """

    files: tuple[str, ...]
    load: str = ""


class Manifest(msgspec.Struct, frozen=True, kw_only=True):
    """The content of `bundle.json`: the sources of managing systems, and the source file of each extension, by name."""

    bundle_version: int = BUNDLE_VERSION
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
        return cls(root, _read_manifest(root), read_plan(root / CAMPAIGN), ModelCard.read(root / CARD_FILE))

    def file(self, name: str) -> Path | None:
        """Return a file that the manifest names; None if the bundle lacks it."""
        is_inside = not PurePosixPath(name).is_absolute() and ".." not in PurePosixPath(name).parts
        return self.root / name if is_inside and (self.root / name).is_file() else None

    def extended(self) -> AbstractContextManager[System]:
        """Return a context in which the managed system has the campaign's extensions; their code runs.

        Raises:
            ExtensionError: on entering the context: an extension cannot be loaded.
        """
        places: list[str | Path] = []
        for name in self.plan.extensions:
            file = self.file(self.manifest.extensions.get(name, ""))
            # an installed extension is not named after a file, and must be installed here, too
            places.append(file if file is not None and name.endswith(".py") else name)
        return extended_system(places)

    def text(self, error: object) -> str:
        """Return a sentence without the name of the temporary folder."""
        return str(error).replace(f"{self.root}/", "")


def _read_manifest(folder: Path) -> Manifest:
    file = folder / MANIFEST_FILE
    missing = f"It is not a bundle: {MANIFEST_FILE} is missing; name a file that 'sunset bundle' wrote."
    content = read_json(file, "The manifest", RecordError, missing=missing)
    version = content.get("bundle_version") if isinstance(content, dict) else BUNDLE_VERSION
    if version != BUNDLE_VERSION:
        raise RecordError(
            f"The bundle is of version {version!r}, expected {BUNDLE_VERSION}; verify it with the SUNSET that wrote it."
        )
    return convert(content, Manifest, str(file), RecordError, remedy="take the bundle as it was published")
