"""A campaign as one file that others can check: records, plan, sources, checksums, metadata, citation."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from sunset.bundling.archive import check_new, write_archive
from sunset.bundling.checks import check_campaign
from sunset.bundling.citation import ANONYMOUS, Author, Citation, parse_author, parse_date, parse_licence
from sunset.bundling.descriptions import describe_files
from sunset.bundling.layout import (
    CAMPAIGN,
    CARD_FILE,
    MANIFEST_FILE,
    REPORT_FILE,
    SCENARIOS,
    Manifest,
)
from sunset.bundling.sources import find_extension_sources, find_manager_sources
from sunset.errors import InvalidInputError, RecordError
from sunset.evaluation import render_report
from sunset.experiments import count_runs, scenario_of
from sunset.flights import FlightSpec
from sunset.names import base_name
from sunset.output_files import folder_name
from sunset.perception import list_models, load_model
from sunset.processes.workers import Progress
from sunset.recording import (
    BAG_FILES,
    IMAGES_FILE,
    PLAN_FILE,
    RUN_FILE,
    CampaignPlan,
    RunRecord,
    check_extensions,
    read_plan,
    read_run,
)
from sunset.scenarios import SPLIT_FILE, scenario_files, split_hash
from sunset.schemas import document_text
from sunset.texts import counted


@dataclass(frozen=True, slots=True)
class Bundle:
    """A bundle that was written.

    Attributes:
        path: of the file.
        sha256: of the file, in hexadecimal.
        size: in bytes.
        runs: how many runs are in it.
        left_out: a sentence for each thing that is not in it.
    """

    path: Path
    sha256: str
    size: int
    runs: int
    left_out: tuple[str, ...]

    def __str__(self) -> str:
        """Return what was written, in lines."""
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
    """Pack a finished campaign into one zip file.

    The same campaign, citation and day give the same bytes. What `verify` would find is found before anything is
    written. The managed system of this process has the extensions of the campaign.

    Args:
        folder: what `bench` has written.
        out: the file, which must not exist.
        published: the day of publication, as 2026-03-14.
        title: of the bundle; one made of the campaign's plan if empty.
        authors: a name each, with an ORCID behind it if there is one; anonymous if there are none.
        licence: under which others may use it, as SPDX calls it, or its address; none if empty.
        progress: called with (runs that are checked, runs in all).

    Raises:
        RecordError: the folder holds no campaign, an unfinished one, or one that was changed.
        InvalidInputError: what the bundle is to be cited by is not usable.
        ManagerError: a managing system, whose source is needed, cannot be loaded.
        OutputError: the file exists, or cannot be written.
    """
    described = _read(folder)
    citation = Citation(
        title=title or f"SUNSET campaign: {', '.join(described.managers)} over {described.suite}",
        authors=tuple(one for one in map(parse_author, authors) if one != Author(ANONYMOUS)),
        licence=parse_licence(licence),
        published=parse_date(published),
    )
    if not citation.title.isprintable():
        raise InvalidInputError(
            f"The title must be one line of printable characters, got {citation.title!r}."
        )
    check_new(out)
    card = load_model(described.model).card
    findings = check_campaign(folder, described, card, progress)
    if findings.problems or findings.differences:
        first, *others = (*findings.problems, *findings.differences)
        more = f" (and {counted(len(others), 'other problem')})" if others else ""
        raise RecordError(f"The campaign in {folder} cannot be packed{more}: {first}")
    managers, manager_files, lacking = find_manager_sources(described)
    extensions, extension_files = find_extension_sources(described)
    manifest = Manifest(managers=managers, extensions=extensions)
    places = list(findings.runs)
    scenarios = _scenario_files(described, findings.runs.values())
    files = manager_files | extension_files | scenarios | _campaign_files(folder, places)
    files |= {
        CARD_FILE: document_text(card.to_json()).encode(),
        REPORT_FILE: render_report(folder).encode(),
        MANIFEST_FILE: document_text(manifest).encode(),
    }
    sizes = {
        name: len(content) if isinstance(content, bytes) else content.stat().st_size
        for name, content in files.items()
    }
    files |= {name: text.encode() for name, text in describe_files(described, citation, sizes).items()}
    return Bundle(
        path=out,
        sha256=write_archive(out, files),
        size=out.stat().st_size,
        runs=len(places),
        left_out=(*lacking, *_left_out(described, places)),
    )


def _read(folder: Path) -> CampaignPlan:
    """Return the plan of a finished campaign, whose extensions are loaded.

    Raises:
        RecordError: it is not a campaign.
    """
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
    described = read_plan(folder)
    done, planned = count_runs(folder) or (0, 0)
    if done < planned:
        raise RecordError(
            f"The campaign in {folder} is not finished: {done} of {planned} runs are there; the command that began it "
            "continues it. Of one in parts, copy the folder runs of each into the same folder."
        )
    for file in sorted(folder.glob(f"runs/*/*/*/*/{RUN_FILE}"))[:1]:
        check_extensions(read_run(file.parent), file.parent)
    return described


def _campaign_files(folder: Path, places: Sequence[Path]) -> dict[str, Path | bytes]:
    """Return the plan, and the files of the records, without images."""
    files = [folder / PLAN_FILE, *(place / name for place in places for name in (RUN_FILE, *BAG_FILES))]
    return {f"{CAMPAIGN}/{file.relative_to(folder).as_posix()}": file for file in files}


def _scenario_files(described: CampaignPlan, runs: Iterable[RunRecord]) -> dict[str, Path | bytes]:
    """Return the scenarios of the runs, from their records, and the campaign's split if it has one.

    Raises:
        RecordError: the split is gone, or was changed.
    """
    files: dict[str, Path | bytes] = {}
    for run in runs:
        flight = run.flight_conditions if run.flight_conditions and not described.flights else None
        scenario = replace(scenario_of(run), flight=FlightSpec.of(flight) if flight else None)
        parts = folder_name(run.suite or "own"), f"{folder_name(base_name(run.scenario))}.yaml"
        files["/".join((SCENARIOS, *parts))] = scenario.to_yaml().encode()
    if not described.split:
        return files
    folder = Path(described.suite)
    if not folder.is_dir() or split_hash(described.suite) != described.split:
        raise RecordError(
            f"The campaign cannot be packed: its suite, the split in {folder}, is not here or was changed. Call it in "
            "the folder from which the campaign was run."
        )
    return files | {
        f"{SCENARIOS}/split/{file.name}": file for file in (*scenario_files(folder), folder / SPLIT_FILE)
    }


def _left_out(described: CampaignPlan, places: Sequence[Path]) -> list[str]:
    """Return what of a campaign a bundle does not have, in sentences."""
    kept = sum(1 for place in places if (place / IMAGES_FILE).exists())
    left_out = [f"The images of {counted(kept, 'run')} are left out: they can be made again."] if kept else []
    if described.bag is not None:
        left_out.append(
            f"The flight {described.bag} is left out: who runs something again needs it (SHA-256 over its files: "
            f"{described.bag_checksum})."
        )
    if described.model not in list_models():
        left_out.append(f"The model {described.model} is left out: who runs something again needs it.")
    return left_out
