"""The verification of a bundle: its files, every figure, and second runs."""

import secrets
import shlex
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final

from msgspec import UNSET, structs

from sunset.api.arguments import as_path, optional_path, whole_of
from sunset.api.bundling.archive import (
    CAMPAIGN,
    CHECKSUMS_FILE,
    REPORT_FILE,
    differing_files,
    extract_archive,
)
from sunset.api.bundling.checks import Findings, check_campaign
from sunset.api.bundling.packing import description_of
from sunset.api.bundling.sources import ManagerSources, OpenedBundle, differing_sources, manager_folder
from sunset.errors import DataError, InvalidInputError, ManagerError, RecordError
from sunset.evaluation.report import format_runs
from sunset.evaluation.results import load_results
from sunset.experiments import campaign_managers, model_checksum, run_again
from sunset.files.inputs import file_digest, read_text
from sunset.files.sources import import_from, package_version
from sunset.managing import MANAGERS, PREFIX
from sunset.perception import list_models, load_model
from sunset.processes.workers import Progress
from sunset.recording import RunRecord
from sunset.texts.sentences import counted
from sunset_ros.rmw.backends import SIMULATED
from sunset_ros.seeding import check_seed, generator
from sunset_ros.texts import printable, shown

_SEEDS: Final = 2**32
_OF_THIS_COMPUTER: Final = {"versions", "manager_versions", "missing_walls", "manager_spec", "flight"}
"""Fields of a record that may differ in a second run: places, names, and versions."""


@dataclass(frozen=True)
class _Rerun:
    """The greatest number of second runs, the seed of their choice, and the arguments of `sunset.verify` for them."""

    number: int
    seed: int
    trust: bool = False
    model: str | None = None
    bag: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Verification:
    """The result of `verify`.

    Attributes:
        checked: a line for each kind of check.
        unchecked: a sentence for each thing that could not be checked.
        problems: a sentence for each problem, after the file or run.
        differences: a sentence for each result that differs, if another version of SUNSET made the bundle.
        runs_recomputed: how many runs' figures were computed again.
        runs_again: the folders of the runs that were repeated, chosen by `seed`.
    """

    bundle: Path
    sha256: str
    campaign: str
    checked: tuple[str, ...]
    unchecked: tuple[str, ...]
    problems: tuple[str, ...]
    differences: tuple[str, ...]
    runs_recomputed: int
    runs_again: tuple[str, ...]
    seed: int

    @property
    def passed(self) -> bool:
        """Whether everything that was checked is in order."""
        return not (self.problems or self.differences)

    def __str__(self) -> str:
        """Return lines of text, the verdict last."""
        lines = [f"{self.bundle}: {self.campaign}", f"SHA-256 {self.sha256}"]
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
            verdict = "Verified." if self.runs_recomputed else "Nothing is wrong, but no figure was checked."
        return printable("\n".join([*lines, verdict]))

    def to_json(self) -> dict[str, object]:
        """Return the result as JSON values."""
        return asdict(self) | {"bundle": str(self.bundle), "verified": self.passed}


def verify(
    path: str | Path,
    *,
    run_again: int = 3,
    seed: int | None = None,
    trust: bool = False,
    model: str | Path | None = None,
    bag: str | Path | None = None,
    progress: Progress | None = None,
) -> Verification:
    """Check a bundle, as `sunset verify` does: every figure, and some runs by running them again.

    Nothing in the bundle is executed, unless it is trusted.

    Args:
        path: of the file.
        run_again: how many runs are run again, chosen at random among those that can be.
        seed: of the choice; drawn at random if None, so that the choice is not known beforehand.
        trust: whether the bundle's own managing systems and extensions, which are programs, may run.
        model: the folder of the campaign's model, if it is not installed.
        bag: the campaign's bag, if it is not the default flight.
        progress: called with (runs that are computed or run again, all such runs).

    Raises:
        RecordError: it is not a bundle, is of another version, or is not fit to be opened.
        InvalidInputError: another argument is not usable.
    """
    number, file = whole_of(run_again), as_path(path, "bundle")
    if type(number) is not int or number < 0:
        raise InvalidInputError(
            f"The number of runs to run again must be at least 0, got {shown(run_again)}."
        )
    rerun = _Rerun(
        number=number,
        seed=secrets.randbelow(_SEEDS) if seed is None else check_seed(whole_of(seed)),
        trust=trust,
        model=None if model is None else str(as_path(model, "model")),
        bag=optional_path(bag, "bag"),
    )
    if rerun.model is not None:
        load_model(rerun.model)
    if rerun.bag is not None and not rerun.bag.exists():
        raise DataError(f"There is no bag {rerun.bag}: name the campaign's, or leave it out.")
    with tempfile.TemporaryDirectory(prefix="sunset-") as room:
        root = Path(room).resolve() / "bundle"
        extract_archive(file, root)
        try:
            opened = OpenedBundle.read(root)
        except InvalidInputError as error:
            sentence = str(error).replace(f"{root}/", "")
            raise RecordError(f"The bundle {file} cannot be verified: {sentence}") from error
        problems = [*differing_files(root), *differing_sources(opened)]
        if problems:  # only the code that the campaign was run with is trusted
            rerun = replace(rerun, trust=False)
        with opened.extended() if rerun.trust else nullcontext():
            return _verify(file, opened, rerun, problems, progress)


def _verify(
    path: Path, opened: OpenedBundle, rerun: _Rerun, problems: list[str], progress: Progress | None
) -> Verification:
    """Check the campaign of a bundle; `problems` were found in its files and sources."""
    plan = opened.plan
    total = plan.runs + min(rerun.number, plan.runs)

    def update(done: int, _: int = 0) -> None:
        if progress is not None:
            progress(done, total)

    findings = check_campaign(opened.root / CAMPAIGN, plan, opened.card, opened.root, update)
    if findings.of_another_version:
        findings.unchecked.append(
            f"SUNSET {plan.versions.get('sunset')} made the bundle, and this is {package_version()}: its code differs, "
            "results may, too. Verify with that version."
        )
    findings.results.extend(_differing_table(opened, findings))
    chosen = _choose_runs(opened, findings, rerun)
    for done, place in enumerate(chosen, 1):
        again = _rerun_run(opened, place, findings, rerun, opened.root.with_name(f"again-{done}"))
        findings.results.extend(f"{place.relative_to(opened.root)}: {text}" for text in again)
        update(plan.runs + done)
    return Verification(
        bundle=path,
        sha256=file_digest(path),
        campaign=description_of(plan),
        checked=tuple(_checked(opened, findings, rerun, len(chosen))),
        unchecked=tuple(findings.unchecked),
        problems=tuple(map(opened.text, (*problems, *findings.problems))),
        differences=tuple(map(opened.text, findings.differences)),
        runs_recomputed=findings.recomputed,
        runs_again=tuple(place.relative_to(opened.root / CAMPAIGN).as_posix() for place in chosen),
        seed=rerun.seed,
    )


def _checked(opened: OpenedBundle, findings: Findings, rerun: _Rerun, again: int) -> Iterator[str]:
    plan = opened.plan
    files = counted(sum(file.is_file() for file in opened.root.rglob("*")), "file")
    yield f"files: {files} against {CHECKSUMS_FILE}"
    yield f"plan: {counted(plan.runs, 'run')}, what each is, and that there is no other"
    managers, extensions = len(plan.managers), len(plan.extensions)
    yield f"sources: {counted(managers, 'managing system')}, {counted(extensions, 'extension')}"
    if findings.recomputed:
        yield f"figures: {counted(findings.recomputed, 'run')}, computed from the messages, and the table"
    if again:
        yield f"again: {counted(again, 'run')}, chosen by --seed {rerun.seed}, compared by digest and figures"


def _differing_table(opened: OpenedBundle, findings: Findings) -> Iterator[str]:
    """Yield a sentence if the table in the bundle differs from the table of its runs."""
    try:
        is_same = read_text(opened.root / REPORT_FILE) == format_runs(load_results(opened.root / CAMPAIGN))
    except (OSError, UnicodeDecodeError, RecordError) as error:
        yield f"{REPORT_FILE}: it could not be compared: {error}"
    else:
        if not is_same and findings.has_extensions:
            yield f"{REPORT_FILE}: it differs from the table of the runs' figures."
        elif not is_same:
            findings.unchecked.append(
                f"The table in {REPORT_FILE} was not compared, since that needs the campaign's extensions, too."
            )


def _choose_runs(opened: OpenedBundle, findings: Findings, rerun: _Rerun) -> list[Path]:
    """Return the runs to repeat, chosen at random among those that can be; note why others cannot."""
    if not rerun.number:
        findings.unchecked.append("No run was run again, as was asked for.")
        return []
    runs = findings.runs.items() if findings.has_extensions else ()
    obstacles = {place: next(_obstacles(opened, run, rerun), "") for place, run in runs}
    findings.unchecked += [
        f"{counted(number, 'run')} could not be run again: {obstacle}."
        for obstacle, number in Counter(filter(None, obstacles.values())).items()
    ]
    able = [place for place, obstacle in obstacles.items() if not obstacle]
    picked = generator(rerun.seed, "verify").permutation(len(able))[: rerun.number]
    return [able[number] for number in sorted(map(int, picked))]


def _obstacles(opened: OpenedBundle, run: RunRecord, rerun: _Rerun) -> Iterator[str]:
    """Yield the reasons why a run cannot be repeated."""
    plan, name = opened.plan, run.manager
    if run.middleware != SIMULATED:
        yield "live runs take place in real time and never repeat to the byte"
    if run.is_empty:
        yield "failed runs leave no messages to compare"
    facts = plan.flight_facts.get(run.flight)
    if rerun.bag is None and (plan.bag is not None if facts is None else not facts.conditions):
        yield "the flight is not in the bundle; name it with --bag"
    if rerun.model is None and not (
        plan.model in list_models() and model_checksum(load_model(plan.model).card) == plan.model_checksum
    ):
        yield f"its model {plan.model} is not installed; name its folder with --model"
    if _manager(opened, run) not in MANAGERS:
        if not rerun.trust:
            yield f"that runs the code of {name}, which the bundle has; read it, and let it run with --trust"
        sources = opened.manifest.managers.get(name)
        if sources is None or not sources.load:
            yield f"{name} was a class of a program or notebook, which only its process can load"


def _manager(opened: OpenedBundle, run: RunRecord) -> str:
    """Return the name by which the plan loads the managing system of a run."""
    return campaign_managers(opened.plan).get(run.manager, run.manager)


def _rerun_run(
    opened: OpenedBundle, place: Path, findings: Findings, rerun: _Rerun, into: Path
) -> Iterator[str]:
    """Repeat a run into a new folder; yield a sentence for each difference."""
    run = findings.runs[place]
    try:
        with _importing(opened, run) as manager:
            again = run_again(
                place,
                into,
                manager=manager,
                model=rerun.model or opened.plan.model,
                bag=None if run.flight_conditions else rerun.bag,
            ).record
    except (InvalidInputError, ManagerError) as error:
        yield opened.text(error)
        return
    stored, now = _values(run), _values(again)
    for name in sorted(stored.keys() | now.keys()):
        before, after = stored.get(name, UNSET), now.get(name, UNSET)
        # the sentence about a managing system that hung depends on its time limit
        if before != after and not (name == "manager_failed" and before and after):
            yield f"Its {name} is stored as {before!r}, and running it again gave {after!r}."


def _values(run: RunRecord) -> dict[str, object]:
    """Return the figures of a record, and its fields that must repeat, by name."""
    fields = {
        name: value
        for name, value in structs.asdict(run).items()
        if name not in {*_OF_THIS_COMPUTER, "metrics"}
    }
    return {**run.metrics, **fields}


@contextmanager
def _importing(opened: OpenedBundle, run: RunRecord) -> Iterator[str]:
    """Give the name by which a managing system is loaded, while its modules can be imported."""
    manager = _manager(opened, run)
    if manager in MANAGERS:
        yield manager
        return
    sources, folder = opened.manifest.managers[run.manager], manager_folder(run.manager)
    if sources.load.startswith(PREFIX):
        yield _unpacked(opened.root, sources, folder)
        return
    where, _, kind = sources.load.rpartition(":")
    file = opened.file(where)
    path = list(sys.path)
    try:
        if file is None:  # a module of a package, which the folder holds
            import_from(opened.root / folder)
        yield f"{file}:{kind}" if file is not None else sources.load
    finally:
        sys.path[:] = path


def _unpacked(root: Path, sources: ManagerSources, folder: str) -> str:
    """Return the command of a program whose files are in an opened bundle."""
    words = [
        str(root / word) if word == folder or word.startswith(f"{folder}/") else word
        for word in shlex.split(sources.load.removeprefix(PREFIX))
    ]
    if words[0].startswith(f"{root}/"):
        Path(words[0]).chmod(0o755)  # a bundle lacks permissions
    return PREFIX + shlex.join(words)
