"""Arguments of calls that run experiments, as specifications of runs and campaigns."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from sunset.api.arguments import (
    as_path,
    check_names,
    chosen_flights,
    chosen_names,
    names_of,
    number_of,
    whole_of,
)
from sunset.errors import ManagerError
from sunset.experiments import OPTIONS, BenchSpec, Options, RunSpec, Settings, Timing
from sunset.managing import ManagingSystem, register_manager
from sunset.scenarios import Scenario, load_scenario
from sunset_ros.texts import shown

Manager: TypeAlias = str | type[ManagingSystem] | Callable[..., ManagingSystem]
"""A managing system: its name, its class, or a function that makes it."""

Managers: TypeAlias = Manager | Mapping[str, Manager] | list[Manager] | tuple[Manager, ...]

Names: TypeAlias = str | list[str] | tuple[str, ...]
Flights: TypeAlias = str | Path | list[str | Path] | tuple[str | Path, ...]


class CampaignOptions(Options, total=False):
    """Options of campaigns; each can be left out.

    Attributes:
        scenarios: names of some scenarios of the suite; all if left out.
        flights: flights that every scenario is run on: `panel`, names of its flights, `default`, or bags, also as
            `LABEL=PATH`; each scenario's own flight if left out.
        references: whether the paper's two reference rows are run too; True if left out.
        score: whether `none` and `oracle` are run too, which scores are measured between; True if left out.
        repetitions: runs of each scenario, at least 1; 3 if left out.
        seed: seed of the first repetition; 1 if left out.
    """

    scenarios: Names
    flights: Flights
    references: bool
    score: bool
    repetitions: int
    seed: int


def settings_of(options: Mapping[str, Any]) -> Settings:
    """Return the settings of a run from options of calls.

    Raises:
        InvalidInputError: an option is unknown, or a value has another type or is out of range.
    """
    check_names(options, Options.__annotations__)
    values: dict[str, Any] = {
        OPTIONS[name].name: number_of(value) for name, value in options.items() if name in OPTIONS
    }
    if isinstance(values.get("model"), Path):
        values["model"] = str(values["model"])
    if values.get("bag") is not None:
        values["bag"] = as_path(values["bag"], "bag")
    if "manager_env" in values:
        values["manager_env"] = names_of(values["manager_env"], "environment variables")
    if isinstance(values.get("viewers"), list):
        values["viewers"] = tuple(values["viewers"])
    return Settings(timing=Timing(duration_s=values.pop("duration_s", None)), **values)


def run_spec_of(
    scenario: str | Path | Scenario, manager: Manager, seed: int, options: Mapping[str, Any]
) -> RunSpec:
    """Return the specification of a run from the arguments of `run`.

    Raises:
        InvalidInputError: an argument is not usable.
        ManagerError: the managing system is not usable, or is not a name although the run is live.
    """
    settings = settings_of(options)
    return RunSpec(
        scenario=scenario if isinstance(scenario, Scenario) else load_scenario(scenario),
        manager=_manager_name(manager, settings),
        seed=whole_of(seed),
        settings=settings,
    )


def campaign_of(suite: str | Path, managers: Managers, options: Mapping[str, Any]) -> BenchSpec:
    """Return the specification of a campaign from the arguments of `bench`.

    Raises:
        InvalidInputError: an argument is not usable.
    """
    check_names(options, CampaignOptions.__annotations__)
    own = {name: whole_of(options[name]) for name in options if name not in Options.__annotations__}
    settings = settings_of({name: value for name, value in options.items() if name not in own})
    return BenchSpec(
        suite=str(suite) if isinstance(suite, Path) else suite,
        scenarios=chosen_names(
            own.pop("scenarios", ()), "scenarios", values="names of the suite's", default="all"
        ),
        managers=_manager_names(managers, settings),
        flights=chosen_flights(own.pop("flights", ())),
        settings=settings,
        **own,
    )


def _manager_name(manager: Manager, settings: Settings) -> str:
    """Return the name by which experiments load a managing system."""
    if isinstance(manager, str):
        return manager
    if settings.live and callable(manager):  # its process is not forked from this process
        raise ManagerError(
            f"A class or function cannot manage a live run, got {shown(manager)}: live, name it FILE.py:Class or "
            "module:Class."
        )
    return register_manager(manager)


def _manager_names(managers: Managers, settings: Settings) -> tuple[str, ...]:
    """Return the names, with their labels, of managing systems that were given as a list, or by label."""
    if isinstance(managers, Mapping):
        return _labelled_names(managers, settings)
    if isinstance(managers, str):
        return names_of(managers, "managing systems")
    listed: list[Manager] = list(managers) if isinstance(managers, list | tuple) else [managers]
    names = tuple(_manager_name(manager, settings) for manager in listed)
    classes: dict[str, Manager] = {}
    for manager, name in zip(listed, names, strict=True):
        if not isinstance(manager, str) and classes.setdefault(name, manager) is not manager:
            raise ManagerError(f"Two managing systems are called {name}: give each a label.")
    return names


def _labelled_names(managers: Mapping[str, Manager], settings: Settings) -> tuple[str, ...]:
    if not all(isinstance(label, str) for label in managers):
        raise ManagerError(f"The labels of managing systems must be texts, got {shown(list(managers))}.")
    firsts: dict[str, Manager] = {}
    names = {label: _manager_name(manager, settings) for label, manager in managers.items()}
    for label, manager in managers.items():
        if not isinstance(manager, str):  # the name may now belong to another class
            is_shared = firsts.setdefault(names[label], manager) is not manager
            names[label] = register_manager(
                manager, f"{names[label]} ({label})" if is_shared else names[label]
            )
    return tuple(name if label == name else f"{label}={name}" for label, name in names.items())
