"""Checks of a campaign by its files: its runs against the plan, and its figures against the messages."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from msgspec import UNSET

from sunset.errors import RecordError
from sunset.experiments import campaign_managers, model_checksum
from sunset.files.outputs import folder_name
from sunset.files.sources import package_version
from sunset.metrics import score
from sunset.perception import ModelCard
from sunset.processes.workers import Progress
from sunset.recording import (
    SETTINGS,
    CampaignPlan,
    RunRecord,
    differences,
    read_run,
    read_timeline,
    stored_figures,
)
from sunset.system import loaded_extensions
from sunset.texts.names import PLAN_FILE, RUN_FILE, base_name
from sunset.texts.sentences import counted
from sunset_ros.texts import shown


@dataclass
class Findings:
    """The problems of a campaign, and the limits of the checks.

    Attributes:
        of_another_version: whether another version of SUNSET, or edited code, ran the campaign.
        has_extensions: whether this process has the campaign's extensions.
        problems: a sentence for each problem, after the file or run.
        differences: likewise, for each result that may differ because of the other version.
        unchecked: a sentence for each thing that could not be checked.
        runs: the records that can be read, by folder, of which the figures of `recomputed` were computed again.
    """

    of_another_version: bool
    has_extensions: bool
    problems: list[str] = field(default_factory=list)
    differences: list[str] = field(default_factory=list)
    unchecked: list[str] = field(default_factory=list)
    runs: dict[Path, RunRecord] = field(default_factory=dict)
    recomputed: int = 0

    @property
    def results(self) -> list[str]:
        """The list for results that differ."""
        return self.differences if self.of_another_version else self.problems


def check_campaign(
    folder: Path, plan: CampaignPlan, card: ModelCard, root: Path, progress: Progress | None = None
) -> Findings:
    """Check the runs of a campaign against its plan, and their figures against their messages.

    No code of the campaign is executed, and the suites of this version do not matter. The names of files and runs in
    sentences begin below `root`. `progress` is called with (runs that are checked, runs in all).
    """
    extensions = {extension.name: extension.checksum for extension in loaded_extensions()}
    findings = Findings(
        of_another_version=plan.versions.get("sunset") != package_version(),
        has_extensions=extensions == plan.extensions,
    )
    plan_name = (folder / PLAN_FILE).relative_to(root)
    if model_checksum(card) != plan.model_checksum:
        findings.problems.append(f"{plan_name}: its model differs from the card that is there.")
    places = sorted(file.parent for file in folder.glob(f"runs/*/*/*/*/{RUN_FILE}"))
    for done, place in enumerate(places, 1):
        name = place.relative_to(root)
        try:
            run = findings.runs[place] = read_run(place)
            findings.problems += [f"{name}: {text}." for text in _misfits(run, place, plan)]
            if findings.has_extensions and not run.is_empty:
                findings.results.extend(f"{name}: {text}." for text in _differing_figures(run, place))
                findings.recomputed += 1
        except RecordError as error:
            findings.problems.append(f"{name}: {error}".replace(f"{root}/", ""))
        if progress is not None:
            progress(done, len(places))
    findings.problems += [f"{plan_name}: {text}." for text in _missing(findings.runs, plan)]
    findings.unchecked += _unchecked(findings, plan)
    return findings


def _misfits(run: RunRecord, place: Path, plan: CampaignPlan) -> Iterator[str]:
    """Yield the reasons why a run does not belong to a campaign, such as a run copied from another campaign."""
    names = map(folder_name, (run.suite or "own", run.manager, base_name(run.scenario)))
    if place.parts[-4:-1] != tuple(names) or place.name.split("-")[:2] != ["seed", str(run.seed)]:
        yield f"it is the record of seed {run.seed} of {run.scenario} with {run.manager}"
    managers = {*campaign_managers(plan), *(["none"] if plan.references else [])}
    if run.manager not in managers or not 0 <= run.seed - plan.seed < plan.repetitions:
        yield f"no run of {run.manager} with seed {run.seed} is part of the plan"
    pairs = {name: (getattr(run, name), planned) for name, planned in _planned(run, plan).items()}
    pairs |= {  # a live run has more versions
        f"versions.{name}": (run.versions.get(name), version) for name, version in plan.versions.items()
    }
    for name, (stored, planned) in pairs.items():
        if stored != planned:
            yield f"its {name} is {_quoted(stored)}, and {_quoted(planned)} in the plan"


def _planned(run: RunRecord, plan: CampaignPlan) -> dict[str, object]:
    """Return the fields of a run's record that the plan determines, by name."""
    facts = plan.flight_facts.get(run.flight)
    timing = {name: value for name, value in plan.timing.items() if getattr(run, name, UNSET) is not UNSET}
    return {
        "manager_checksum": plan.manager_checksums.get(run.manager, ""),
        "device": plan.device,
        "middleware": plan.middleware,
        "bag_checksum": plan.bag_checksum if facts is None else facts.bag_checksum,
        "bag_looped": plan.loop,
        "extensions": plan.extensions or UNSET,
        **{name: getattr(plan, name) or UNSET for name in SETTINGS},
        **timing,
    }


def _quoted(value: object) -> str:
    return "nothing" if value is UNSET or value == "" else shown(value)


def _missing(runs: Mapping[Path, RunRecord], plan: CampaignPlan) -> Iterator[str]:
    """Yield which runs are missing: all managing systems have the same scenarios, seeds and flights."""
    if len(runs) != plan.runs:
        yield f"it has {counted(plan.runs, 'run')}, and {len(runs)} can be read"
    done: dict[str, set[tuple[str, int, str]]] = {manager: set() for manager in campaign_managers(plan)}
    for run in runs.values():
        if run.manager in done and plan.is_of_suite(run.suite, run.manager):
            done[run.manager].add((run.scenario, run.seed, run.flight))
    for manager, own in done.items():
        for scenario, seed, flight in sorted(set().union(*done.values()) - own):
            yield f"{manager} has no run of {scenario}, seed {seed}, on the flight {flight}"


def _differing_figures(run: RunRecord, place: Path) -> Iterator[str]:
    """Yield the figures in a run's `run.json` that differ from the figures of its messages."""
    stored, metrics = stored_figures(run, place / RUN_FILE), score(read_timeline(place))
    computed = metrics.to_json()
    for name in differences(run, metrics):
        if name in computed:
            yield f"its {name} is stored as {_number(stored[name])}, and the messages give {_number(computed[name])}"
        else:
            yield f"its {name} differ from the messages"


def _number(value: float | None) -> str:
    return "N/A" if value is None else f"{value:.6g}"


def _unchecked(findings: Findings, plan: CampaignPlan) -> Iterator[str]:
    runs = findings.runs.values()
    if not findings.has_extensions:
        yield (
            f"The figures of {counted(len(runs), 'run')} were not computed again, and none was run again, since that "
            f"needs the campaign's extensions ({', '.join(plan.extensions) or 'none'}), whose code --trust lets run."
        )
    missing_walls = [run.missing_walls for run in runs if run.missing_walls]
    if missing_walls:
        names = ", ".join(dict.fromkeys(name for walls in missing_walls for name in walls))
        number = counted(len(missing_walls), "run")
        yield f"What the managing system read and did in {number}, without {names} around it."
    failed = sum(run.is_empty for run in runs)
    if failed:
        yield f"{counted(failed, 'run')} failed, and left no messages to compute figures from."
    invalid = sum(not run.valid for run in runs) - failed
    if invalid:
        yield f"The reason why {counted(invalid, 'run')} should not count, which the messages do not show."
