"""The files that tell readers what a bundle is, made of its plan and its citation."""

from collections.abc import Mapping
from typing import Final

from sunset.bundling.citation import Citation
from sunset.bundling.crate import crate_text, description_of
from sunset.bundling.layout import CITATION_FILE, CRATE_FILE, README_FILE
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
