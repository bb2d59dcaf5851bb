"""Scenarios by name, from YAML files, or made of faults joined by `+`; and the suites of the managed system."""

import os
import re
import shlex
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Final

from sunset.errors import ScenarioError
from sunset.files.inputs import read_bytes
from sunset.scenarios.reading import parse_scenario, parse_suite
from sunset.scenarios.schema import Scenario, parse_fault
from sunset.scenarios.splits import MAX_BYTES, SPLITS, WILD, is_scenario_file, read_split, scenario_files
from sunset.system import System, all_suites, current_system, find_fault, scenario_name
from sunset.texts.names import base_name
from sunset_ros.texts import shown, suggestion

_DRAWN: Final = re.compile(rf"({'|'.join(split for split in SPLITS if split != WILD)})-\d+")
"""The name of a scenario of a split, except the split with the name of a suite."""


def suite_names() -> tuple[str, ...]:
    """Return the names of all suites.

    >>> suite_names()[:4]
    ('paper', 'artifact', 'nofault', 'degraded')
    """
    return tuple(all_suites())


def suite(name: str) -> tuple[Scenario, ...]:
    """Return the scenarios of a suite, in a fixed order.

    Raises:
        ScenarioError: the suite is unknown, and the message lists all suites; or its text is not usable.

    >>> len(suite("paper"))
    54
    """
    names = suite_names()
    if name not in names:
        raise ScenarioError(
            f"There is no suite {name!r}: {suggestion(name, names)}name {', '.join(names)} or a folder of "
            "scenario files. If an extension adds it, pass --extension."
        )
    return _suite(current_system(), name)


@lru_cache(maxsize=64)
def _suite(system: System, name: str) -> tuple[Scenario, ...]:
    del system  # the results are those of a system
    scenarios = all_suites()[name]
    if isinstance(scenarios, str):
        return parse_suite(scenarios, name)
    made: dict[str, Scenario] = {}
    for faults in scenarios:
        try:
            scenario = generate(faults, name=scenario_name(name, faults))
        except ScenarioError as error:
            raise ScenarioError(f"The suite {name} is not usable: {error}") from error
        if scenario.name in made:
            raise ScenarioError(f"The suite {name} has the scenario {scenario.name} twice; name each once.")
        sentences = " ".join(fault.fault.description for fault in scenario.faults)
        made[scenario.name] = replace(scenario, description=sentences or "Nothing goes wrong.")
    return tuple(made.values())


def suite_of(scenario: Scenario) -> str:
    """Return the suite that contains a scenario, or the split that it is named after; empty if it is in neither.

    >>> suite_of(Scenario("nofault")), suite_of(Scenario("nofault", (parse_fault("gpu_failure"),)))
    ('nofault', '')
    >>> suite_of(Scenario("test-0001"))
    'test'
    """
    if drawn := _DRAWN.fullmatch(scenario.name):
        return drawn[1]
    name = scenario.name.split("/", 1)[0]
    if name not in suite_names():
        return ""
    same = ((other.name, other.faults) == (scenario.name, scenario.faults) for other in suite(name))
    return name if any(same) else ""


def suite_size(name: str) -> int:
    """Return the number of scenarios in a suite; 0 if the system lacks it."""
    return len(suite(name)) if name in suite_names() else 0


def scenario_names() -> tuple[str, ...]:
    """Return the names of the scenarios of all suites."""
    return tuple(scenario.name for name in suite_names() for scenario in suite(name))


def load_scenario(name: str | Path) -> Scenario:
    """Return a scenario by name, from a file, or made of faults.

    Args:
        name: a name of `scenario_names()`; or the path of a YAML file, which ends in `.yaml` or `.yml`
            or exists; or faults of the catalogue joined by `+`, such as `gpu_failure+image_shift`.

    Raises:
        ScenarioError: it is none of these, or the file is not readable or not a scenario.

    >>> [fault.value for fault in load_scenario("gpu_failure+image_shift").faults]
    [True, 10]
    """
    if not isinstance(name, str | Path):
        raise ScenarioError(
            "A scenario must be a name, a file, faults joined by +, or a result of sunset.load_scenario, got "
            f"{shown(name)}."
        )
    text = str(name)
    if (suite_name := text.split("/", 1)[0]) in suite_names():
        for scenario in suite(suite_name):
            if scenario.name == text:
                return scenario
    path = Path(name)
    if is_scenario_file(path) or os.path.isfile(path):  # noqa: PTH113  Path.is_file raises for a very long name
        return _from_file(path)
    faults = text.split("+")
    if isinstance(name, str) and any(find_fault(part.split("=", 1)[0]) for part in faults):
        return generate(faults)
    raise _unknown_error(text)


def _unknown_error(text: str) -> ScenarioError:
    is_folder = os.path.isdir(text)  # noqa: PTH112  see load_scenario
    if is_folder or text in suite_names():
        kind, parts = ("a folder, and so a suite", "files") if is_folder else ("a suite", "scenarios")
        return ScenarioError(
            f"{text!r} is {kind}: name one of its {parts}, or run all of its scenarios with 'sunset bench --suite "
            f"{shlex.quote(text)}'."
        )
    hint = suggestion(text, [*scenario_names(), *current_system().faults])
    return ScenarioError(
        f"There is no scenario {text!r}: {hint}name a scenario of the suites {', '.join(suite_names())} "
        "('sunset scenarios list'), a YAML file, or faults joined by +. If an extension adds it, pass --extension."
    )


def load_suite(name: str | Path) -> tuple[Scenario, ...]:
    """Return the scenarios of a suite by name, or of a folder of YAML files, in the files' order.

    Raises:
        ScenarioError: the suite or folder is unknown, or a file is not usable or does not match the folder's split.
    """
    folder = Path(name)
    # an empty name is not the current folder
    if str(name) in suite_names() or not name or not os.path.exists(folder):  # noqa: PTH110  see load_scenario
        return suite(str(name))
    if not folder.is_dir():
        raise ScenarioError(
            f"{str(name)!r} is a file, and a suite is a folder of scenario files: name its folder, or run the scenario "
            f"with 'sunset run {shlex.quote(str(name))}'."
        )
    try:
        files = scenario_files(folder)
    except OSError as error:
        raise ScenarioError(f"The suite {folder} cannot be read: {error.strerror}.") from error
    if not files:
        raise ScenarioError(f"The suite {folder} must have scenarios: there is no YAML file in this folder.")
    read_split(folder)  # raises if the files of a split were changed
    places: dict[str, Path] = {}
    scenarios = tuple(map(_from_file, files))
    for file, scenario in zip(files, scenarios, strict=True):
        short = base_name(scenario.name)
        if (other := places.setdefault(short, file)) != file:
            raise ScenarioError(f"The scenarios {other} and {file} are both called {short!r}: rename one.")
    return scenarios


def split_hash(name: str | Path) -> str:
    """Return the hash that pins the split in a suite's folder; empty if the suite is not a split."""
    described = None if str(name) in suite_names() else read_split(Path(name))
    return described.sha256 if described else ""


def generate(faults: Sequence[str], *, name: str = "") -> Scenario:
    """Make a scenario of faults.

    Args:
        faults: each as `name`, or `name=value` with a strength.
        name: the scenario's name; the faults joined by `+` if empty.

    >>> generate(["image_shift=20"]).faults[0].value
    20
    """
    return Scenario(name=name or "+".join(faults), faults=tuple(map(parse_fault, faults)))


def _from_file(path: Path) -> Scenario:
    try:
        text = read_bytes(path, MAX_BYTES).decode("utf-8-sig")
    except FileNotFoundError as error:
        raise ScenarioError(f"There is no scenario file {path}.") from error
    except OSError as error:
        raise ScenarioError(f"The scenario {path} cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise ScenarioError(f"The scenario {path} is not text in UTF-8 (byte {error.start}).") from error
    return parse_scenario(text, str(path))
