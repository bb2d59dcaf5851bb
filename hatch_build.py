"""Metadata that pyproject.toml cannot hold: addresses, and a README whose links work on a package index."""

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface


class Metadata(MetadataHookInterface):
    """Takes the repository's address from CITATION.cff, the only file that has it."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add the README and the addresses."""
        citation = Path(self.root, "CITATION.cff").read_text(encoding="utf-8")
        facts = dict(re.findall(r'^([a-z-]+): "?([^"\n]+)"?$', citation, re.MULTILINE))
        repository, tag = facts["repository-code"], f"v{facts['version']}"

        def absolute(link: re.Match[str]) -> str:
            kind = "raw" if link[1].endswith((".webp", ".png")) else "blob"
            return f"]({repository}/{kind}/{tag}/{link[1]})"

        text = Path(self.root, "README.md").read_text(encoding="utf-8").replace("REPOSITORY", repository)
        text = re.sub(r"\]\((?!https?:|#)([^)]+)\)", absolute, text)
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
        metadata["urls"] = {
            "Repository": repository,
            "Documentation": f"{repository}/tree/{tag}/docs",
            "Changelog": f"{repository}/blob/{tag}/CHANGELOG.md",
        }
