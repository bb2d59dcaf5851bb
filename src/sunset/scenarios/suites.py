"""The suites: named collections of scenarios, each made of the catalogue's faults at suite strength."""

from collections.abc import Iterator, Mapping
from itertools import combinations
from types import MappingProxyType
from typing import Final

from sunset.errors import ScenarioError
from sunset.faults import EXCLUSIVE, FAULTS
from sunset.scenarios.schema import Scenario, ScenarioFault
from sunset.texts import suggestion

__all__ = ["scenario_names", "suite", "suite_names", "suite_of"]

_OUTAGES: Final = (
    "camera_driver_issue",
    "hardware_disconnect",
    "sync_issue",
    "memory_leakage",
    "cuda_out_of_memory",
    "gpu_failure",
)
_DEGRADATIONS: Final = (
    "image_degradation",
    "unneeded_enhancement",
    "image_shift",
    "depth_degradation",
    "autofocus_needed",
)
"""The paper's faults, by name: faults that are added to the catalogue change no suite."""

_PAIRS: Final = tuple(
    pair
    for pair in combinations(_DEGRADATIONS, 2)
    if not any(set(pair) == set(exclusive) for exclusive in EXCLUSIVE)
)


def _scenario(suite_name: str, *faults: str) -> Scenario:
    description = " ".join(FAULTS[name].description for name in faults)
    return Scenario(
        name=f"{suite_name}/{'+'.join(faults)}",
        faults=tuple(ScenarioFault(name) for name in faults),
        description=description,
    )


def _paper() -> Iterator[Scenario]:
    """Every outage with every two of the other faults that can be there together (paper, section 4)."""
    for outage in _OUTAGES:
        for pair in _PAIRS:
            yield _scenario("paper", outage, *pair)


def _artifact() -> Iterator[Scenario]:
    """Every outage with one degradation and a blurred image, as in the published exemplar's files."""
    for outage in _OUTAGES:
        for one in ("image_degradation", "depth_degradation", "image_shift"):
            yield _scenario("artifact", outage, one, "autofocus_needed")


def _degraded() -> Iterator[Scenario]:
    """The pairs of the paper's suite without an outage: the table's second row."""
    for pair in _PAIRS:
        yield _scenario("degraded", *pair)


def _nofault() -> Iterator[Scenario]:
    """A healthy run: the table's first row."""
    yield Scenario(name="nofault", description="Nothing goes wrong.")


_SUITES: Final[Mapping[str, tuple[Scenario, ...]]] = MappingProxyType(
    {
        "paper": tuple(_paper()),
        "artifact": tuple(_artifact()),
        "nofault": tuple(_nofault()),
        "degraded": tuple(_degraded()),
    }
)


def suite_names() -> tuple[str, ...]:
    """Return the names of all suites.

    >>> suite_names()
    ('paper', 'artifact', 'nofault', 'degraded')
    """
    return tuple(_SUITES)


def suite(name: str) -> tuple[Scenario, ...]:
    """Return the scenarios of a suite, in a fixed order.

    Raises:
        ScenarioError: there is no such suite; the message lists those that there are.

    >>> len(suite("paper"))
    54
    """
    try:
        return _SUITES[name]
    except KeyError:
        raise ScenarioError(
            f"There is no suite {name!r}: {suggestion(name, _SUITES)}name {', '.join(_SUITES)} or a folder of "
            "scenario files."
        ) from None


def suite_of(scenario: Scenario) -> str:
    """Return the name of the suite that has a scenario, with its name and its faults; empty if none has.

    >>> suite_of(Scenario("nofault")), suite_of(Scenario("nofault", (ScenarioFault("gpu_failure"),)))
    ('nofault', '')
    """
    what = (scenario.name, scenario.faults)
    suites = (
        name for name, scenarios in _SUITES.items() if what in [(one.name, one.faults) for one in scenarios]
    )
    return next(suites, "")


def scenario_names() -> tuple[str, ...]:
    """Return the names of the scenarios of all suites."""
    return tuple(scenario.name for scenarios in _SUITES.values() for scenario in scenarios)
