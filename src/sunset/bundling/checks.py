"""What can be found out about a campaign from its files alone: nothing is run, and no code of theirs is executed."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from msgspec import UNSET

from sunset.errors import RecordError
from sunset.experiments import campaign_managers, model_checksum
from sunset.metrics import score
from sunset.names import base_name
from sunset.output_files import folder_name
from sunset.perception import ModelCard
from sunset.processes.workers import Progress
from sunset.recording import (
    PLAN_FILE,
    RUN_FILE,
    CampaignPlan,
    RunRecord,
    differences,
    read_run,
    read_timeline,
    stored_figures,
)
from sunset.source_files import package_version
from sunset.system import loaded_extensions
from sunset.texts import counted, shown


@dataclass
class Findings:
    """What was found.

    Attributes:
        problems: a sentence for each thing that is not as it should be, with the file or run that it is about.
        differences: a sentence for each difference that may come from another version of SUNSET.
        unchecked: a sentence for each thing that could not be checked.
        recomputed: how many runs' figures were computed from their messages.
        runs: those that can be read, with the folders that they are in.
        extended: whether the managed system has the campaign's extensions.
    """

    problems: list[str] = field(default_factory=list)
    differences: list[str] = field(default_factory=list)
    unchecked: list[str] = field(default_factory=list)
    recomputed: int = 0
    runs: dict[Path, RunRecord] = field(default_factory=dict)
    extended: bool = True


def is_of_another_version(described: CampaignPlan) -> bool:
    """Return whether a campaign was made by another version of SUNSET, or by edited code."""
    return described.versions.get("sunset") != package_version()


def check_campaign(
    folder: Path, described: CampaignPlan, card: ModelCard, progress: Progress | None = None
) -> Findings:
    """Check that the runs in a campaign's folder are those of its plan, and that their figures follow from them.

    Scenarios are read from the records, so that this version's suites do not matter.

    Args:
        folder: of the campaign.
        described: its plan.
        card: of its model.
        progress: called with (runs that are checked, runs in all).
    """
    findings = Findings()
    if model_checksum(card) != described.model_checksum:
        findings.problems.append(f"{PLAN_FILE}: its model differs from the card that is there.")
    places = sorted(file.parent for file in folder.glob(f"runs/*/*/*/*/{RUN_FILE}"))
    if {one.name: one.checksum for one in loaded_extensions()} != described.extensions:
        findings.extended = False
        findings.unchecked.append(
            f"The figures of {counted(len(places), 'run')} were not computed again, and none was run again, since that "
            f"needs the campaign's extensions ({', '.join(described.extensions) or 'none'}), whose code --trust lets "
            "run."
        )
    figures = findings.differences if is_of_another_version(described) else findings.problems
    for done, place in enumerate(places, 1):
        name = place.relative_to(folder).as_posix()
        try:
            run = findings.runs[place] = read_run(place)
            findings.problems += [f"{name}: {text}." for text in _misfits(run, place, folder, described)]
            if findings.extended:
                figures += [f"{name}: {text}." for text in _recomputed(run, place)]
                findings.recomputed += not run.is_empty
        except RecordError as error:
            findings.problems.append(f"{name}: {str(error).replace(f'{folder}/', '')}")
        if progress is not None:
            progress(done, len(places))
    findings.problems += [f"{PLAN_FILE}: {text}." for text in _missing(findings.runs, described)]
    _note_unchecked(findings)
    return findings


def _misfits(run: RunRecord, place: Path, folder: Path, described: CampaignPlan) -> Iterator[str]:
    """Yield why a run does not belong to a campaign, such as one that was copied from another campaign."""
    managers = ({"none": "none"} if described.references else {}) | campaign_managers(described)
    named = (run.suite or "own", run.manager, base_name(run.scenario))
    above = folder.joinpath("runs", *map(folder_name, named))
    if place.parent != above or place.name.split("-")[:2] != ["seed", str(run.seed)]:
        yield f"it says that it is seed {run.seed} of {run.scenario} with {run.manager}"
    if run.manager not in managers or not 0 <= run.seed - described.seed < described.repetitions:
        yield f"no run of {run.manager} with seed {run.seed} is part of the plan"
    for name, planned in _planned(run, described).items():
        stored = getattr(run, name)
        if isinstance(planned, Mapping) and isinstance(stored, Mapping):  # live, a run has more versions
            for key in sorted(key for key in planned if stored.get(key) != planned[key]):
                yield f"its {name}.{key} is {shown(stored.get(key))}, and that of the plan {shown(planned[key])}"
        elif stored != planned:
            yield f"its {name} is {_shown(stored)}, and that of the plan {_shown(planned)}"


def _planned(run: RunRecord, described: CampaignPlan) -> dict[str, object]:
    """Return the fields of a run's record that its plan determines, by name."""
    facts = described.flight_facts.get(run.flight)
    timing = {
        name: value for name, value in described.timing.items() if getattr(run, name, UNSET) is not UNSET
    }
    return {
        "manager_checksum": described.manager_checksums.get(run.manager, ""),
        "device": described.device,
        "middleware": described.middleware,
        "bag_checksum": described.bag_checksum if facts is None else facts.bag_checksum,
        "bag_looped": described.loop,
        "task": described.task,
        "thinking_s": described.thinking_s or UNSET,
        "extensions": described.extensions or UNSET,
        "versions": described.versions,
        **timing,
    }


def _shown(value: object) -> str:
    return "nothing" if value is UNSET or value == "" else shown(value)


def _missing(runs: Mapping[Path, RunRecord], described: CampaignPlan) -> Iterator[str]:
    """Yield which planned runs are missing: all managing systems have the same scenarios, seeds and flights."""
    if len(runs) != described.runs:
        yield f"it has {counted(described.runs, 'run')}, and {len(runs)} can be read"
    suite = described.suite if any(run.suite == described.suite for run in runs.values()) else ""
    ran = {(run.manager, run.scenario, run.seed, run.flight) for run in runs.values() if run.suite == suite}
    for manager in campaign_managers(described):
        for missing in sorted({one[1:] for one in ran} - {one[1:] for one in ran if one[0] == manager}):
            yield f"{manager} has no run of {missing[0]}, seed {missing[1]}, on the flight {missing[2]}"


def _note_unchecked(findings: Findings) -> None:
    """Say which runs have no figures, and which are left out for reasons that messages do not show."""
    failed = sum(run.is_empty for run in findings.runs.values())
    invalid = sum(not run.valid for run in findings.runs.values()) - failed
    open_runs = [run for run in findings.runs.values() if run.missing_walls]
    if open_runs:
        missing = dict.fromkeys(name for run in open_runs for name in run.missing_walls or ())
        findings.unchecked.append(
            f"What the managing system read and did in {counted(len(open_runs), 'run')}, without {', '.join(missing)} "
            "around it."
        )
    if failed:
        findings.unchecked.append(
            f"{counted(failed, 'run')} failed, and left no messages to compute figures from."
        )
    if invalid:
        findings.unchecked.append(
            f"Why {counted(invalid, 'run')} should not count: the observer saw it, and the messages do not show it."
        )


def _recomputed(run: RunRecord, place: Path) -> Iterator[str]:
    """Yield which figures in a run's `run.json` are not those that its messages give."""
    if run.is_empty:
        return
    stored, metrics = stored_figures(run, place / RUN_FILE), score(read_timeline(place))
    computed = metrics.to_json()
    for name in differences(run, metrics):
        if name not in computed:
            yield f"its {name} are not what the messages give"
            continue
        yield f"its {name} is stored as {_number(stored[name])}, and the messages give {_number(computed[name])}"


def _number(value: float | None) -> str:
    return "N/A" if value is None else f"{value:.6g}"
