"""A bundle that was opened into a temporary folder: what is in it, where."""

from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

from sunset.bundling.layout import CAMPAIGN, CARD_FILE, Manifest, read_manifest
from sunset.bundling.sources import bundle_file
from sunset.perception import ModelCard
from sunset.recording import CampaignPlan, read_plan
from sunset.system import System, extended_system


@dataclass(frozen=True)
class OpenedBundle:
    """A bundle's files in a folder, as they came.

    Attributes:
        root: the folder.
        manifest: says where sources are.
        described: the campaign's plan.
        card: of its model.
    """

    root: Path
    manifest: Manifest
    described: CampaignPlan
    card: ModelCard

    @classmethod
    def read(cls, root: Path) -> "OpenedBundle":
        """Read what says what is in it.

        Raises:
            InvalidInputError: it is missing, damaged, or of another version.
        """
        manifest = read_manifest(root)
        return cls(root, manifest, read_plan(root / CAMPAIGN), ModelCard.read(root / CARD_FILE))

    @property
    def campaign(self) -> Path:
        """The folder of the campaign."""
        return self.root / CAMPAIGN

    def extended(self) -> AbstractContextManager[System]:
        """Return a context in which the managed system has the campaign's extensions, whose code that runs.

        Raises:
            ExtensionError: one cannot be loaded, which is found when the context is entered.
        """
        wheres: list[str | Path] = []
        for name in self.described.extensions:
            file = bundle_file(self.root, self.manifest.extensions.get(name, ""))
            # one that was installed goes by another name than its file's, and must be installed here
            wheres.append(file if file is not None and name.endswith(".py") else name)
        return extended_system(wheres)

    def text(self, error: object) -> str:
        """Return what a sentence says, without the temporary folder's name."""
        return str(error).replace(f"{self.root}/", "")
