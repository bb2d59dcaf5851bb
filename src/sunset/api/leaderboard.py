"""A leaderboard: bundles are verified, and their managing systems listed on a page."""

import hashlib
import shutil
import tempfile
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from sunset.api.arguments import as_path
from sunset.api.bundling import verify
from sunset.api.bundling.archive import CAMPAIGN, SPLIT, extract_archive
from sunset.api.bundling.sources import OpenedBundle
from sunset.api.bundling.verifying import Verification
from sunset.errors import ExtensionError, InvalidInputError, ManagerError, RecordError
from sunset.evaluation.leaderboard import BUNDLES, Submission, leaderboard_page
from sunset.evaluation.results import load_results
from sunset.files.outputs import draft_of_folder, folder_name
from sunset.processes.workers import Stages
from sunset.scenarios import check_split, read_salt
from sunset.system import REPAIR
from sunset.texts.sentences import counted
from sunset_ros.texts import printable, shown


@dataclass(frozen=True, slots=True)
class Leaderboard:
    """A leaderboard that was written.

    Attributes:
        page: its page.
        listed: the names of the bundles that passed.
        refused: a sentence for each other bundle, after its name.
    """

    page: Path
    listed: tuple[str, ...]
    refused: tuple[str, ...]

    def __str__(self) -> str:
        """Return the lines that `sunset leaderboard` prints."""
        return "\n".join(
            [*self.refused, f"The leaderboard of {counted(len(self.listed), 'bundle')} is {self.page}."]
        )


def leaderboard(
    bundles: Sequence[str | Path],
    out: str | Path,
    *,
    run_again: int = 3,
    seed: int | None = None,
    trust: bool = False,
    salt_file: str | Path | None = None,
    progress: Stages | None = None,
) -> Leaderboard:
    """Verify bundles and write a page with their managing systems, as `sunset leaderboard` does.

    A bundle that does not pass is named on the page with the reason, and has no row. The page loads nothing from
    elsewhere; the bundles are beside it.

    Args:
        bundles: their files, which `bundle` wrote.
        out: the folder of the site, which must not exist, or be empty.
        run_again: as in `verify`, of each bundle.
        seed: as in `verify`.
        trust: as in `verify`.
        salt_file: the published salt of a sealed split, from which each bundle's split is drawn again.
        progress: called with (stage, runs that are computed or run again, all such runs).

    Raises:
        RecordError: a file is missing.
        InvalidInputError: another argument is not usable.
        OutputError: the site cannot be written.
    """
    files, salt = _named(bundles), b""
    notes, listed, refused = [], [], []
    if salt_file is not None:
        salt = read_salt(as_path(salt_file, "salt's file"))
        notes.append(
            f"All scenarios were drawn again from a salt: SHA-256 {hashlib.sha256(salt).hexdigest()}."
        )
    with draft_of_folder(as_path(out, "folder of the site"), "site") as draft:
        (draft / BUNDLES).mkdir()
        for name, file in files.items():
            stage = None if progress is None else partial(progress, f"Verifying {name}")
            copy = draft / BUNDLES / f"{name}.zip"
            shutil.copyfile(file, copy)
            try:
                result = verify(copy, run_again=run_again, seed=seed, trust=trust, progress=stage)
                listed.append(_submission(copy, result, salt, trust=trust))
            except (RecordError, ExtensionError, ManagerError) as error:
                copy.unlink()
                refused.append(printable(f"{name} is refused: {error}".replace(f"{copy.parent}/", "")))
                continue
            text = f"{replace(result, bundle=Path(copy.name))}\n"
            copy.with_suffix(".txt").write_text(text, encoding="utf-8")
        page = leaderboard_page(listed, [*refused, *notes])
        (draft / "index.html").write_text(page, encoding="utf-8")
    return Leaderboard(Path(out) / "index.html", tuple(each.name for each in listed), tuple(refused))


def _named(bundles: Sequence[str | Path]) -> dict[str, Path]:
    """Return the name of each bundle on the page, and its file."""
    if not isinstance(bundles, list | tuple) or not bundles:
        raise InvalidInputError(f"The bundles must be a list of files, got {shown(bundles)}.")
    names: dict[str, Path] = {}
    for file in (as_path(each, "bundle") for each in bundles):
        if not file.is_file():
            raise RecordError(f"There is no bundle {file}: name files that 'sunset bundle' wrote.")
        name = folder_name(file.stem)
        while name in names:
            name = f"{name}-{len(names) + 1}"
        names[name] = file
    return names


def _submission(file: Path, result: Verification, salt: bytes, *, trust: bool) -> Submission:
    """Return what a page says about a bundle; raise a `RecordError` if the bundle is not fit for it."""
    if not (result.passed and result.runs_recomputed):
        *_, verdict = str(result).splitlines()
        reasons = result.problems or result.differences or result.unchecked
        raise RecordError(" ".join([verdict, *reasons[:1]]))
    with tempfile.TemporaryDirectory(prefix="sunset-") as room:
        root = Path(room).resolve() / "bundle"
        extract_archive(file, root)
        opened = OpenedBundle.read(root)
        plan = opened.plan
        if salt:
            try:
                with opened.extended() if trust else nullcontext():
                    check_split(root / SPLIT, salt)
            except InvalidInputError as error:
                raise RecordError(opened.text(error)) from error
        runs = [run for run in load_results(root / CAMPAIGN) if plan.is_of_suite(run.suite, run.manager)]
        if plan.task != REPAIR or not runs:
            raise RecordError(f"No run of its suite {plan.suite} repairs, and a leaderboard ranks repairs.")
        return Submission(
            name=file.stem,
            plan=plan,
            runs=runs,
            date=opened.manifest.date,
            authors=", ".join(opened.manifest.authors),
            again=len(result.runs_again),
        )
