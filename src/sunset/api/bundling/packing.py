"""A campaign as one file that others can check: records, plan, sources, checksums, metadata, citation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from sunset.api.bundling.archive import write_archive
from sunset.api.bundling.checks import check_campaign
from sunset.api.bundling.citation import Citation, parse_author, parse_date
from sunset.api.bundling.crate import describing_files
from sunset.api.bundling.layout import CAMPAIGN, CARD_FILE, MANIFEST_FILE, REPORT_FILE, SCENARIOS, Manifest
from sunset.api.bundling.sources import Files, find_extension_sources, find_manager_sources
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
    folder: Path,
    out: Path,
    *,
    published: str,
    title: str = "",
    authors: Sequence[str] = (),
    licence: str = "",
    progress: Progress | None = None,
) -> Bundle:
    """Pack a finished campaign into one zip file, as `sunset.bundle` does; `published` is the day of publication.

    The managed system of this process has the extensions of the campaign.
    """
    plan = _read(folder)
    citation = Citation(
        title=title or f"SUNSET campaign: {', '.join(plan.managers)} over {plan.suite}",
        authors=tuple(map(parse_author, authors)),
        licence=licence,
        published=parse_date(published),
    )
    if out.exists():
        raise OutputError(f"The file {out} exists already: remove it, or name another one with --out.")
    runs = _checked_runs(folder, plan, progress)
    files, lacking = _files(folder, plan, runs)
    sizes = {
        name: len(content) if isinstance(content, bytes) else content.stat().st_size
        for name, content in files.items()
    }
    files |= {name: text.encode() for name, text in describing_files(plan, citation, sizes).items()}
    return Bundle(
        path=out,
        sha256=write_archive(out, files),
        size=out.stat().st_size,
        runs=len(runs),
        left_out=(*lacking, *_left_out(plan, runs)),
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
            "continues it. Of one in parts, copy the folder runs of each into the same folder."
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


def _files(folder: Path, plan: CampaignPlan, runs: Mapping[Path, RunRecord]) -> tuple[Files, list[str]]:
    """Return the files of a bundle that do not describe it, and a sentence for each missing source."""
    managers, manager_files, lacking = find_manager_sources(plan)
    extensions, extension_files = find_extension_sources()
    records = [folder / PLAN_FILE, *(place / name for place in runs for name in (RUN_FILE, *BAG_FILES))]
    files: Files = {f"{CAMPAIGN}/{file.relative_to(folder).as_posix()}": file for file in records}
    files |= manager_files | extension_files | _scenario_files(plan, runs)
    return files | {
        CARD_FILE: document_text(load_model(plan.model).card.to_json()).encode(),
        REPORT_FILE: format_runs(load_results(folder)).encode(),
        MANIFEST_FILE: document_text(Manifest(managers=managers, extensions=extensions)).encode(),
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
    return files | {f"{SCENARIOS}/split/{file.name}": file for file in split}


def _left_out(plan: CampaignPlan, runs: Mapping[Path, RunRecord]) -> list[str]:
    kept = sum((place / IMAGES_FILE).exists() for place in runs)
    left_out = [f"The images of {counted(kept, 'run')} are left out: they can be made again."] if kept else []
    if plan.bag is not None:
        left_out.append(
            f"The flight {plan.bag} is left out: who runs something again needs it (SHA-256 over its files: "
            f"{plan.bag_checksum})."
        )
    if plan.model not in list_models():
        left_out.append(f"The model {plan.model} is left out: who runs something again needs it.")
    return left_out
