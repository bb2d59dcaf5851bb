"""The metadata of a bundle for archives: an RO-Crate in JSON-LD.

Source: the RO-Crate Metadata Specification 1.1, https://w3id.org/ro/crate/1.1.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Final
from urllib.parse import quote

from sunset.api.bundling.archive import CRATE_FILE
from sunset.api.bundling.citation import SOFTWARE, parse_author

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


def _link(entity: Mapping[str, object]) -> _Entity:
    return {"@id": entity["@id"]}
