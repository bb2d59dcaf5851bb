"""Whether what a bundle says is so: every figure from its messages, and some runs from the beginning."""

import tempfile
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

from sunset.bundling.archive import count_files, differing_files, extract_archive
from sunset.bundling.checks import Findings, check_campaign, is_of_another_version
from sunset.bundling.crate import description_of
from sunset.bundling.layout import CAMPAIGN, CHECKSUMS_FILE, REPORT_FILE
from sunset.bundling.opened import OpenedBundle
from sunset.bundling.rerunning import Rerun, choose_runs, rerun_run
from sunset.bundling.sources import differing_sources
from sunset.errors import DataError, InvalidInputError, RecordError
from sunset.evaluation import render_report
from sunset.input_files import file_digest, read_text
from sunset.perception import load_model
from sunset.processes.workers import Progress
from sunset.source_files import package_version
from sunset.texts import counted, printable


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """What was found out about a bundle.

    Attributes:
        path: of the file.
        sha256: of the file, in hexadecimal.
        campaign: what it is, in words.
        checked: what was checked, a line each.
        unchecked: a sentence for each thing that could not be checked.
        problems: a sentence for each thing that is damaged, with the file or run that it is about.
        differences: a sentence for each thing that differs, where another version of SUNSET made the bundle.
        recomputed: how many runs' figures were computed again.
        again: the folders, in the campaign's, of the runs that were run again.
        seed: by which these were chosen.
    """

    path: Path
    sha256: str
    campaign: str
    checked: tuple[str, ...]
    unchecked: tuple[str, ...]
    problems: tuple[str, ...]
    differences: tuple[str, ...]
    recomputed: int
    again: tuple[str, ...]
    seed: int

    @property
    def passed(self) -> bool:
        """Whether everything that was checked is as it should be."""
        return not (self.problems or self.differences)

    def __str__(self) -> str:
        """Return it in lines, the verdict last."""
        lines = [f"{self.path}: {self.campaign}", f"SHA-256 {self.sha256}"]
        lines += [f"checked      {text}" for text in self.checked]
        lines += [f"not checked  {text}" for text in self.unchecked]
        lines += [f"differs      {text}" for text in self.differences]
        lines += [f"damaged      {text}" for text in self.problems]
        if self.problems:
            verdict = f"Not verified: {counted(len(self.problems), 'problem')}."
        elif self.differences:
            differing = counted(len(self.differences), "result")
            verdict = f"Not damaged, but made by another version of SUNSET: {differing} of this one differ."
        else:
            verdict = "Verified." if self.recomputed else "Nothing is wrong, but no figure was checked."
        return printable("\n".join([*lines, verdict]))

    def to_json(self) -> dict[str, object]:
        """Return it as JSON values."""
        return {
            "bundle": str(self.path),
            "sha256": self.sha256,
            "campaign": self.campaign,
            "verified": self.passed,
            "checked": list(self.checked),
            "unchecked": list(self.unchecked),
            "problems": list(self.problems),
            "differences": list(self.differences),
            "runs_recomputed": self.recomputed,
            "runs_again": list(self.again),
            "seed": self.seed,
        }


def verify(path: Path, rerun: Rerun, *, progress: Progress | None = None) -> Verification:
    """Check a bundle: its files, its plan, its sources, every figure, and some runs by running them again.

    Nothing in it is executed, unless it is trusted: its managing systems and extensions are programs.

    Args:
        path: of the file.
        rerun: which runs are run again, and with what.
        progress: called with (runs that are computed or run again, such runs in all).

    Raises:
        RecordError: it is not a bundle, is of another version, or is not fit to be opened.
        ModelError: the model to run with cannot be used.
        DataError: there is no such bag.
        OutputError: there is no space to open it.
    """
    if rerun.model is not None:
        load_model(rerun.model)
    if rerun.bag is not None and not rerun.bag.exists():
        raise DataError(f"There is no bag {rerun.bag}: name the campaign's, or leave it out.")
    with tempfile.TemporaryDirectory(prefix="sunset-") as room:
        root = Path(room).resolve() / "bundle"
        root.mkdir()
        extract_archive(path, root)
        try:
            opened = OpenedBundle.read(root)
        except InvalidInputError as error:
            sentence = str(error).replace(f"{root}/", "")
            raise RecordError(f"The bundle {path} cannot be verified: {sentence}") from error
        problems = [*differing_files(root), *differing_sources(root, opened.described, opened.manifest)]
        if problems:  # what is trusted is what the campaign was run with
            rerun = replace(rerun, trust=False)
        with opened.extended() if rerun.trust else nullcontext():
            return _verify(path, opened, rerun, problems=problems, room=Path(room), progress=progress)


def _verify(
    path: Path,
    opened: OpenedBundle,
    rerun: Rerun,
    *,
    problems: list[str],
    room: Path,
    progress: Progress | None,
) -> Verification:
    """Check the campaign of a bundle in whose files and sources these problems were found; `room` is for new runs."""
    described = opened.described
    total = described.runs + min(rerun.number, described.runs)

    def update(done: int, _: int) -> None:
        if progress is not None:
            progress(done, total)

    findings = check_campaign(opened.campaign, described, opened.card, update)
    other = is_of_another_version(described)
    if other:
        findings.unchecked.append(
            f"SUNSET {described.versions.get('sunset')} made the bundle, and this is {package_version()}: its code "
            "differs, and so may results. Use that version to tell."
        )
    problems = [*problems, *(f"{CAMPAIGN}/{problem}" for problem in findings.problems)]
    differences = [f"{CAMPAIGN}/{difference}" for difference in findings.differences]
    results = differences if other else problems
    results += _other_table(opened, findings)
    chosen = choose_runs(opened, findings, rerun)
    for done, place in enumerate(chosen, 1):
        name = place.relative_to(opened.root).as_posix()
        again = rerun_run(opened, place, findings, rerun, room / f"again-{done}")
        results += [f"{name}: {text}" for text in again]
        update(described.runs + done, 0)
    return Verification(
        path=path,
        sha256=file_digest(path),
        campaign=description_of(described),
        checked=tuple(_checked(opened, findings, rerun, len(chosen))),
        unchecked=tuple(findings.unchecked),
        problems=tuple(map(opened.text, problems)),
        differences=tuple(map(opened.text, differences)),
        recomputed=findings.recomputed,
        again=tuple(place.relative_to(opened.campaign).as_posix() for place in chosen),
        seed=rerun.seed,
    )


def _checked(opened: OpenedBundle, findings: Findings, rerun: Rerun, again: int) -> Iterator[str]:
    described = opened.described
    yield f"files: {count_files(opened.root)} against {CHECKSUMS_FILE}"
    yield f"plan: {counted(described.runs, 'run')}, what each is, and that there is no other"
    yield (
        f"sources: {counted(len(described.managers), 'managing system')}, "
        f"{counted(len(described.extensions), 'extension')}"
    )
    if findings.recomputed:
        yield f"figures: {counted(findings.recomputed, 'run')}, computed from the messages, and the table"
    if again:
        yield f"again: {counted(again, 'run')}, chosen by --seed {rerun.seed}, compared by digest and figures"


def _other_table(opened: OpenedBundle, findings: Findings) -> Iterator[str]:
    """Yield a sentence if the table in the bundle is not that of its runs."""
    try:
        same = read_text(opened.root / REPORT_FILE) == render_report(opened.campaign)
    except (OSError, UnicodeDecodeError):
        yield f"{REPORT_FILE}: it is missing, or not a text."
        return
    except RecordError as error:
        yield f"{REPORT_FILE}: it could not be compared: {error}"
        return
    if same:
        return
    if findings.extended:
        yield f"{REPORT_FILE}: it is not the table of the figures that the runs have."
    else:
        findings.unchecked.append(
            f"The table in {REPORT_FILE} was not compared, since that needs the campaign's extensions, too."
        )
