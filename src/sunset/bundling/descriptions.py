"""What tells readers what a bundle is: made of its plan and its citation, and compared with them where it is opened."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from sunset.bundling.citation import Citation, read_citation
from sunset.bundling.crate import crate_text, description_of
from sunset.bundling.layout import CHECKSUMS_FILE, CITATION_FILE, CRATE_FILE, README_FILE
from sunset.errors import InvalidInputError
from sunset.input_files import read_text
from sunset.recording import CampaignPlan

_README: Final = """# {title}

{description}

`campaign/bench.json` says what was run, `report.txt` is the table, and `CITATION.cff` says what to cite. With SUNSET
installed, `sunset verify` of the zip file computes every figure from the recorded messages, runs some runs again, and
says what differs. `sunset report` of the folder `campaign` prints the table, and of the folder of a run what happened
in it.
"""


def describe_files(described: CampaignPlan, citation: Citation, sizes: Mapping[str, int]) -> dict[str, str]:
    """Return the texts that tell readers what a bundle is, by the names of their files.

    Args:
        described: the campaign's plan.
        citation: what the bundle is to be cited by.
        sizes: of the bundle's other files in bytes, by name.
    """
    texts = {
        CITATION_FILE: citation.to_cff(),
        README_FILE: _README.format(title=citation.title, description=description_of(described)),
    }
    sizes = {**sizes, **{name: len(text.encode()) for name, text in texts.items()}}
    return texts | {CRATE_FILE: crate_text(described, citation, sizes)}


def differing_descriptions(folder: Path, described: CampaignPlan) -> Iterator[str]:
    """Yield a sentence for each file of an opened bundle that does not tell what its plan and its citation say."""
    try:
        citation = read_citation(read_text(folder / CITATION_FILE))
    except (OSError, UnicodeDecodeError, InvalidInputError):
        yield f"{CITATION_FILE}: it is missing, or is not a citation that 'sunset bundle' writes."
        return
    others = {CITATION_FILE, README_FILE, CRATE_FILE, CHECKSUMS_FILE}
    names = {file.relative_to(folder).as_posix(): file for file in folder.rglob("*") if file.is_file()}
    sizes = {name: file.stat().st_size for name, file in names.items() if name not in others}
    for name, text in describe_files(described, citation, sizes).items():
        try:
            same = read_text(folder / name) == text
        except (OSError, UnicodeDecodeError):
            same = False
        if not same:
            yield f"{name}: it is missing, or does not say what the plan, the citation and the files do."
