"""How far stored campaigns are."""

from pathlib import Path

from sunset.recording.schema import read_plan
from sunset.texts.names import PLAN_FILE, RUN_FILE


def count_runs(out: Path) -> tuple[int, int] | None:
    """Return the numbers of finished and of planned runs of a folder's campaigns; None if it holds no campaign.

    Campaigns in subfolders count, too. Shards of the same campaign, in folders of their own, are counted together.

    Raises:
        RecordError: a campaign's plan is damaged, or of another version.
    """
    campaigns: dict[bytes, tuple[int, set[Path]]] = {}
    for file in sorted([*out.glob(PLAN_FILE), *out.glob(f"*/{PLAN_FILE}")]):
        planned = read_plan(file.parent).runs
        runs = campaigns.setdefault(file.read_bytes(), (planned, set()))[1]
        runs.update(run.relative_to(file.parent) for run in file.parent.glob(f"runs/*/*/*/seed-*/{RUN_FILE}"))
    if not campaigns:
        return None
    return sum(len(runs) for _, runs in campaigns.values()), sum(planned for planned, _ in campaigns.values())
