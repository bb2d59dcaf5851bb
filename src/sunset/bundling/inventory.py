"""Which files a bundle consists of: what stands in it besides them was never part of a campaign."""

from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Final

from sunset.bundling.layout import (
    CAMPAIGN,
    CARD_FILE,
    CHECKSUMS_FILE,
    CITATION_FILE,
    CRATE_FILE,
    MANIFEST_FILE,
    README_FILE,
    REPORT_FILE,
    SCENARIOS,
)
from sunset.bundling.opened import OpenedBundle
from sunset.recording import BAG_FILES, PLAN_FILE, RUN_FILE
from sunset.scenarios import SPLIT_FILE, scenario_files, suite_names

_ALWAYS: Final = frozenset(
    {
        CARD_FILE,
        CHECKSUMS_FILE,
        CITATION_FILE,
        CRATE_FILE,
        MANIFEST_FILE,
        README_FILE,
        REPORT_FILE,
        f"{CAMPAIGN}/{PLAN_FILE}",
    }
)


def added_files(opened: OpenedBundle) -> Iterator[str]:
    """Yield a sentence for each file of an opened bundle that is not a part of one."""
    manifest = opened.manifest
    known = _ALWAYS | {file for place in manifest.managers.values() for file in place.files}
    known |= set(manifest.extensions.values())
    own = opened.root / SCENARIOS
    if opened.described.suite not in suite_names() and own.is_dir():
        known |= {f"{SCENARIOS}/{file.name}" for file in scenario_files(own)}
    if opened.described.split:
        known |= {f"{SCENARIOS}/{SPLIT_FILE}"}
    runs = opened.campaign.glob(f"runs/*/*/*/*/{RUN_FILE}")
    known |= {
        (run.parent / name).relative_to(opened.root).as_posix()
        for run in runs
        for name in (RUN_FILE, *BAG_FILES)
    }
    found = {file.relative_to(opened.root).as_posix() for file in opened.root.rglob("*") if file.is_file()}
    for name in sorted(found - known, key=PurePosixPath):
        yield f"{name}: no bundle has such a file."
