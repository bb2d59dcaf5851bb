"""A campaign as one file that others can check: records, plan, sources, checksums and citation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

from sunset.api.arguments import Extensions, as_path, extended
from sunset.api.bundling.archive import (
    CAMPAIGN,
    CARD_FILE,
    CITATION_FILE,
    CRATE_FILE,
    MANIFEST_FILE,
    README_FILE,
    REPORT_FILE,
    SCENARIOS,
    SPLIT,
    write_archive,
)
from sunset.api.bundling.checks import check_campaign
from sunset.api.bundling.citation import citation_text, parse_author
from sunset.api.bundling.crate import NO_LICENCE, crate_text
from sunset.api.bundling.sources import Files, Manifest, find_extension_sources, find_manager_sources
from sunset.errors import OutputError, RecordError
from sunset.evaluation.report import format_runs
from sunset.evaluation.results import load_results
from sunset.experiments import count_runs, scenario_of
from sunset.files.outputs import folder_name
from sunset.files.schemas import document_text
from sunset.flights import FlightSpec
from sunset.perception import list_models, load_model
from sunset.processes.workers import Progress
from sunset.recording import (
    BAG_FILES,
    IMAGES_FILE,
    CampaignPlan,
    RunRecord,
    check_extensions,
    read_plan,
    read_run,
)
from sunset.scenarios import SPLIT_FILE, scenario_files, split_hash
from sunset.texts.names import PLAN_FILE, RUN_FILE, base_name
from sunset.texts.sentences import counted

_README: Final = """# {title}

{description} {terms}

`campaign/bench.json` says what was run, `report.txt` is the table, and `CITATION.cff` says what to cite. With SUNSET
installed, `sunset verify` of the zip file computes every figure from the recorded messages, runs some runs again, and
says what differs. `sunset report` of the folder `campaign` prints the table, and of the folder of a run what happened
in it.
"""


@dataclass(frozen=True, slots=True)
class Bundle:
    """A bundle that was written: its size in bytes, and in `left_out` a sentence for each part that it lacks."""

    path: Path
    sha256: str
    size: int
    runs: int
    left_out: tuple[str, ...]

    def __str__(self) -> str:
        """Return the lines that `sunset bundle` prints."""
        size = f"{self.size / 1e6:.1f} MB"
        return "\n".join(
            (f"{self.path}: {counted(self.runs, 'run')}, {size}", f"SHA-256 {self.sha256}", *self.left_out)
        )


def bundle(
    folder: str | Path,
    out: str | Path,
    *,
    title: str = "",
    authors: Sequence[str] = (),
    licence: str = "",
    date: str | None = None,
    extensions: Extensions = (),
    progress: Progress | None = None,
) -> Bundle:
    """Pack a finished campaign into a zip file that others can check, as `sunset bundle` does.

    The same campaign, arguments and date give the same bytes.

    Args:
        folder: the campaign.
        out: the file, which must not exist.
        title: of the bundle; derived from the campaign's plan if empty.
        authors: a name each, followed by an ORCID if known; anonymous if empty.
        licence: under which others may use it, as SPDX calls it, such as `CC-BY-4.0`, or its address; none if empty.
        date: the day of publication, as `2026-03-14`; today if None.
        extensions: extensions that the campaign was run with.
        progress: called with (checked runs, all runs).

    Raises:
        SunsetError: the folder holds no campaign, or it is not finished or was changed, a managing system cannot be
            loaded, another argument is not usable, or the file exists or cannot be written.
    """
    source, file = as_path(folder, "folder of the campaign"), as_path(out, "bundle")
    with extended(extensions):
        plan = _read(source)
        title = title or f"SUNSET campaign: {', '.join(plan.managers)} over {plan.suite}"
        day = datetime.now(tz=UTC).date().isoformat() if date is None else date  # noqa: TID251  it is not a result
        citation = citation_text(title, authors, licence, day)
        if file.exists():
            raise OutputError(f"The file {file} exists already: remove it, or name another one with --out.")
        runs = _checked_runs(source, plan, progress)
        files, lacking = _files(source, plan, runs, day, authors)
        terms = f"It may be used under {licence}." if licence else NO_LICENCE
        about = {"name": title, "description": description_of(plan), "datePublished": day}
        readme = _README.format(title=title, description=about["description"], terms=terms)
        files |= {CITATION_FILE: citation.encode(), README_FILE: readme.encode()}
        sizes = {name: len(it) if isinstance(it, bytes) else it.stat().st_size for name, it in files.items()}
        files[CRATE_FILE] = crate_text(about, authors, licence, plan.versions["sunset"], sizes).encode()
        digest = write_archive(file, files)
    return Bundle(file, digest, file.stat().st_size, len(runs), (*lacking, *_left_out(plan, runs)))


def description_of(plan: CampaignPlan) -> str:
    """Return a campaign's description, in two sentences."""
    return (
        f"{counted(plan.runs, 'run')} of the SUNSET exemplar: the managing systems {', '.join(plan.managers)} over the "
        f"suite {plan.suite}, {counted(plan.repetitions, 'repetition')}, with the model {plan.model}. "
        "Each run has its record, a rosbag2 with every message and a file with its figures."
    )


def _read(folder: Path) -> CampaignPlan:
    """Return the plan of a finished campaign, whose extensions are loaded."""
    if not (folder / PLAN_FILE).is_file():
        if len(parts := sorted(file.parent for file in folder.glob(f"*/{PLAN_FILE}"))) > 1:
            raise RecordError(
                f"A bundle holds one campaign, and {folder} has {len(parts)} folders of campaigns: name one of them. "
                f"Of parts of one campaign, copy the runs into one folder first (cp -r {parts[1]}/runs {parts[0]})."
            )
        raise RecordError(
            f"There is no campaign in {folder}, since {PLAN_FILE} is missing: name the folder that 'sunset bench "
            "--out' wrote."
        )
    plan = read_plan(folder)
    done, planned = count_runs(folder) or (0, 0)
    if done < planned:
        raise RecordError(
            f"The campaign in {folder} is not finished: {done} of {planned} runs are there; the command that began it "
            "continues it. If it is in shards, copy the folder runs of each into one of them."
        )
    for file in sorted(folder.glob(f"runs/*/*/*/*/{RUN_FILE}"))[:1]:
        check_extensions(read_run(file.parent), file.parent)
    return plan


def _checked_runs(folder: Path, plan: CampaignPlan, progress: Progress | None) -> Mapping[Path, RunRecord]:
    """Return the runs of a campaign, by folder; raise if `verify` would report a problem."""
    findings = check_campaign(folder, plan, load_model(plan.model).card, folder, progress)
    problems = (*findings.problems, *findings.differences)
    if problems:
        more = f" (and {counted(len(problems) - 1, 'other problem')})" if len(problems) > 1 else ""
        raise RecordError(f"The campaign in {folder} cannot be packed{more}: {problems[0]}")
    return findings.runs


def _files(
    folder: Path, plan: CampaignPlan, runs: Mapping[Path, RunRecord], day: str, authors: Sequence[str]
) -> tuple[Files, list[str]]:
    """Return the files of a bundle that do not describe it, and a sentence for each missing source."""
    managers, manager_files, lacking = find_manager_sources(plan)
    extensions, extension_files = find_extension_sources()
    names = tuple(parse_author(author)["name"] for author in authors)
    manifest = Manifest(date=day, authors=names, managers=managers, extensions=extensions)
    records = [folder / PLAN_FILE, *(place / name for place in runs for name in (RUN_FILE, *BAG_FILES))]
    files: Files = {f"{CAMPAIGN}/{file.relative_to(folder).as_posix()}": file for file in records}
    files |= manager_files | extension_files | _scenario_files(plan, runs)
    return files | {
        CARD_FILE: document_text(load_model(plan.model).card.to_json()).encode(),
        REPORT_FILE: format_runs(load_results(folder)).encode(),
        MANIFEST_FILE: document_text(manifest).encode(),
    }, lacking


def _scenario_files(plan: CampaignPlan, runs: Mapping[Path, RunRecord]) -> Files:
    """Return the scenarios of the runs, from their records, and the campaign's split if it has one."""
    files: Files = {}
    for run in runs.values():
        flight = run.flight_conditions if run.flight_conditions and not plan.flights else None
        scenario = replace(scenario_of(run), flight=FlightSpec.of(flight) if flight else None)
        parts = folder_name(run.suite or "own"), f"{folder_name(base_name(run.scenario))}.yaml"
        files["/".join((SCENARIOS, *parts))] = scenario.to_yaml().encode()
    if not plan.split:
        return files
    folder = Path(plan.suite)
    if not folder.is_dir() or split_hash(plan.suite) != plan.split:
        raise RecordError(
            f"The campaign cannot be packed: its suite, the split in {folder}, is not here or was changed. Call it in "
            "the folder from which the campaign was run."
        )
    split = (*scenario_files(folder), folder / SPLIT_FILE)
    return files | {f"{SPLIT}/{file.name}": file for file in split}


def _left_out(plan: CampaignPlan, runs: Mapping[Path, RunRecord]) -> list[str]:
    kept = sum((place / IMAGES_FILE).exists() for place in runs)
    parts = {
        f"The images of {counted(kept, 'run')} are left out: they can be made again.": kept > 0,
        f"The flight {plan.bag} is left out, but second runs need it (SHA-256 over its files: "
        f"{plan.bag_checksum}).": plan.bag is not None,
        f"The model {plan.model} is left out, but second runs need it.": plan.model not in list_models(),
    }
    return [text for text, is_missing in parts.items() if is_missing]
