"""What a bundle is, as RO-Crate says it: metadata in JSON-LD that archives and their visitors read.

Source: the RO-Crate Metadata Specification 1.1, https://w3id.org/ro/crate/1.1.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Final
from urllib.parse import quote

from sunset.bundling.citation import (
    ANONYMOUS,
    DEVELOPERS,
    PAPER,
    PAPER_AUTHORS,
    PAPER_YEAR,
    SOFTWARE,
    Citation,
)
from sunset.bundling.layout import CAMPAIGN, CRATE_FILE
from sunset.recording import CampaignPlan
from sunset.texts import counted

_SPECIFICATION: Final = "https://w3id.org/ro/crate/1.1"
_ROOT: Final = "./"
_SOFTWARE: Final = "#sunset"
_DEVELOPERS: Final = "#sunset-developers"
_PAPER: Final = "#paper"
_ACTION: Final = "#campaign"
_NO_LICENCE: Final = "No licence is given: ask the authors before using this."

_MEDIA_TYPES: Final = {
    "cff": "application/yaml",
    "json": "application/json",
    "md": "text/markdown",
    "mcap": "application/octet-stream",
    "py": "text/x-python",
    "txt": "text/plain",
    "yaml": "application/yaml",
    "yml": "application/yaml",
}
"""Media types of files, by the suffixes that bundles have."""

_Entity = dict[str, object]


def description_of(described: CampaignPlan) -> str:
    """Return what a campaign is, in a sentence or two."""
    return (
        f"{counted(described.runs, 'run')} of the SUNSET exemplar: the managing systems "
        f"{', '.join(described.managers)} over the suite {described.suite}, "
        f"{counted(described.repetitions, 'repetition')}, with the model {described.model}. "
        "Each run has its record, a rosbag2 with every message and a file with its figures."
    )


def crate_text(described: CampaignPlan, citation: Citation, sizes: Mapping[str, int]) -> str:
    """Return the text of `ro-crate-metadata.json`.

    Args:
        described: the campaign's plan.
        citation: what the bundle is to be cited by.
        sizes: of the bundle's other files in bytes, by name.
    """
    files = [_file(name, size) for name, size in sorted(sizes.items())]
    people: list[_Entity] = [
        {"@id": author.orcid or f"#author-{number}", "@type": "Person", "name": author.name}
        for number, author in enumerate(citation.authors, 1)
    ] or [{"@id": f"#{ANONYMOUS}", "@type": "Person", "name": ANONYMOUS}]
    licence: _Entity = {"@id": citation.licence_address, "@type": "CreativeWork", "name": citation.licence}
    licence["description"] = f"The bundle may be used under {citation.licence}."
    graph: list[_Entity] = [
        {
            "@id": CRATE_FILE,
            "@type": "CreativeWork",
            "conformsTo": {"@id": _SPECIFICATION},
            "about": {"@id": _ROOT},
        },
        {
            "@id": _ROOT,
            "@type": "Dataset",
            "name": citation.title,
            "description": description_of(described),
            "datePublished": citation.published.isoformat(),
            "license": _links([licence]) if citation.licence else _NO_LICENCE,
            "author": _links(people),
            "citation": {"@id": _PAPER},
            "mentions": {"@id": _ACTION},
            "hasPart": _links(files),
        },
        {
            "@id": _ACTION,
            "@type": "CreateAction",
            "name": "The runs of the campaign",
            "description": description_of(described),
            "agent": _links(people),
            "instrument": {"@id": _SOFTWARE},
            "object": _links([one for one in files if "programmingLanguage" in one]),
            "result": _links([one for one in files if str(one["@id"]).startswith(f"{CAMPAIGN}/")]),
        },
        {
            "@id": _SOFTWARE,
            "@type": "SoftwareApplication",
            "name": SOFTWARE,
            "version": described.versions["sunset"],
            "softwareRequirements": [
                f"{name} {version}" for name, version in described.versions.items() if name != "sunset"
            ],
            "author": {"@id": _DEVELOPERS},
            "citation": {"@id": _PAPER},
        },
        {"@id": _DEVELOPERS, "@type": "Organization", "name": DEVELOPERS},
        {
            "@id": _PAPER,
            "@type": "ScholarlyArticle",
            "name": PAPER,
            "datePublished": str(PAPER_YEAR),
            "author": _links(_PAPER_AUTHORS),
        },
        *_PAPER_AUTHORS,
        *(person for person in people if person not in _PAPER_AUTHORS),
        *([licence] if citation.licence else []),
        *files,
    ]
    content = {"@context": f"{_SPECIFICATION}/context", "@graph": graph}
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _links(entities: Sequence[_Entity]) -> object:
    """Return references to entities; of one, not in a list."""
    links = [{"@id": entity["@id"]} for entity in entities]
    return links[0] if len(links) == 1 else links


def _file(name: str, size: int) -> _Entity:
    suffix = name.rpartition(".")[2]
    is_code = suffix == "py"
    return {
        "@id": quote(name),
        "@type": ["File", "SoftwareSourceCode"] if is_code else "File",
        "name": name,
        "contentSize": str(size),
        "encodingFormat": _MEDIA_TYPES.get(suffix, "text/plain"),
        **({"programmingLanguage": "Python"} if is_code else {}),
    }


_PAPER_AUTHORS: Final[tuple[_Entity, ...]] = tuple(
    {
        "@id": orcid or f"#{family.lower()}",
        "@type": "Person",
        "name": f"{given} {family}",
        "givenName": given,
        "familyName": family,
    }
    for family, given, orcid in PAPER_AUTHORS
)
