"""What a bundle's files are called, and what its manifest says."""

import json
from collections.abc import Mapping
from operator import itemgetter
from pathlib import Path
from typing import Final

import msgspec

from sunset import __version__
from sunset.errors import RecordError
from sunset.input_files import read_text
from sunset.schemas import convert, document_text, read_json
from sunset.texts import printable_json

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
"""The folder that holds the scenario files, where the suite is a folder of such."""


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


def is_exact(file: Path, value: object, versions: Mapping[str, str]) -> bool:
    """Return whether a JSON file has all that a value of its schema has, each key once, and nothing else.

    Args:
        file: that the value was read from.
        value: of the schema.
        versions: with which it was written; what another SUNSET writes is not known.
    """
    if versions.get("sunset") != __version__:
        return True
    return _pairs(read_text(file)) == _pairs(document_text(value))


def _pairs(text: str) -> object:
    """Return the content of a JSON text with sorted pairs in place of objects, so that no key is lost."""
    return printable_json(
        json.loads(
            text, object_pairs_hook=lambda pairs: [list(one) for one in sorted(pairs, key=itemgetter(0))]
        )
    )
