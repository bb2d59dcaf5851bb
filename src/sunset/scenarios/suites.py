"""The suites of the managed system, as scenarios."""

import re
from functools import lru_cache
from typing import Final

from sunset.errors import ScenarioError
from sunset.scenarios.fault import parse_fault
from sunset.scenarios.reading import parse_suite
from sunset.scenarios.schema import Scenario
from sunset.scenarios.splits import SPLITS, WILD
from sunset.system import System, all_suites, current_system, scenario_name
from sunset.texts import suggestion

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
    scenarios = all_suites()[name]
    if isinstance(scenarios, str):
        return parse_suite(scenarios, name)
    return tuple(_scenario(system, name, faults) for faults in scenarios)


def _scenario(system: System, suite_name: str, faults: tuple[str, ...]) -> Scenario:
    parsed = tuple(map(parse_fault, faults))
    sentences = " ".join(system.faults[fault.name].description for fault in parsed)
    return Scenario(scenario_name(suite_name, faults), parsed, sentences or "Nothing goes wrong.")


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


def scenario_names() -> tuple[str, ...]:
    """Return the names of the scenarios of all suites."""
    return tuple(scenario.name for name in suite_names() for scenario in suite(name))
