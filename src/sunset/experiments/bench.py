"""A campaign: every scenario of a suite, every managing system, several repetitions; resumable."""

import dataclasses
import hashlib
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Final

from msgspec import UNSET, Meta
from msgspec.structs import asdict

from sunset.errors import InvalidInputError, RecordError
from sunset.experiments.campaign_lock import locked_campaign
from sunset.experiments.campaign_run import run_of_campaign
from sunset.experiments.cluster import check_executor, run_on_workers
from sunset.experiments.manager import manager_checksum
from sunset.experiments.resources import Resources, flight_name, flight_plan, model_checksum, prepare_all
from sunset.experiments.run import versions
from sunset.experiments.shards import Shard
from sunset.experiments.spec import EXTERNAL, RunSpec, Settings
from sunset.experiments.worker import facts_of
from sunset.flights import parse_flights
from sunset.managing import is_registered, split_label
from sunset.names import base_name
from sunset.output_files import folder_name, write_text
from sunset.perception import load_model
from sunset.recording import (
    PLAN_FILE,
    PLAN_VERSION,
    RUN_FILE,
    SCORE_REFERENCES,
    CampaignPlan,
    StoredFlight,
    read_plan,
)
from sunset.scenarios import Scenario, load_suite, split_hash, suite
from sunset.schemas import check_fields, document_text
from sunset.seeding import check_seed
from sunset.system import loaded_extensions
from sunset.texts import counted, suggestion
from sunset.workers import Progress, check_jobs, end_if_imported, processors, worker_pool

REFERENCE_SUITES: Final = ("nofault", "degraded")
"""The suites that, without a managing system, give the first two rows of the paper's table."""

_CHANGING: Final = MappingProxyType({"manager_checksums": "managing system", "extensions": "extension"})
"""Key of a campaign's plan that holds checksums by name → what they are of, where that is the user's own."""


@dataclass(frozen=True, kw_only=True)
class BenchSpec:
    """One campaign.

    Repetition r runs every scenario with seed `seed + r`: all managing systems and all scenarios of one
    repetition see the same stretch of the flight, so that differences are paired.
    """

    suite: Annotated[str, Meta(description="the name of a suite or a folder of scenario files")] = "paper"
    """A suite's name, or the path of a folder with scenario files."""
    scenarios: tuple[str, ...] = ()
    """Those of the suite that are run, named with or without the suite; all if empty."""
    references: bool = True
    """Whether the paper's two reference rows are run too."""
    score: bool = True
    """Whether the managing systems that scores are measured between are run too, if none is `external`."""
    managers: tuple[str, ...] = ("none", "baseline")
    flights: tuple[str, ...] = ()
    """Flights that every scenario is run on, as `parse_flights` takes them; if empty, each is run on its own."""
    repetitions: int = 3
    seed: int = 1
    settings: Settings = field(default_factory=Settings)

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises:
            InvalidInputError: a value is of another type or out of range, or a managing system is named twice.
            ManagerError: the label of a managing system is not valid.
        """
        check_seed(self.seed)
        check_fields(self)
        if self.repetitions < 1:
            raise InvalidInputError(f"There must be at least 1 repetition, got {self.repetitions}.")
        check_seed(self.seed + self.repetitions - 1)
        names = [label or manager for label, manager in map(split_label, self.managers)]
        if not names or len(set(names)) < len(names):
            named = ", ".join(names) or "none at all"
            raise InvalidInputError(f"Each managing system must be named once, got {named}.")
        parse_flights(self.flights)
        if self.flights and (self.settings.bag or self.settings.flight):
            raise InvalidInputError(
                "A campaign has one bag or several flights, not both: name the bag as a flight."
            )

    @property
    def added(self) -> tuple[str, ...]:
        """The managing systems that are run for the score, beside those that are named.

        None where one is `external`: it would take part in their runs.
        """
        if not self.score or any(manager == EXTERNAL for _, manager in map(split_label, self.managers)):
            return ()
        return tuple(name for name in SCORE_REFERENCES if name not in self.managers)


def plan(spec: BenchSpec) -> tuple[RunSpec, ...]:
    """Return all runs of a campaign, reference rows first, in the order in which they are started.

    Raises:
        ScenarioError: there is no such suite, or it is not usable.
        InvalidInputError: a scenario is not of the suite.
    """
    chosen = _chosen(spec)
    groups = [(suite(name), "none") for name in REFERENCE_SUITES] if spec.references else []
    groups += [(chosen, manager) for manager in (*spec.managers, *spec.added)]
    flights = [dataclasses.replace(spec.settings, flight=flight) for flight in parse_flights(spec.flights)]
    runs = (
        RunSpec(scenario=scenario, manager=manager, seed=spec.seed + repetition, settings=settings)
        # a repetition and a flight at a time: runs that share their frames are neighbours, for the inference cache
        for repetition in range(spec.repetitions)
        for settings in flights or [spec.settings]
        for scenarios, manager in groups
        for scenario in scenarios
    )
    return tuple({run_folder(Path(), one): one for one in runs}.values())  # each is run once


def flights_of(runs: Sequence[RunSpec]) -> list[RunSpec]:
    """Return the first run on each flight."""
    return list({_flown(one): one for one in reversed(runs)}.values())[::-1]


def _flown(one: RunSpec) -> tuple[object, ...]:
    """Return what tells a run's flight from another."""
    return one.flight, flight_plan(one)


def _chosen(spec: BenchSpec) -> tuple[Scenario, ...]:
    """Return the scenarios of the suite that are run, in its order."""
    every = {base_name(scenario.name): scenario for scenario in load_suite(spec.suite)}
    wanted = {name.removeprefix(f"{spec.suite}/") for name in spec.scenarios}
    for name in sorted(wanted - every.keys()):
        raise InvalidInputError(
            f"The suite {spec.suite} has no scenario {name!r}: {suggestion(name, every)}see 'sunset scenarios list "
            f"--suite {spec.suite}'."
        )
    return tuple(scenario for name, scenario in every.items() if name in wanted or not wanted)


def count_runs(out: Path) -> tuple[int, int] | None:
    """Return how many runs of a folder's campaign are there, and how many it has; None if it holds no campaign.

    Those of folders in it count, too: of one campaign, once, such as its shards.
    """
    found: dict[bytes, tuple[int, set[Path]]] = {}
    for file in sorted([*out.glob(PLAN_FILE), *out.glob(f"*/{PLAN_FILE}")]):
        try:
            planned = read_plan(file.parent).runs
        except RecordError:
            continue
        runs = found.setdefault(file.read_bytes(), (planned, set()))[1]
        runs.update(run.relative_to(file.parent) for run in file.parent.glob(f"runs/*/*/*/seed-*/{RUN_FILE}"))
    if not found:
        return None
    return sum(len(runs) for _, runs in found.values()), sum(planned for planned, _ in found.values())


def run_folder(out: Path, spec: RunSpec) -> Path:
    """Return where a campaign in `out` keeps this run."""
    parts = (spec.suite or "own", spec.manager_name, base_name(spec.scenario.name))
    flight = f"-{spec.settings.flight.name}" if spec.settings.flight else ""
    return out.joinpath(
        "runs", *(folder_name(part) for part in parts), folder_name(f"seed-{spec.seed}{flight}")
    )


def bench(
    spec: BenchSpec,
    out: Path,
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
    shard: Shard | None = None,
    progress: Progress | None = None,
) -> int:
    """Run a campaign; runs that `out` holds already are not repeated.

    Every run is written to a temporary folder and renamed when it is complete, so that nothing that was
    finished is lost, whatever ends this process, and an interrupted campaign is continued by the same call.
    Worker processes import the script that calls this, which should therefore do so below `if __name__ == "__main__":`.

    Args:
        spec: what to run.
        out: the folder of results; it is made if there is none, and must belong to the same campaign.
        jobs: number of worker processes; if None one a core, or one in all for live runs, which need the processor
            in time. It has no influence on any result of the simulation.
        executor: does the runs in the place of worker processes, also on other computers; it is not shut down.
        shard: the part of the campaign that is run; all if None.
        progress: called with (runs that are done, runs in all), first with those that an earlier call had done.

    Returns:
        How many runs this call has done.

    Raises:
        InvalidInputError: `out` holds another campaign, or a scenario, model or bag is not usable; or an executor
            cannot do the runs.
        ManagerError: a managing system cannot be loaded or failed.
        OutputError: `out` cannot be written, or another process runs its campaign.
        SunsetError: a worker process was killed, or the executor has failed.
    """
    end_if_imported()
    check_jobs(jobs)
    if executor is not None:
        _check_executor(executor, spec, jobs)
    runs = plan(spec)
    wanted = runs if shard is None else shard.of(runs)
    # rendering and measuring flights and loading a model are done once, before the workers need them
    of_flights = flights_of(runs)
    prepared = list(zip(of_flights, prepare_all(of_flights), strict=True))
    described = _describe(spec, runs, prepared)
    checksums = described.manager_checksums
    with locked_campaign(out, shard):
        _claim(out, described)
        places = [(one, run_folder(out, one), checksums.get(one.manager_name)) for one in wanted]
        todo = [place for place in places if not (place[1] / RUN_FILE).is_file()]
        done = len(wanted) - len(todo)
        if progress is not None:
            progress(done, len(wanted))
        if todo and executor is not None:
            facts = {_flown(one): facts_of(resources) for one, resources in prepared}
            counts = run_on_workers(executor, [(*place, facts[_flown(place[0])]) for place in todo])
        else:
            jobs = jobs or (1 if spec.settings.live else processors())
            counts = _run_all(todo, min(jobs, len(todo)))
        for count in counts if todo else ():
            if progress is not None:
                progress(done + count, len(wanted))
    return len(todo)


def _check_executor(executor: Executor, spec: BenchSpec, jobs: int | None) -> None:
    """Make sure that an executor can do the runs of a campaign.

    Raises:
        InvalidInputError: it cannot.
    """
    check_executor(executor)
    if jobs is not None:
        raise InvalidInputError(
            f"An executor has workers of its own, got {counted(jobs, 'job')} besides: leave the jobs out."
        )
    if spec.settings.live:
        raise InvalidInputError("Live runs take place on this computer: leave the executor out.")
    for label, manager in map(split_label, spec.managers):
        if is_registered(manager):
            raise InvalidInputError(
                f"An executor's workers do not have the managing system {label or manager}, which was passed as a "
                "class or function: name it FILE.py:Class or module:Class."
            )


def _run_all(todo: Sequence[tuple[RunSpec, Path, str | None]], jobs: int) -> Iterator[int]:
    """Do all runs, each into its folder, with the managing system's checksum; yield how many are finished, after each.

    Simulated ones are done by other processes, as many at a time as there are jobs.
    """
    if todo[0][0].settings.live and jobs == 1:
        for count, one in enumerate(todo, 1):
            run_of_campaign(*one)
            yield count
        return
    forked = any(is_registered(spec.manager) for spec, _, _ in todo)
    with worker_pool(jobs, forked=forked) as pool:
        futures = [pool.submit(run_of_campaign, *one) for one in todo]
        for count, future in enumerate(as_completed(futures), 1):
            future.result()
            yield count


def _claim(out: Path, plan: CampaignPlan) -> None:
    """Write the campaign's plan into its folder, or check that it is the one that stands there.

    Raises:
        InvalidInputError: another one stands there, or none that can be read, or nothing says whether a managing system
            is the same.
    """
    file = out / PLAN_FILE
    if not file.exists():
        write_text(file, document_text(plan))
        return
    theirs, ours = _flat(read_plan(out)), _flat(plan)
    differing = sorted(key for key in ours | theirs if theirs.get(key) != ours.get(key))
    if differing:
        # a name that differs says more than the checksum or the number that differs with it
        key = min(differing, key=lambda name: (name == "runs", "checksum" in name or "flight_facts" in name))
        kind, _, name = key.partition(".")
        changed = _CHANGING.get(kind)
        if changed and key in ours and key in theirs:
            raise InvalidInputError(
                f"The {changed} {name} has changed since the campaign in {out} was begun, and its runs are of the old "
                "one; name a new folder."
            )
        if kind == "extensions":
            word = "with" if key in theirs else "without"
            raise InvalidInputError(
                f"The campaign in {out} was begun {word} the extension {name}; name the same extensions, or a new "
                "folder."
            )
        several = kind == key and key.endswith("s") and not isinstance(ours[key], bool)
        verb = "are" if several else "is"
        raise InvalidInputError(
            f"The folder {out} holds another campaign: its {key} {verb} {theirs.get(key)!r}, this one's {verb} "
            f"{ours.get(key)!r}; name a new folder."
        )
    for label, manager in map(split_label, plan.managers):
        if is_registered(manager) and not plan.manager_checksums[label or manager]:
            raise InvalidInputError(
                f"The campaign in {out} cannot be continued: nothing says whether its managing system "
                f"{label or manager} is the same as then: pass a class, or name a new folder."
            )


def _flat(plan: CampaignPlan) -> dict[str, object]:
    """Return a plan by key, with the entries of its dictionaries as entries of its own: `versions.numpy`."""
    flat: dict[str, object] = {}
    for key, value in asdict(plan).items():
        inner = {f"{key}.{name}": one for name, one in value.items()} if isinstance(value, dict) else {}
        if key == "flight_facts":
            inner = {
                f"{name}.{part}": fact for name, one in inner.items() for part, fact in asdict(one).items()
            }
        if not isinstance(value, dict):
            inner = {key: list(value) if isinstance(value, tuple) else value}
        flat |= inner
    return flat


def _describe(
    spec: BenchSpec, runs: Sequence[RunSpec], prepared: Sequence[tuple[RunSpec, Resources]]
) -> CampaignPlan:
    """Return a campaign's plan as it is stored: whatever its results may depend on, by name and by content.

    Args:
        spec: the campaign.
        runs: all of it.
        prepared: the first run on each flight, and what it is made with.
    """
    own = [resources for _, resources in prepared if not resources.of_flight]
    resources = own[0] if own else prepared[0][1]
    return CampaignPlan(
        plan_version=PLAN_VERSION,
        suite=spec.suite,
        scenarios=tuple(one.name for one in _chosen(spec)) if spec.scenarios else (),
        scenarios_checksum=scenarios_checksum(runs),
        split=split_hash(spec.suite),
        references=spec.references,
        score=spec.score,
        managers=spec.managers,
        manager_checksums={
            label or manager: manager_checksum(manager, limit_s=spec.settings.manager_limit_s)
            for label, manager in map(split_label, (*spec.managers, *spec.added))
        },
        repetitions=spec.repetitions,
        seed=spec.seed,
        runs=len(runs),
        model=spec.settings.model,
        model_checksum=model_checksum(load_model(spec.settings.model).card),
        bag=str(spec.settings.bag) if spec.settings.bag else None,
        bag_checksum=resources.bag_checksum,
        flights=spec.flights,
        flight_facts=_flight_facts(prepared),
        loop=spec.settings.loop,
        device=resources.segmenter.device,
        timing={
            name: value
            for name, value in dataclasses.asdict(spec.settings.timing).items()
            if value is not None
        },
        middleware=spec.settings.middleware,
        speed=spec.settings.speed,
        thinking_s=spec.settings.thinking_s,
        versions=versions(),
        extensions={one.name: one.checksum for one in loaded_extensions()},
    )


def _flight_facts(prepared: Sequence[tuple[RunSpec, Resources]]) -> dict[str, StoredFlight]:
    """Return what results depend on of each flight but the default one, by name.

    Raises:
        InvalidInputError: two flights have the same name.
    """
    facts: dict[str, StoredFlight] = {}
    for one, resources in prepared:
        if not resources.of_flight:
            continue
        name = flight_name(one)
        if name in facts:
            raise InvalidInputError(
                f"Two flights of the campaign are called {name}, and the bag {resources.bag.path} is one of them: "
                "rename it."
            )
        card = resources.model.card
        facts[name] = StoredFlight(
            bag_checksum=resources.bag_checksum,
            conditions=UNSET if one.flight.bag else one.flight.conditions(),
            entropy_threshold=card.entropy_threshold,
            sharpness_threshold=card.sharpness_threshold,
            warning=resources.warning,
        )
    return facts


def scenarios_checksum(runs: Sequence[RunSpec]) -> str:
    """Return the SHA-256 of the scenarios of a campaign's runs, in hexadecimal."""
    return _checksum(repr([one.scenario for one in runs]))


def _checksum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()
