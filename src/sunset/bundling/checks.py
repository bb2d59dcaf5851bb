"""What can be found out about a campaign from its files alone: nothing is run, and no code of theirs is executed."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from msgspec import UNSET

from sunset.bundling.layout import is_exact
from sunset.errors import InvalidInputError, RecordError
from sunset.experiments import (
    BenchSpec,
    RunSpec,
    RunTiming,
    Settings,
    Timing,
    campaign_managers,
    flight_name,
    model_checksum,
    plan,
    run_folder,
    scenarios_checksum,
    stored_faults,
)
from sunset.managing import MANAGERS
from sunset.metrics import RunMetrics, log_figures, score
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
    describes_bag,
    differences,
    measured_topics,
    published_log,
    read_messages,
    read_run,
    stored_figures,
    timeline_of,
)
from sunset.scenarios import Scenario, split_hash, with_strengths
from sunset.system import loaded_extensions
from sunset.texts import counted, shown
from sunset.workers import Progress

_MOST: Final = 10_000
"""No campaign has more managing systems times repetitions."""
_COMMON: Final = ("bag_frames", "bag_size", "bag_dropped", "frame_size", "compute_s")
"""What is the same in all runs of a campaign on one flight, and stands in no plan."""


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
    facts = (described.scenarios_checksum, described.split, described.runs)
    if facts != (scenarios_checksum(specs), split_hash(suite), len(specs)):
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
                first = next(one for _, _, one in findings.runs if one.flight == run.flight)
                expected = _expected(spec, described, card)
                problems.extend(_misfits(run, place, expected, described, manager=spec.manager, first=first))
                problems.extend(_recomputed(run, place))
                findings.recomputed += not run.is_empty
        else:
            findings.problems.append(f"{_name(place, folder)}: the run is missing.")
        if progress is not None:
            progress(done, len(places))
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
    firsts: dict[str, RunRecord] = {}
    for place in sorted(found):
        with _noted(findings, folder, place) as problems:
            run = read_run(place)
            first = firsts.setdefault(run.flight, run)
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
            expected = _expected_of_all(run.manager, settings, timing, described, card, flight=run.flight)
            expected["manager_spec"] = UNSET if manager == run.manager else manager
            problems.extend(_misfits(run, place, expected, described, manager=manager, first=first))
            messages = read_messages(place)
            problems.extend(contradictions(run, messages))
    for scenario, there in seeds.items():
        if there != set(every):
            findings.problems.append(f"{_name(scenario, folder)}: its seeds are not those of the plan.")
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


def _name(place: Path, folder: Path) -> str:
    return place.relative_to(folder).as_posix()


def _note_unchecked(findings: Findings) -> None:
    """Say which runs have no figures, and which are left out for reasons that messages do not show."""
    failed = sum(1 for _, _, run in findings.runs if run.is_empty)
    invalid = sum(1 for _, _, run in findings.runs if not run.valid) - failed
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


def _misfits(
    run: RunRecord,
    place: Path,
    expected: Mapping[str, object],
    described: CampaignPlan,
    *,
    manager: str,
    first: RunRecord,
) -> Iterator[str]:
    """Yield in what the `run.json` of a run is not that of a run of the plan, nor like that of the first run."""
    for name, value in (*expected.items(), *((name, getattr(first, name)) for name in _COMMON)):
        stored = getattr(run, name)
        if stored != value:
            yield f"its {name} is {_shown(stored)}, and that of the plan {_shown(value)}"
    # live, a run has those of the middleware, too
    versions = {name: run.versions.get(name) for name in described.versions}
    if (versions if run.speed is not UNSET else run.versions) != described.versions:
        yield f"its versions are {_shown(run.versions)}, and those of the plan {_shown(described.versions)}"
    if run.valid != (not run.reason):
        yield f"it is stored as {'' if run.valid else 'in'}valid, with the reason {_shown(run.reason)}"
    if run.manager_failed is not None and manager in MANAGERS and not described.extensions:
        yield f"it is stored as failed, which a run of {manager} never is"
    if run.is_empty and (run.valid or set(run.metrics.values()) != {None}):
        yield "it is stored as failed, and as valid or with figures"
    if not describes_bag(place):
        yield "its metadata.yaml is missing, or is not that of its messages"
    if not is_exact(place / RUN_FILE, run, described.versions) or run.metrics.keys() - RunMetrics.names():
        yield f"its {RUN_FILE} has what no run has, or a key twice"


def _expected(spec: RunSpec, described: CampaignPlan, card: ModelCard) -> dict[str, object]:
    """Return what a run's `run.json` must say, by the plan and the model's card."""
    return {
        "scenario": spec.scenario.name,
        "faults": stored_faults(with_strengths(spec.scenario, card.severities, card.name), spec.scenario),
        "suite": spec.suite,
        "manager": spec.manager_name,
        "manager_spec": spec.manager if spec.label else UNSET,
        "seed": spec.seed,
        **_expected_of_all(
            spec.manager_name, spec.settings, spec.timing, described, card, flight=flight_name(spec)
        ),
    }


def _expected_of_all(
    name: str,
    settings: Settings,
    timing: RunTiming,
    described: CampaignPlan,
    card: ModelCard,
    *,
    flight: str,
) -> dict[str, object]:
    """Return what the `run.json` of every run of a managing system with this timing and flight must say."""
    found = described.flight_facts.get(flight)
    thresholds = card if found is None else found
    live = settings.live
    known = described.manager_checksums.get(name)
    return {
        **({} if known is None else {"manager_checksum": known}),
        "model": card.name,
        "model_checksums": {str(modality): one.digest for modality, one in card.networks.items()},
        "flight": flight,
        "flight_conditions": UNSET if found is None else found.conditions or UNSET,
        "flight_warning": (found is not None and found.warning) or UNSET,
        "entropy_threshold": thresholds.entropy_threshold,
        "sharpness_threshold": thresholds.sharpness_threshold,
        "device": described.device,
        "middleware": described.middleware,
        "bag_checksum": described.bag_checksum if found is None else found.bag_checksum,
        "bag_looped": described.loop,
        "jitter": UNSET if live else timing.jitter,
        "latency_s": UNSET if live else timing.latency_s,
        "speed": described.speed if live else UNSET,
        "warm_up_s": timing.warm_up_s,
        "duration_s": timing.duration_s,
        "period_s": timing.period_s,
        "expected_frames": timing.expected_frames,
        "thinking_s": settings.thinking_s or UNSET,
        "extensions": described.extensions or UNSET,
    }


def _shown(value: object) -> str:
    return "nothing" if value is UNSET or value == "" else shown(value)
