"""Campaigns: their specification, their runs, and the plan that is stored with their results."""

import dataclasses
import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Final

from msgspec import UNSET, Meta

from sunset.errors import InvalidInputError
from sunset.experiments.manager import manager_checksum
from sunset.experiments.resources import Resources, flight_name, flight_plan, model_checksum
from sunset.experiments.run import versions
from sunset.experiments.settings import Settings
from sunset.experiments.spec import RunSpec
from sunset.files.outputs import folder_name
from sunset.files.schemas import check_fields
from sunset.flights import parse_flights
from sunset.managing import EXTERNAL, split_label
from sunset.perception import load_model
from sunset.recording import (
    PLAN_VERSION,
    SCORE_REFERENCES,
    SETTINGS,
    TABLE_REFERENCES,
    CampaignPlan,
    StoredFlight,
)
from sunset.scenarios import Scenario, load_suite, split_hash, suite
from sunset.system import REPAIR, loaded_extensions
from sunset.texts.names import base_name
from sunset_ros.seeding import check_seed
from sunset_ros.texts import suggestion

_MOST_REPETITIONS: Final = 1000
"""All runs of a campaign are planned before the first one; of more, nothing would be seen for long."""


@dataclass(frozen=True, kw_only=True)
class BenchSpec:
    """A campaign.

    Repetition r runs every scenario with seed `seed + r`: all managing systems and all scenarios of a
    repetition see the same stretch of the flight, so that differences are paired.
    """

    suite: Annotated[str, Meta(description="the name of a suite or a folder of scenario files")] = "paper"
    """A suite's name, or the path of a folder with scenario files."""
    scenarios: tuple[str, ...] = ()
    """The scenarios of the suite that are run, named with or without the suite; all if empty."""
    references: bool = True
    """Whether the paper's two reference rows are run too, if the task is to repair."""
    score: bool = True
    """Whether the managing systems that scores are measured between are run too, if none is `external`."""
    managers: tuple[str, ...] = ("none", "baseline")
    flights: tuple[str, ...] = ()
    """Flights that every scenario is run on, as `parse_flights` takes them; if empty, each is run on its own."""
    repetitions: int = 3
    seed: int = 1
    settings: Settings = field(default_factory=Settings)

    def __post_init__(self) -> None:
        check_seed(self.seed)
        check_fields(self)
        if not 1 <= self.repetitions <= _MOST_REPETITIONS:
            raise InvalidInputError(
                f"There must be at least 1 repetition, and at most {_MOST_REPETITIONS}, got {self.repetitions}."
            )
        check_seed(self.seed + self.repetitions - 1)
        names = [label or manager for label, manager in map(split_label, self.managers)]
        if not names or len(set(map(str.casefold, names))) < len(names):
            named = ", ".join(names) or "none at all"
            raise InvalidInputError(f"Each managing system must be named once, got {named}.")
        parse_flights(self.flights)
        if self.flights and (self.settings.bag or self.settings.flight):
            raise InvalidInputError(
                "A campaign has one bag or several flights, not both: name the bag as a flight."
            )


def added_managers(campaign: BenchSpec | CampaignPlan) -> tuple[str, ...]:
    """Return the managing systems that are run for the score besides those that are named.

    There are none for a campaign with `external`, which would take part in their runs.
    """
    if not campaign.score or any(manager == EXTERNAL for _, manager in map(split_label, campaign.managers)):
        return ()
    return tuple(name for name in SCORE_REFERENCES if name not in campaign.managers)


def campaign_managers(campaign: BenchSpec | CampaignPlan) -> dict[str, str]:
    """Return all managing systems that a campaign runs: the name in tables → the specification that is loaded."""
    named = map(split_label, (*campaign.managers, *added_managers(campaign)))
    return {label or manager: manager for label, manager in named}


def plan(spec: BenchSpec) -> tuple[RunSpec, ...]:
    """Return all runs of a campaign, reference rows first, and then by managing system."""
    chosen, size = _chosen(spec)
    of_paper = spec.references and spec.settings.task == REPAIR
    groups = [(suite(name), manager) for name, manager in TABLE_REFERENCES] if of_paper else []
    groups += [(chosen, manager) for manager in (*spec.managers, *added_managers(spec))]
    flights = [dataclasses.replace(spec.settings, flight=flight) for flight in parse_flights(spec.flights)]
    runs = (
        RunSpec(
            scenario=scenario,
            manager=manager,
            seed=spec.seed + repetition,
            settings=settings,
            suite_size=size,
        )
        # a repetition and a flight at a time: runs that share their frames are neighbours, for the cache
        for repetition in range(spec.repetitions)
        for settings in flights or [spec.settings]
        for scenarios, manager in groups
        for scenario in scenarios
    )
    return tuple({run_folder(Path(), run): run for run in runs}.values())  # each is run once


def in_turn(runs: Iterable[RunSpec]) -> list[RunSpec]:
    """Return a campaign's runs in the order in which they are started.

    All managing systems of a scenario and a seed come together, so that an interrupted campaign can be compared.
    """
    groups: dict[tuple[object, ...], list[RunSpec]] = {}
    for run in runs:
        groups.setdefault((run.seed, run.settings.flight, run.suite, run.scenario.name), []).append(run)
    return [run for group in groups.values() for run in group]


def flights_of(runs: Sequence[RunSpec]) -> list[RunSpec]:
    """Return the first run on each flight."""
    return list({(run.flight, flight_plan(run)): run for run in reversed(runs)}.values())[::-1]


def _chosen(spec: BenchSpec) -> tuple[tuple[Scenario, ...], int]:
    """Return the scenarios of the suite that are run, in its order, and the size of the suite."""
    every = {base_name(scenario.name): scenario for scenario in load_suite(spec.suite)}
    wanted = {name.removeprefix(f"{spec.suite}/") for name in spec.scenarios}
    for name in sorted(wanted - every.keys()):
        raise InvalidInputError(
            f"The suite {spec.suite} has no scenario {name!r}: {suggestion(name, every)}see 'sunset scenarios list "
            f"--suite {spec.suite}'."
        )
    chosen = (scenario for name, scenario in every.items() if name in wanted or not wanted)
    return tuple(chosen), len(every)


def run_folder(out: Path, spec: RunSpec) -> Path:
    """Return the folder of a run in a campaign's folder `out`."""
    parts = (spec.suite or "own", spec.manager_name, base_name(spec.scenario.name))
    flight = f"-{spec.settings.flight.name}" if spec.settings.flight else ""
    return out.joinpath(
        "runs", *(folder_name(part) for part in parts), folder_name(f"seed-{spec.seed}{flight}")
    )


def describe_campaign(
    spec: BenchSpec, runs: Sequence[RunSpec], prepared: Sequence[tuple[RunSpec, Resources]]
) -> CampaignPlan:
    """Return a campaign's plan as it is stored: everything its results may depend on, by name and by content.

    `prepared` has the first run on each flight, and its resources.
    """
    own = [resources for _, resources in prepared if not resources.of_flight]
    resources = own[0] if own else prepared[0][1]
    settings, managers = spec.settings, campaign_managers(spec)
    timing = dataclasses.asdict(settings.timing)
    names = ("suite", "references", "score", "managers", "repetitions", "seed", "flights")
    return CampaignPlan(
        plan_version=PLAN_VERSION,
        scenarios=tuple(scenario.name for scenario in _chosen(spec)[0]) if spec.scenarios else (),
        scenarios_checksum=hashlib.sha256(repr([run.scenario for run in runs]).encode()).hexdigest(),
        split=split_hash(spec.suite),
        manager_checksums={name: manager_checksum(manager, settings) for name, manager in managers.items()},
        runs=len(runs),
        model_checksum=model_checksum(load_model(settings.model).card),
        bag=str(settings.bag) if settings.bag else None,
        bag_checksum=resources.bag_checksum,
        flight_facts=_flight_facts(prepared),
        device=resources.segmenter.device,
        timing={name: value for name, value in timing.items() if value is not None},
        versions=versions(),
        extensions={extension.name: extension.checksum for extension in loaded_extensions()},
        **{name: getattr(spec, name) for name in names},
        **{name: getattr(settings, name) for name in ("model", "loop", "middleware", "speed", *SETTINGS)},
    )


def _flight_facts(prepared: Sequence[tuple[RunSpec, Resources]]) -> dict[str, StoredFlight]:
    """Return the facts that results depend on, of each flight except the default flight, by name."""
    facts: dict[str, StoredFlight] = {}
    for run, resources in prepared:
        if not resources.of_flight:
            continue
        name = flight_name(run)
        if name in facts:
            raise InvalidInputError(
                f"Two flights of the campaign are called {name}, and the bag {resources.bag.path} is one of them: "
                "rename it."
            )
        card = resources.model.card
        facts[name] = StoredFlight(
            bag_checksum=resources.bag_checksum,
            conditions=UNSET if run.flight.bag else run.flight.conditions(),
            entropy_threshold=card.entropy_threshold,
            sharpness_threshold=card.sharpness_threshold,
            warning=resources.warning,
        )
    return facts
