"""The suites of the system's description, as scenarios."""

from collections.abc import Mapping
from functools import lru_cache

from sunset.errors import ScenarioError
from sunset.scenarios.schema import Scenario, parse_fault
from sunset.system import System, current_system, scenario_name
from sunset.texts import suggestion


@lru_cache(maxsize=2)
def _suites(system: System) -> Mapping[str, tuple[Scenario, ...]]:
    """Return a system's suites: name → scenarios."""
    return {
        name: tuple(_scenario(system, name, faults) for faults in scenarios)
        for name, scenarios in system.suites.items()
    }


def _scenario(system: System, suite_name: str, texts: tuple[str, ...]) -> Scenario:
    """Return a scenario of a suite."""
    faults = tuple(parse_fault(text) for text in texts)
    return Scenario(
        name=scenario_name(suite_name, texts),
        faults=faults,
        description=" ".join(system.faults[fault.name].description for fault in faults)
        or "Nothing goes wrong.",
    )


def suite_names() -> tuple[str, ...]:
    """Return the names of all suites.

    >>> suite_names()
    ('paper', 'artifact', 'nofault', 'degraded')
    """
    return tuple(current_system().suites)


def suite(name: str) -> tuple[Scenario, ...]:
    """Return the scenarios of a suite, in a fixed order.

    Raises:
        ScenarioError: there is no such suite; the message lists those that there are.

    >>> len(suite("paper"))
    54
    """
    suites = _suites(current_system())
    if name not in suites:
        raise ScenarioError(
            f"There is no suite {name!r}: {suggestion(name, suites)}name {', '.join(suites)} or a folder of "
            "scenario files; what an extension adds needs --extension."
        )
    return suites[name]


def suite_of(scenario: Scenario) -> str:
    """Return the name of the suite that has a scenario, with its name and its faults; empty if none has.

    >>> suite_of(Scenario("nofault")), suite_of(Scenario("nofault", (parse_fault("gpu_failure"),)))
    ('nofault', '')
    """
    what = (scenario.name, scenario.faults)
    suites = (
        name
        for name, scenarios in _suites(current_system()).items()
        if what in [(one.name, one.faults) for one in scenarios]
    )
    return next(suites, "")


def scenario_names() -> tuple[str, ...]:
    """Return the names of the scenarios of all suites."""
    return tuple(scenario.name for scenarios in _suites(current_system()).values() for scenario in scenarios)
