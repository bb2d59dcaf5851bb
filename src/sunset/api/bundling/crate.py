"""The files that describe a bundle: README, citation, and metadata for archives, an RO-Crate in JSON-LD.

Source: the RO-Crate Metadata Specification 1.1, https://w3id.org/ro/crate/1.1.
"""

import json
from collections.abc import Mapping, Sequence
from typing import Final
from urllib.parse import quote

from sunset.api.bundling.citation import ANONYMOUS, SOFTWARE, Author, Citation
from sunset.api.bundling.layout import CITATION_FILE, CRATE_FILE, README_FILE
from sunset.recording import CampaignPlan
from sunset.texts.sentences import counted

_Entity = dict[str, object]

_SPECIFICATION: Final = "https://w3id.org/ro/crate/1.1"
_ROOT: Final = "./"
_SOFTWARE: Final = "#sunset"
_NO_LICENCE: Final = "No licence is given: ask the authors before using this."
_MEDIA_TYPES: Final = {
    "json": "application/json",
    "md": "text/markdown",
    "mcap": "application/octet-stream",
    "py": "text/x-python",
    "yaml": "application/yaml",
}
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
    people: list[_Entity] = [
        {"@id": author.orcid or f"#author-{number}", "@type": "Person", "name": author.name}
        for number, author in enumerate(citation.authors or (Author(ANONYMOUS),), 1)
    ]
    licence: _Entity = {"@id": citation.licence_address, "@type": "CreativeWork", "name": citation.licence}
    licence["description"] = f"The bundle may be used under {citation.licence}."
    licences = [licence] if citation.licence else []
    files = [_file(name, size) for name, size in sorted(sizes.items())]
    metadata: _Entity = {"@id": CRATE_FILE, "@type": "CreativeWork", "about": {"@id": _ROOT}}
    dataset: _Entity = {
        "@id": _ROOT,
        "@type": "Dataset",
        "name": citation.title,
        "description": description_of(plan),
        "datePublished": citation.published.isoformat(),
        "license": _links(licences) if licences else _NO_LICENCE,
        "author": _links(people),
        "mentions": {"@id": _SOFTWARE},
        "hasPart": _links(files),
    }
    software = {"@id": _SOFTWARE, "@type": "SoftwareApplication", "name": SOFTWARE}
    graph = [
        metadata | {"conformsTo": {"@id": _SPECIFICATION}},
        dataset,
        software | {"version": plan.versions["sunset"]},
        *people,
        *licences,
        *files,
    ]
    content = {"@context": f"{_SPECIFICATION}/context", "@graph": graph}
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def _links(entities: Sequence[_Entity]) -> object:
    """Return references to entities; to a single entity, not in a list."""
    links = [{"@id": entity["@id"]} for entity in entities]
    return links[0] if len(links) == 1 else links


def _file(name: str, size: int) -> _Entity:
    media_type = _MEDIA_TYPES.get(name.rpartition(".")[2], "text/plain")
    file: _Entity = {"@id": quote(name), "@type": "File", "name": name, "contentSize": str(size)}
    return file | {"encodingFormat": media_type}
