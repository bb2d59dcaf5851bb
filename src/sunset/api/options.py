"""What every call that runs experiments takes: the command line's options, by the same names."""

import operator
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from decimal import Decimal
from math import inf
from numbers import Real
from pathlib import Path
from typing import Any, Final, TypeAlias, TypedDict

from sunset.errors import InvalidInputError, ManagerError
from sunset.experiments import Settings, Timing
from sunset.managing import ManagingSystem, register_manager
from sunset.scenarios import Scenario, load_scenario
from sunset.system import System, extended_system
from sunset.texts import shown, suggestion

Manager: TypeAlias = str | type[ManagingSystem] | Callable[..., ManagingSystem]
"""A managing system: its name, its class, or a function that makes one."""


Extensions: TypeAlias = str | Path | Sequence[str | Path]
"""Extensions of the managed system, one or several: Python files, or names of installed ones."""


_ITEMS: Final = re.compile(r"""(?:[^,'"\\]|\\.|'[^']*'|"(?:\\.|[^"\\])*"|['"\\])+""")
"""What commas separate, but for those in quotes or behind a backslash, as in the command of a program."""


class Options(TypedDict, total=False):
    """How experiments are run, whatever their scenario and managing system; each can be left out.

    Attributes:
        model: a model's name, or the folder of one's own; `lite` if left out.
        bag: a rosbag2 to fly instead of the default flight.
        loop: whether a bag that is too short begins again at its first frame after its last.
        device: what networks run on: `cpu`, `cuda` or `auto`.
        duration: seconds that are measured; as many as the scenario says if left out, which are 20 if it says nothing.
        cache: whether results of inference are looked up and kept in the user's cache folder; True if left out.
        images: whether the records keep images, as a file of their own.
        manager_limit: seconds of processor time that one callback of the managing system may take; ten times as much
            wall time.
        manager_env: names of environment variables that the managing system gets; their values are stored nowhere.
        task: `repair`, or `diagnose`, in which adaptations are refused; `repair` if left out.
        thinking: seconds of the experiment that every decision of the managing system takes; 0 if left out.
        middleware: `sim`, or the name of a live middleware.
        rate: seconds of `/clock` in a second; live.
        viewers: full names of nodes that only watch, such as `/rosbag2_recorder`; live.
        extensions: what the managed system is extended by, until the call returns.
    """

    model: str | Path
    bag: str | Path | None
    loop: bool
    device: str
    duration: float | None
    cache: bool
    images: bool
    manager_limit: float
    manager_env: str | Sequence[str]
    task: str
    thinking: float
    middleware: str
    rate: float
    viewers: list[str] | tuple[str, ...]
    extensions: Extensions


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
    viewers: Any = options.get("viewers", default.viewers)
    return Settings(
        model=str(model) if isinstance(model, Path) else model,
        bag=as_path(bag, "bag") if bag is not None else None,
        loop=options.get("loop", default.loop),
        device=options.get("device", default.device),
        timing=Timing(duration_s=number_of(options.get("duration"))),
        cache=options.get("cache", default.cache),
        images=options.get("images", default.images),
        manager_limit_s=number_of(options.get("manager_limit", default.manager_limit_s)),
        manager_env=names_of(options.get("manager_env", ()), "environment variables"),
        task=options.get("task", default.task),
        thinking_s=number_of(options.get("thinking", default.thinking_s)),
        middleware=options.get("middleware", default.middleware),
        speed=number_of(options.get("rate", default.speed)),
        viewers=tuple(viewers) if isinstance(viewers, list) else viewers,
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
            f"The extensions must be a path, a name, or a list of them, got {shown(named)}."
        )
    return extended_system([str(as_path(extension, "extension")) for extension in named])


def as_path(path: str | Path, what: str) -> Path:
    """Return a path that was given as a text or a path.

    Raises:
        InvalidInputError: it is neither, or empty, or no file can have it; `what` says what it is of.
    """
    if not isinstance(path, str | Path) or not str(path) or "\0" in str(path):
        raise InvalidInputError(f"The {what} must be a path, got {shown(path)}.")
    try:
        Path(path).exists()
    except OSError as error:
        raise InvalidInputError(f"The {what} cannot be {shown(str(path))}: {error.strerror}.") from error
    return Path(path)


def whole_of(value: Any) -> Any:
    """Return a whole number as Python's own, whatever library it comes from; what is not one is left to be refused."""
    try:
        return value if isinstance(value, bool) else operator.index(value)
    except TypeError:
        return value


def number_of(value: Any) -> Any:
    """Return a number as Python's own, whatever library it comes from; what is not one is left to be refused."""
    try:
        return value if isinstance(value, bool) or not isinstance(value, Real | Decimal) else float(value)
    except OverflowError:
        return inf


def count_of(number: int | None, what: str) -> int | None:
    """Return how many there shall be of something as Python's own number; None for as many as is usual.

    Raises:
        InvalidInputError: it is not a whole number from 1 on; `what` says of what.
    """
    count: int | None = whole_of(number)
    if count is not None and (isinstance(count, bool) or not isinstance(count, int) or count < 1):
        raise InvalidInputError(f"The number of {what} must be a whole one from 1 on, got {shown(number)}.")
    return count


def check_progress(progress: object) -> None:
    """Check that what shall be called with the progress can be called, before there is any.

    Raises:
        InvalidInputError: it cannot.
    """
    if progress is not None and not callable(progress):
        raise InvalidInputError(
            f"The progress must be a function that is called with it, got {shown(progress)}."
        )


def check_flags(**flags: object) -> None:
    """Check that values, by their names, are true or false.

    Raises:
        InvalidInputError: one is not.
    """
    for name, value in flags.items():
        if not isinstance(value, bool):
            raise InvalidInputError(f"The argument {name} must be true or false, got {shown(value)}.")


def scenario_of(scenario: str | Path | Scenario) -> Scenario:
    """Return a scenario by name, from a file, made of faults, or as it is.

    Raises:
        ScenarioError: there is none of that name, or it is not a scenario.
    """
    return scenario if isinstance(scenario, Scenario) else load_scenario(scenario)


def chosen_scenarios(names: str | tuple[str, ...] | list[str]) -> tuple[str, ...]:
    """Return the names of some scenarios of a suite, as `names_of` does; none at all for the whole suite.

    Raises:
        InvalidInputError: they are anything else, or empty, which is less than the whole suite.
    """
    chosen = names_of(names, "scenarios")
    if not chosen and names not in ((), []):
        raise InvalidInputError(
            f"The scenarios must be names of the suite's, got {shown(names)}; leave them out for all."
        )
    return chosen


def chosen_flights(names: str | Path | tuple[str | Path, ...] | list[str | Path]) -> tuple[str, ...]:
    """Return the flights that a campaign crosses its scenarios with, as `names_of` does; none for each one's own.

    Raises:
        InvalidInputError: they are anything else, or empty.
    """
    listed = [names] if isinstance(names, Path) else names
    if isinstance(listed, list | tuple):  # a path may have commas in it
        chosen = names_of([str(name) if isinstance(name, Path) else name for name in listed], "flights")
    else:
        chosen = names_of(listed, "flights")
    if not chosen and names not in ((), []):
        raise InvalidInputError(
            f"The flights must be names or bags, got {shown(names)}; leave them out for each scenario's own."
        )
    return chosen


def names_of(names: str | Sequence[str], what: str) -> tuple[str, ...]:
    """Return names that were given as a list, or as one text in which commas separate them, but for those in quotes.

    Raises:
        InvalidInputError: they are anything else; `what` says what they are of.
    """
    listed = _ITEMS.findall(names) if isinstance(names, str) else names
    if not isinstance(listed, list | tuple) or not all(isinstance(name, str) for name in listed):
        raise InvalidInputError(f"The {what} must be a list of names, got {shown(names)}.")
    return tuple(name.strip() for name in listed if name.strip())


def manager_name(manager: Manager) -> str:
    """Return the name by which experiments load a managing system.

    Raises:
        ManagerError: it is not a managing system.
    """
    return manager if isinstance(manager, str) else register_manager(manager)


def manager_names(
    managers: Manager | Mapping[str, Manager] | list[Manager] | tuple[Manager, ...],
) -> tuple[str, ...]:
    """Return the names, with their labels, of managing systems that were given as a list, or by label.

    Raises:
        ManagerError: one is not a managing system, or two have the same name.
    """
    if isinstance(managers, Mapping):
        if not all(isinstance(label, str) for label in managers):
            raise ManagerError(f"The labels of managing systems must be texts, got {shown(list(managers))}.")
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
