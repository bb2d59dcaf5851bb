"""What every call that runs experiments takes: the command line's options, by the same names."""

import operator
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TypeAlias, TypedDict

from sunset.errors import InvalidInputError, ManagerError, ScenarioError
from sunset.experiments import Settings, Timing
from sunset.managing import ManagingSystem, register_manager
from sunset.scenarios import Scenario, load_scenario
from sunset.system import System, extended_system
from sunset.texts import shorten, suggestion

Manager: TypeAlias = str | type[ManagingSystem] | Callable[..., ManagingSystem]
"""A managing system: its name, its class, or a function that makes one."""


Extensions: TypeAlias = str | Path | Sequence[str | Path]
"""Extensions of the managed system, one or several: Python files, or names of installed ones."""


class Options(TypedDict, total=False):
    """How experiments are run, whatever their scenario and whoever manages them."""

    model: str | Path
    """A model's name, or the folder of one's own; `lite` if left out."""
    bag: str | Path | None
    """A rosbag2 to fly instead of the default flight."""
    loop: bool
    """Whether a bag that is too short begins again at its first frame after its last."""
    device: str
    """What networks run on: `cpu`, `cuda` or `auto`."""
    duration: float
    """Seconds that are measured; 20 if left out."""
    cache: bool
    """Whether results of inference are looked up and kept in the user's cache folder; True if left out."""
    manager_limit: float
    """Seconds of wall time that one callback of the managing system may take; in the simulation."""
    middleware: str
    """`sim`, or the name of a live middleware."""
    rate: float
    """Seconds of `/clock` in a second; live."""
    extensions: Extensions
    """What the managed system is extended by, until the call returns."""


def settings_of(options: Options) -> Settings:
    """Return the settings that options describe.

    Raises:
        InvalidInputError: there is no such option, or a value is of another type or out of range.
    """
    for name in options:
        if name not in Options.__annotations__:
            raise InvalidInputError(
                f"There is no option {name!r}: {suggestion(name, Options.__annotations__)}choose among "
                f"{', '.join(Options.__annotations__)}."
            )
    default, bag, model = Settings(), options.get("bag"), options.get("model", "lite")
    return Settings(
        model=str(model) if isinstance(model, Path) else model,
        bag=as_path(bag, "bag") if bag is not None else None,
        loop=options.get("loop", default.loop),
        device=options.get("device", default.device),
        timing=Timing(duration_s=options.get("duration", default.timing.duration_s)),
        cache=options.get("cache", default.cache),
        manager_limit_s=options.get("manager_limit", default.manager_limit_s),
        middleware=options.get("middleware", default.middleware),
        speed=options.get("rate", default.speed),
    )


def extended(extensions: Extensions) -> AbstractContextManager[System]:
    """Return a context in which the managed system has these extensions.

    Raises:
        InvalidInputError: they are neither paths nor names.
        ExtensionError: one cannot be loaded, which is found when the context is entered.
    """
    named = [extensions] if isinstance(extensions, str | Path) else extensions
    if not isinstance(named, list | tuple):
        raise InvalidInputError(
            f"The extensions must be a path, a name, or a list of them, got {_shown(named)}."
        )
    return extended_system([str(as_path(extension, "extension")) for extension in named])


def as_path(path: str | Path, what: str) -> Path:
    """Return a path that was given as a text or a path.

    Raises:
        InvalidInputError: it is neither, or empty; `what` says what it is of.
    """
    if not isinstance(path, str | Path) or not str(path) or "\0" in str(path):
        raise InvalidInputError(f"The {what} must be a path, got {_shown(path)}.")
    return Path(path)


def seed_of(seed: int) -> int:
    """Return a seed as Python's own number, whatever library it comes from; what is none is left to be refused."""
    try:
        return seed if isinstance(seed, bool) else operator.index(seed)
    except TypeError:
        return seed


def scenario_of(scenario: str | Path | Scenario) -> Scenario:
    """Return a scenario by name, from a file, made of faults, or as it is.

    Raises:
        ScenarioError: there is none of that name, or it is none.
    """
    if isinstance(scenario, Scenario):
        return scenario
    if not isinstance(scenario, str | Path):
        raise ScenarioError(
            "A scenario must be a name, a file, faults joined by +, or what sunset.load_scenario returned, got "
            f"{_shown(scenario)}."
        )
    return load_scenario(scenario)


def names_of(names: str | tuple[str, ...] | list[str], what: str) -> tuple[str, ...]:
    """Return names that were given as a list, or as one text in which commas separate them.

    Raises:
        InvalidInputError: they are anything else; `what` says what they are of.
    """
    listed = names.split(",") if isinstance(names, str) else names
    if not isinstance(listed, list | tuple) or not all(isinstance(name, str) for name in listed):
        raise InvalidInputError(f"The {what} must be a list of names, got {_shown(names)}.")
    return tuple(name.strip() for name in listed if name.strip())


def manager_name(manager: Manager) -> str:
    """Return the name by which experiments load a managing system.

    Raises:
        ManagerError: it is none.
    """
    return manager if isinstance(manager, str) else register_manager(manager)


def manager_names(
    managers: Manager | Mapping[str, Manager] | list[Manager] | tuple[Manager, ...],
) -> tuple[str, ...]:
    """Return the names, with their labels, of managing systems that were given as a list, or by label.

    Raises:
        ManagerError: one is none, or two have the same name.
    """
    if isinstance(managers, Mapping):
        if not all(isinstance(label, str) for label in managers):
            raise ManagerError(f"The labels of managing systems must be texts, got {_shown(list(managers))}.")
        firsts: dict[str, Manager] = {}
        labelled = {label: manager_name(manager) for label, manager in managers.items()}
        for label, manager in managers.items():
            if not isinstance(manager, str):  # the name may have been given to a later one
                shared = firsts.setdefault(labelled[label], manager) is not manager
                own = f"{labelled[label]} ({label})" if shared else labelled[label]
                labelled[label] = register_manager(manager, own)
        return tuple(name if label == name else f"{label}={name}" for label, name in labelled.items())
    if isinstance(managers, str):
        return names_of(managers, "managing systems")
    listed: list[Manager] = list(managers) if isinstance(managers, list | tuple) else [managers]
    names = [manager_name(manager) for manager in listed]
    _check_distinct(listed, names)
    return tuple(names)


def _check_distinct(managers: list[Manager], names: list[str]) -> None:
    classes: dict[str, Manager] = {}
    for manager, name in zip(managers, names, strict=True):
        if not isinstance(manager, str) and classes.setdefault(name, manager) is not manager:
            raise ManagerError(f"Two managing systems are called {name}: give each a label.")


def _shown(value: object) -> str:
    return shorten(repr(value), 80)
