"""The metadata of a bundle for archives: an RO-Crate in JSON-LD.

Source: the RO-Crate Metadata Specification 1.1, https://w3id.org/ro/crate/1.1.
"""

import json
from collections.abc import Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Final
from urllib.parse import quote

from sunset.api.bundling.archive import CRATE_FILE
from sunset.api.bundling.citation import SOFTWARE, parse_author
from sunset.errors import RecordError
from sunset.files.schemas import read_json
from sunset.texts.sentences import described_error
from sunset_ros.texts import printable

NO_LICENCE: Final = "No licence is given: ask the authors before using this."
_SPECIFICATION: Final = "https://w3id.org/ro/crate/1.1"
_MEDIA_TYPES: Final = {
    "json": "application/json",
    "md": "text/markdown",
    "mcap": "application/octet-stream",
    "py": "text/x-python",
    "yaml": "application/yaml",
}

_Entity = dict[str, object]


def crate_text(
    about: Mapping[str, str], authors: Sequence[str], licence: str, version: str, sizes: Mapping[str, int]
) -> str:
    """Return the metadata of a bundle.

    Args:
        about: its `name`, `description` and `datePublished`.
        authors: as in `parse_author`; anonymous if empty.
        licence: its name in SPDX or its address; may be empty.
        version: of SUNSET.
        sizes: the other files, and their sizes in bytes.
    """
    people = [
        {"@id": person.get("orcid", f"#author-{number}"), "@type": "Person", "name": person["name"]}
        for number, person in enumerate(map(parse_author, authors or ["anonymous"]), 1)
    ]
    terms: _Entity = {
        "@id": licence if "://" in licence else f"https://spdx.org/licenses/{licence}",
        "@type": "CreativeWork",
        "name": licence,
        "description": f"The bundle may be used under {licence}.",
    }
    files = [
        {
            "@id": quote(name),
            "@type": "File",
            "name": name,
            "contentSize": str(size),
            "encodingFormat": _MEDIA_TYPES.get(name.rpartition(".")[2], "text/plain"),
        }
        for name, size in sorted(sizes.items())
    ]
    software = {"@id": "#sunset", "@type": "SoftwareApplication", "name": SOFTWARE, "version": version}
    dataset = {
        "@id": "./",
        "@type": "Dataset",
        **about,
        "license": _link(terms) if licence else NO_LICENCE,
        "author": [_link(person) for person in people],
        "mentions": _link(software),
        "hasPart": [_link(file) for file in files],
    }
    metadata = {"@id": CRATE_FILE, "@type": "CreativeWork", "about": _link(dataset)}
    metadata["conformsTo"] = {"@id": _SPECIFICATION}
    graph = [metadata, dataset, software, *people, *([terms] if licence else []), *files]
    content = {"@context": f"{_SPECIFICATION}/context", "@graph": graph}
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def publication(file: Path) -> tuple[str, tuple[str, ...]]:
    """Return the day of publication, such as 2026-03-14, and the authors' names, from the metadata of a bundle.

    Raises:
        RecordError: the file is missing or damaged, or lacks them.
    """
    content = read_json(file, "The metadata", RecordError)
    try:
        entities = {entity["@id"]: entity for entity in content["@graph"]}  # type: ignore[index]  # see below
        root = entities["./"]
        names = tuple(printable(entities[author["@id"]]["name"]) for author in root["author"])
        return date.fromisoformat(root["datePublished"]).isoformat(), names
    except (AttributeError, KeyError, TypeError, ValueError) as error:
        raise RecordError(
            f"{CRATE_FILE} lacks the bundle's date or authors, {described_error(error)}: take the bundle as it was "
            "published."
        ) from error


def _link(entity: Mapping[str, object]) -> _Entity:
    return {"@id": entity["@id"]}
