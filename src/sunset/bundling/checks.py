"""What can be found out about a campaign from its files alone: nothing is run, and no code of theirs is executed."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from msgspec import UNSET

from sunset.bundling.misfits import expected_of, expected_of_all, misfits, unlike_others
from sunset.errors import InvalidInputError, RecordError
from sunset.experiments import (
    BenchSpec,
    RunSpec,
    Settings,
    Timing,
    campaign_managers,
    model_checksum,
    plan,
    run_folder,
    scenarios_checksum,
)
from sunset.metrics import log_figures, score
from sunset.names import base_name
from sunset.output_files import folder_name
from sunset.perception import ModelCard
from sunset.recording import (
    PLAN_FILE,
    RUN_FILE,
    TELLING_TOPICS,
    CampaignPlan,
    RunRecord,
    check_extensions,
    contradictions,
    differences,
    measured_topics,
    published_log,
    read_messages,
    read_run,
    stored_figures,
    timeline_of,
)
from sunset.scenarios import Scenario, split_hash
from sunset.system import loaded_extensions
from sunset.texts import counted
from sunset.workers import Progress

_MOST: Final = 10_000
"""No campaign has more managing systems times repetitions."""


@dataclass
class Findings:
    """What was found.

    Attributes:
        problems: a sentence for each thing that is not as it should be, with the file or run that it is about.
        unchecked: a sentence for each thing that could not be checked.
        recomputed: how many runs' figures were computed from their messages.
        runs: those that the plan has, with their folders, as far as they can be read.
        extended: whether the managed system has the campaign's extensions.
    """

    problems: list[str] = field(default_factory=list)
    unchecked: list[str] = field(default_factory=list)
    recomputed: int = 0
    runs: list[tuple[RunSpec, Path, RunRecord]] = field(default_factory=list)
    extended: bool = True


def planned_runs(described: CampaignPlan, suite: str) -> tuple[RunSpec, ...]:
    """Return all runs of a campaign that a plan describes.

    Args:
        described: the plan.
        suite: the suite's name, or the folder of its scenarios.

    Raises:
        InvalidInputError: it describes none.
    """
    if len(described.managers) * described.repetitions > _MOST:
        raise RecordError(
            f"No campaign has {counted(len(described.managers), 'managing system')} and {described.repetitions} "
            "repetitions."
        )
    return plan(
        BenchSpec(
            suite=suite,
            scenarios=tuple(map(base_name, described.scenarios)),
            references=described.references,
            score=described.score,
            managers=described.managers,
            flights=described.flights,
            repetitions=described.repetitions,
            seed=described.seed,
            settings=_settings(described),
        )
    )


def _settings(described: CampaignPlan) -> Settings:
    """Return the settings that all runs of a campaign have.

    Raises:
        InvalidInputError: no campaign has such.
    """
    try:
        timing = Timing(**described.timing)
    except TypeError as error:
        raise RecordError(
            f"There is a timing that no campaign has: {', '.join(described.timing)}."
        ) from error
    return Settings(
        model=described.model,
        bag=None if described.bag is None else Path(described.bag),
        loop=described.loop,
        timing=timing,
        device=described.device,
        middleware=described.middleware,
        speed=described.speed,
        thinking_s=described.thinking_s,
    )


def check_campaign(
    folder: Path,
    described: CampaignPlan,
    card: ModelCard,
    suite: str,
    progress: Progress | None = None,
) -> Findings:
    """Check that the runs in a campaign's folder are those of its plan, and that their figures follow from them.

    Args:
        folder: of the campaign.
        described: its plan.
        card: of its model.
        suite: the suite's name, or the folder of its scenarios.
        progress: called with (runs that are checked, runs in all).
    """
    findings = Findings()
    found = {file.parent for file in folder.glob(f"runs/*/*/*/*/{RUN_FILE}")}
    if model_checksum(card) != described.model_checksum:
        findings.problems.append(f"{PLAN_FILE}: its model differs from the card that is there.")
    if {one.name: one.checksum for one in loaded_extensions()} != described.extensions:
        try:
            _check_unextended(findings, folder, described, card, found)
        except InvalidInputError as error:
            findings.problems.append(f"{PLAN_FILE}: it describes no campaign: {error}")
        return findings
    try:
        specs = planned_runs(described, suite)
    except InvalidInputError as error:
        findings.problems.append(f"{PLAN_FILE}: it describes no campaign: {error}")
        return findings
    chosen = dict.fromkeys(spec.scenario.name for spec in specs if spec.scenario.name in described.scenarios)
    facts = (described.scenarios, described.scenarios_checksum, described.split, described.runs)
    if facts != (tuple(chosen), scenarios_checksum(specs), split_hash(suite), len(specs)):
        findings.problems.append(
            f"{PLAN_FILE}: it was changed, or is of another version's suite: its scenarios or number of runs are not "
            "those that it describes."
        )
    places = {run_folder(folder, spec): spec for spec in specs}
    for place in sorted(found - places.keys()):
        findings.problems.append(f"{_name(place, folder)}: the run is not part of the plan.")
    for done, (place, spec) in enumerate(places.items(), 1):
        if place in found:
            with _noted(findings, folder, place) as problems:
                run = read_run(place)
                findings.runs.append((spec, place, run))
                expected = expected_of(spec, described, card)
                problems.extend(misfits(run, place, expected, described, manager=spec.manager))
                problems.extend(_recomputed(run, place))
                findings.recomputed += not run.is_empty
        else:
            findings.problems.append(f"{_name(place, folder)}: the run is missing.")
        if progress is not None:
            progress(done, len(places))
    _note_unlike(findings, folder, {place: run for _, place, run in findings.runs})
    _note_unchecked(findings)
    return findings


def _check_unextended(
    findings: Findings, folder: Path, described: CampaignPlan, card: ModelCard, found: Collection[Path]
) -> None:
    """Check what can be checked of runs of an extended system where its extensions are not to be executed.

    Raises:
        InvalidInputError: the plan describes no campaign.
    """
    findings.extended = False
    findings.unchecked.append(
        f"The figures of {counted(len(found), 'run')} were not computed again, and none was run again, since that "
        f"needs the campaign's extensions ({', '.join(described.extensions) or 'none'}), whose code --trust lets run."
    )
    if len(found) != described.runs:
        findings.problems.append(
            f"{PLAN_FILE}: it has {counted(described.runs, 'run')}, and {len(found)} are there."
        )
    settings = _settings(described)
    managers = ({"none": "none"} if described.references else {}) | campaign_managers(described)
    every = range(described.seed, described.seed + described.repetitions)
    seeds: dict[Path, set[int]] = {}
    runs: dict[Path, RunRecord] = {}
    for place in sorted(found):
        with _noted(findings, folder, place) as problems:
            run = runs[place] = read_run(place)
            seeds.setdefault(place.parent, set()).add(run.seed)
            named = (run.suite or "own", run.manager, base_name(run.scenario))
            flight = f"-{run.flight}" if described.flights else ""
            if place != folder.joinpath("runs", *map(folder_name, (*named, f"seed-{run.seed}{flight}"))):
                problems.append(f"it says that it is seed {run.seed} of {run.scenario} with {run.manager}")
            manager = managers.get(run.manager, "")
            if not manager or run.seed not in every:
                problems.append(f"no run of {run.manager} with seed {run.seed} is part of the plan")
            # the scenario, which may be of an extension, is not looked at
            timing = settings.timing.of_run(Scenario(run.scenario, duration=run.duration_s), run.seed)
            expected = expected_of_all(run.manager, settings, timing, described, card, flight=run.flight)
            expected["manager_spec"] = UNSET if manager == run.manager else manager
            problems.extend(misfits(run, place, expected, described, manager=manager))
            messages = read_messages(place)
            problems.extend(contradictions(run, messages))
    for scenario, there in seeds.items():
        if there != set(every):
            findings.problems.append(f"{_name(scenario, folder)}: its seeds are not those of the plan.")
    _note_unlike(findings, folder, runs)
    _check_scenarios(findings, described, seeds)
    _note_unchecked(findings)


def _check_scenarios(findings: Findings, described: CampaignPlan, scenarios: Collection[Path]) -> None:
    """Note managing systems that were not run over the same scenarios as the others."""
    of_suite = {folder_name(described.suite)} & {place.parts[-3] for place in scenarios} or {"own"}
    wanted = {folder_name(base_name(name)) for name in described.scenarios}
    ran = {
        manager: {
            place.name
            for place in scenarios
            if place.parts[-3] in of_suite and place.parts[-2] == folder_name(manager)
        }
        for manager in campaign_managers(described)
    }
    wanted = wanted or set().union(*ran.values())
    for manager in sorted(name for name, names in ran.items() if names != wanted):
        findings.problems.append(f"{PLAN_FILE}: the scenarios of {manager} are not those of the others.")


@contextmanager
def _noted(findings: Findings, folder: Path, place: Path) -> Iterator[list[str]]:
    """Give a list, and note what it has at the end, and why a run could not be read, as problems of the run."""
    problems: list[str] = []
    try:
        yield problems
    except RecordError as error:
        problems.append(str(error).replace(f"{folder}/", "").removesuffix("."))
    findings.problems += [f"{_name(place, folder)}: {problem}." for problem in problems]


def _note_unlike(findings: Findings, folder: Path, runs: Mapping[Path, RunRecord]) -> None:
    """Note runs that are not like the others of their flight."""
    for place, problem in unlike_others(runs):
        findings.problems.append(f"{_name(place, folder)}: {problem}.")


def _name(place: Path, folder: Path) -> str:
    return place.relative_to(folder).as_posix()


def _note_unchecked(findings: Findings) -> None:
    """Say which runs have no figures, and which are left out for reasons that messages do not show."""
    failed = sum(1 for _, _, run in findings.runs if run.is_empty)
    invalid = sum(1 for _, _, run in findings.runs if not run.valid) - failed
    open_runs = [run for _, _, run in findings.runs if run.missing_walls]
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
    """Yield in what a run's messages contradict its `run.json`."""
    if run.is_empty:
        if read_messages(place):
            yield "it is stored as failed, and has messages"
        return
    check_extensions(run, place)
    messages = read_messages(place, measured_topics() | TELLING_TOPICS)
    yield from contradictions(run, messages)
    observed = timeline_of(run, messages)
    stored, metrics = stored_figures(run, place / RUN_FILE), score(observed)
    if run.by_paper_script not in {UNSET, log_figures(published_log(messages, observed))}:
        yield "its figures by the paper's evaluation script are stored otherwise than the messages give them"
    computed = metrics.to_json()
    for name in differences(run, metrics):
        if name not in computed:
            yield f"its {name} are not what the messages give"
            continue
        yield f"its {name} is stored as {_number(stored[name])}, and the messages give {_number(computed[name])}"


def _number(value: float | None) -> str:
    return "N/A" if value is None else f"{value:.6g}"
