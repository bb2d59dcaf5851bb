"""The catalogue: suites, scenarios, faults and managing systems."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import sunset
from sunset.api.arguments import as_path, names_of
from sunset.scenarios import Scenario, generate, load_suite, scenario_names, suite_names
from sunset.system import Fault, current_system, get_fault

__all__ = [
    "Fault",
    "failure_text",
    "get_fault",
    "list_faults",
    "list_managers",
    "list_scenarios",
    "list_suites",
    "make_scenario",
    "scenario_names",
    "severities",
]

if TYPE_CHECKING:
    from sunset.managing import ManagingSystem


def list_suites() -> tuple[str, ...]:
    """Return the names of the suites."""
    return suite_names()


def list_scenarios(suite: str | Path | None = None) -> tuple[str, ...]:
    """Return the names of the scenarios of a suite, or of a folder of scenario files; of all suites if it is None.

    Raises:
        ScenarioError: the suite does not exist, or is not usable.
    """
    if suite is None:
        return tuple(name for each in suite_names() for name in list_scenarios(each))
    place = suite if isinstance(suite, str) else as_path(suite, "suite")
    return tuple(scenario.name for scenario in load_suite(place))


def make_scenario(*faults: str, name: str = "") -> Scenario:
    """Make a scenario of faults, each as `FAULT` or `FAULT=STRENGTH`, as `sunset scenarios generate` does.

    Raises:
        ScenarioError: a fault or its strength is not valid.
    """
    return generate(names_of(list(faults), "faults"), name=name)


def list_faults() -> tuple[Fault, ...]:
    """Return the catalogue of faults."""
    return tuple(current_system().faults.values())


def failure_text(fault: Fault) -> str:
    """Return the failure that a fault shows as, with its description."""
    return f"{fault.failure}: {current_system().failures[fault.failure].description}"


def severities(fault: Fault, model: str) -> str:
    """Return a fault's strengths by severity for a model, in words."""
    card = sunset.load_model(model).card
    strengths = enumerate(card.severities.get(fault.name, ()), 1)
    levels = [f"{number}: {strength:g}" for number, strength in strengths if strength is not None]
    return f"{', '.join(levels) or 'not measured'}, with the model {card.name}"


def list_managers() -> "Mapping[str, type[ManagingSystem]]":
    """Return the managing systems that come with SUNSET, by name."""
    from sunset.managing import MANAGERS  # noqa: PLC0415  slow, and not needed for the other lists

    return MANAGERS
