"""What a bundle's files are called, and what its manifest says."""

from pathlib import Path
from typing import Final

import msgspec

from sunset.errors import RecordError
from sunset.schemas import convert, read_json

BUNDLE_VERSION: Final = 1
"""The version of the layout of bundles."""

MANIFEST_FILE: Final = "bundle.json"
CHECKSUMS_FILE: Final = "SHA256SUMS"
CRATE_FILE: Final = "ro-crate-metadata.json"
"""As the specification of RO-Crate calls it."""
CITATION_FILE: Final = "CITATION.cff"
README_FILE: Final = "README.md"
REPORT_FILE: Final = "report.txt"
CARD_FILE: Final = "model/card.json"
CAMPAIGN: Final = "campaign"
"""The folder that holds the plan and the runs, as in the folder of the campaign itself."""
SCENARIOS: Final = "scenarios"
"""The folder that holds the scenarios of all runs, by suite, and a split as it was drawn."""


class ManagerSources(msgspec.Struct, frozen=True, kw_only=True):
    """Where the source of a managing system is.

    Attributes:
        files: that its checksum is made of, in this order.
        load: as what it can be loaded, `path/to/file.py:Class` in the bundle, or `module:Class` from `folder`; empty if
            it cannot, as a class of a notebook.
        folder: what the modules are in.
    """

    files: tuple[str, ...]
    load: str = ""
    folder: str = ""


class Manifest(msgspec.Struct, frozen=True, kw_only=True):
    """What `bundle.json` says.

    Attributes:
        bundle_version: of the layout.
        managers: name in the campaign → where its source is.
        extensions: name → the file with its source.
    """

    bundle_version: int = BUNDLE_VERSION
    managers: dict[str, ManagerSources]
    extensions: dict[str, str]


def read_manifest(folder: Path) -> Manifest:
    """Return what the manifest of an opened bundle says.

    Raises:
        RecordError: it is missing or damaged, does not fit the schema, or is of another version.
    """
    file = folder / MANIFEST_FILE
    missing = f"It is not a bundle: {MANIFEST_FILE} is missing; name a file that 'sunset bundle' wrote."
    content = read_json(file, "The manifest", RecordError, missing=missing)
    version = content.get("bundle_version") if isinstance(content, dict) else BUNDLE_VERSION
    if version != BUNDLE_VERSION:
        raise RecordError(
            f"The bundle is of version {version!r}, expected {BUNDLE_VERSION}; verify it with the SUNSET that wrote it."
        )
    return convert(content, Manifest, str(file), RecordError, remedy="take the bundle as it was published")
