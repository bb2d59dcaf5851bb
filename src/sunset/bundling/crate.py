"""The files that describe a bundle: README, citation, and metadata for archives, an RO-Crate in JSON-LD.

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
from sunset.bundling.layout import CAMPAIGN, CITATION_FILE, CRATE_FILE, README_FILE
from sunset.recording import CampaignPlan
from sunset.texts import counted

_Entity = dict[str, object]

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
    "yaml": "application/yaml",
    "yml": "application/yaml",
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

_README: Final = """# {title}

{description}

`campaign/bench.json` says what was run, `report.txt` is the table, and `CITATION.cff` says what to cite. With SUNSET
installed, `sunset verify` of the zip file computes every figure from the recorded messages, runs some runs again, and
says what differs. `sunset report` of the folder `campaign` prints the table, and of the folder of a run what happened
in it.
"""


def describing_files(plan: CampaignPlan, citation: Citation, sizes: Mapping[str, int]) -> dict[str, str]:
    """Return the texts that describe a bundle, by file; `sizes` are the other files' names and sizes in bytes."""
    texts = {
        CITATION_FILE: citation.to_cff(),
        README_FILE: _README.format(title=citation.title, description=description_of(plan)),
    }
    sizes = {**sizes, **{name: len(text.encode()) for name, text in texts.items()}}
    return texts | {CRATE_FILE: _crate_text(plan, citation, sizes)}


def description_of(plan: CampaignPlan) -> str:
    """Return a campaign's description, in two sentences."""
    return (
        f"{counted(plan.runs, 'run')} of the SUNSET exemplar: the managing systems {', '.join(plan.managers)} over the "
        f"suite {plan.suite}, {counted(plan.repetitions, 'repetition')}, with the model {plan.model}. "
        "Each run has its record, a rosbag2 with every message and a file with its figures."
    )


def _crate_text(plan: CampaignPlan, citation: Citation, sizes: Mapping[str, int]) -> str:
    files = [_file(name, size) for name, size in sorted(sizes.items())]
    people: list[_Entity] = [
        {"@id": author.orcid or f"#author-{number}", "@type": "Person", "name": author.name}
        for number, author in enumerate(citation.authors, 1)
    ] or [{"@id": f"#{ANONYMOUS}", "@type": "Person", "name": ANONYMOUS}]
    licences: list[_Entity] = [
        {
            "@id": citation.licence_address,
            "@type": "CreativeWork",
            "name": citation.licence,
            "description": f"The bundle may be used under {citation.licence}.",
        }
    ]
    graph = [
        *_dataset(plan, citation, people, files, licences if citation.licence else ()),
        *_sources(plan),
        *(person for person in people if person not in _PAPER_AUTHORS),
        *(licences if citation.licence else ()),
        *files,
    ]
    content = {"@context": f"{_SPECIFICATION}/context", "@graph": graph}
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _dataset(
    plan: CampaignPlan,
    citation: Citation,
    people: Sequence[_Entity],
    files: Sequence[_Entity],
    licences: Sequence[_Entity],
) -> tuple[_Entity, ...]:
    """Return the metadata file, the bundle as a dataset, and the campaign as the action that made it."""
    about: _Entity = {"@id": CRATE_FILE, "@type": "CreativeWork"}
    dataset: _Entity = {
        "@id": _ROOT,
        "@type": "Dataset",
        "name": citation.title,
        "description": description_of(plan),
        "datePublished": citation.published.isoformat(),
        "license": _links(licences) if licences else _NO_LICENCE,
        "author": _links(people),
        "citation": {"@id": _PAPER},
        "mentions": {"@id": _ACTION},
        "hasPart": _links(files),
    }
    action: _Entity = {
        "@id": _ACTION,
        "@type": "CreateAction",
        "name": "The runs of the campaign",
        "description": description_of(plan),
        "agent": _links(people),
        "instrument": {"@id": _SOFTWARE},
        "object": _links([file for file in files if "programmingLanguage" in file]),
        "result": _links([file for file in files if str(file["@id"]).startswith(f"{CAMPAIGN}/")]),
    }
    return about | {"conformsTo": {"@id": _SPECIFICATION}, "about": {"@id": _ROOT}}, dataset, action


def _sources(plan: CampaignPlan) -> tuple[_Entity, ...]:
    """Return SUNSET, its developers, and the paper with its authors."""
    requirements = [f"{name} {version}" for name, version in plan.versions.items() if name != "sunset"]
    software: _Entity = {
        "@id": _SOFTWARE,
        "@type": "SoftwareApplication",
        "name": SOFTWARE,
        "version": plan.versions["sunset"],
        "softwareRequirements": requirements,
        "author": {"@id": _DEVELOPERS},
        "citation": {"@id": _PAPER},
    }
    paper: _Entity = {
        "@id": _PAPER,
        "@type": "ScholarlyArticle",
        "name": PAPER,
        "datePublished": str(PAPER_YEAR),
        "author": _links(_PAPER_AUTHORS),
    }
    developers: _Entity = {"@id": _DEVELOPERS, "@type": "Organization", "name": DEVELOPERS}
    return software, developers, paper, *_PAPER_AUTHORS


def _links(entities: Sequence[_Entity]) -> object:
    """Return references to entities; to a single entity, not in a list."""
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
