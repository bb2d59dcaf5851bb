"""A leaderboard: bundles are verified, and their managing systems listed on a page."""

import hashlib
import shutil
import tempfile
import zipfile
from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from sunset.api.arguments import as_path
from sunset.api.bundling import verify
from sunset.api.bundling.archive import CAMPAIGN, CRATE_FILE, SPLIT, extract_archive
from sunset.api.bundling.crate import publication
from sunset.api.bundling.sources import OpenedBundle
from sunset.api.bundling.verifying import Verification, check_choice
from sunset.errors import InvalidInputError, RecordError, SunsetError
from sunset.evaluation.leaderboard import BUNDLES, Group, Submission, leaderboard_page
from sunset.evaluation.results import load_results
from sunset.experiments import scenario_of
from sunset.files.inputs import file_digest
from sunset.files.outputs import draft_of_folder, folder_name
from sunset.processes.workers import Stages
from sunset.recording import RunRecord, read_run
from sunset.scenarios import SplitDescription, check_split, read_salt, read_split
from sunset.texts.names import RUN_FILE
from sunset.texts.sentences import counted
from sunset_ros.texts import shown


@dataclass(frozen=True, slots=True)
class Leaderboard:
    """A leaderboard that was written.

    Attributes:
        page: its page.
        listed: the names of the bundles with a row.
        refused: the name of each other bundle → the reason, in a sentence.
    """

    page: Path
    listed: tuple[str, ...]
    refused: dict[str, str]

    def __str__(self) -> str:
        """Return the lines that `sunset leaderboard` prints."""
        lines = [f"{name} is refused: {reason}" for name, reason in self.refused.items()]
        return "\n".join(
            [*lines, f"The leaderboard of {counted(len(self.listed), 'bundle')} is {self.page}."]
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
        bundles: their files, which `bundle` wrote; of equal rows, the first is listed.
        out: the folder of the site, which must not exist, or be empty.
        run_again: as in `verify`, of each bundle.
        seed: as in `verify`.
        trust: as in `verify`.
        salt_file: the published salt of a sealed split, which is drawn again.
        progress: called with (stage, runs that are computed or run again, all such runs).

    Raises:
        RecordError: a file is missing, or is not a zip file.
        InvalidInputError: another argument is not usable, or no bundle has a split of this salt.
        OutputError: the site cannot be written.
    """
    if not isinstance(bundles, list | tuple) or not bundles:
        raise InvalidInputError(f"The bundles must be a list of files, got {shown(bundles)}.")
    files = [as_path(each, "bundle") for each in bundles]
    for file in files:
        if not file.is_file() or not zipfile.is_zipfile(file):
            raise RecordError(f"{file} is not a bundle: name files that 'sunset bundle' wrote.")
    choice = check_choice(run_again, seed)
    salt = None if salt_file is None else read_salt(as_path(salt_file, "salt's file"))
    with draft_of_folder(as_path(out, "folder of the site"), "site") as draft:
        (draft / BUNDLES).mkdir()
        board = _Board(draft / BUNDLES, choice, trust, salt)
        for file in files:
            board.add(file, progress)
        if salt and not any(each.is_drawn_again for each in board.submissions.values()):
            raise InvalidInputError(
                f"No bundle that passed has a split of the salt in {salt_file}, whose SHA-256 is {_sha256(salt)}: name "
                "the published salt, or leave it out."
            )
        page = leaderboard_page([*board.groups.values()], [*board.submissions.values()], board.refused)
        (draft / "index.html").write_text(page, encoding="utf-8")
    return Leaderboard(Path(out) / "index.html", tuple(board.submissions), board.refused)


@dataclass
class _Board:
    """A leaderboard that is being written, with the folder of its bundles, and the arguments for their verification."""

    folder: Path
    choice: tuple[int, int]
    trust: bool
    salt: bytes | None
    groups: dict[bytes, Group] = field(default_factory=dict)
    submissions: dict[str, Submission] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)

    def add(self, file: Path, progress: Stages | None) -> None:
        """List the managing systems of a bundle, or note why it is refused."""
        name = slug = folder_name(file.stem)
        while name in self.submissions or name in self.refused:
            name = f"{slug}-{len(self.submissions) + len(self.refused) + 1}"
        stage = None if progress is None else partial(progress, f"Verifying {name}")
        number, seed = self.choice
        copy, result = (self.folder / f"{name}.{kind}" for kind in ("zip", "txt"))
        shutil.copyfile(file, copy)
        try:
            for other, submission in self.submissions.items():
                if submission.sha256 == file_digest(copy):
                    raise RecordError(f"it is the same file as {other}.")
            found = verify(copy, run_again=number, seed=seed, trust=self.trust, progress=stage)
            _check_passed(found)
            submission = self._read(copy, found)
            self.groups.setdefault(submission.group, Group()).add(submission)
        except SunsetError as error:
            copy.unlink()
            self.refused[name] = str(error).replace(f"{self.folder}/", "")
            return
        self.submissions[name] = submission
        result.write_text(f"{replace(found, bundle=Path(copy.name))}\n", encoding="utf-8")

    def _read(self, copy: Path, found: Verification) -> Submission:
        """Return the content of a bundle that passed."""
        with tempfile.TemporaryDirectory(prefix="sunset-") as room:
            root = Path(room).resolve() / "bundle"
            extract_archive(copy, root)
            opened = OpenedBundle.read(root)
            plan, campaign = opened.plan, root / CAMPAIGN
            records = [read_run(file.parent) for file in sorted(campaign.glob(f"runs/*/*/*/*/{RUN_FILE}"))]
            of_suite = [run for run in records if plan.is_of_suite(run.suite, run.manager)]
            if not of_suite:
                raise RecordError(f"it has no run of its suite {plan.suite}.")
            split, is_drawn_again = self._split(opened)
            date, authors = publication(root / CRATE_FILE)
            return Submission(
                name=copy.stem,
                plan=plan,
                runs=[run for run in load_results(campaign) if plan.is_of_suite(run.suite, run.manager)],
                scenarios=_scenarios(of_suite),
                split=split,
                is_drawn_again=is_drawn_again,
                date=date,
                authors=", ".join(authors),
                again=Counter(read_run(campaign / place).manager for place in found.runs_again),
                sha256=found.sha256,
            )

    def _split(self, opened: OpenedBundle) -> tuple[SplitDescription | None, bool]:
        """Return the split of a bundle, and whether it was drawn again, as far as its salt is known."""
        folder = opened.root / SPLIT
        split = read_split(folder) if opened.plan.split else None
        known = {None: b""} | ({_sha256(self.salt): self.salt} if self.salt else {})
        if split is None or split.salt_sha256 not in known:
            return split, False
        try:
            with opened.extended() if self.trust else nullcontext():
                check_split(folder, known[split.salt_sha256])
        except InvalidInputError as error:
            raise RecordError(opened.text(error)) from error
        return split, True


def _check_passed(found: Verification) -> None:
    """Raise with the first problem of a bundle, if it has any."""
    texts = found.problems or found.differences
    if texts:
        more = f" (and {counted(len(texts) - 1, 'other problem')})" if len(texts) > 1 else ""
        version = "" if found.problems else " of this version of SUNSET"
        raise RecordError(f"it does not pass 'sunset verify'{version}{more}: {texts[0]}")
    if not found.runs_recomputed:
        raise RecordError(f"no figure of it was checked: {' '.join(found.unchecked)}")


def _scenarios(records: Iterable[RunRecord]) -> str:
    """Return the SHA-256 of the scenarios of runs, and of their flights."""
    texts = {f"{scenario_of(run).to_yaml()}{run.bag_checksum}" for run in records}
    return _sha256("".join(sorted(texts)).encode())


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
