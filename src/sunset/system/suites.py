"""The names of a suite's scenarios."""

from functools import lru_cache
from typing import Annotated, TypeAlias

import yaml
from msgspec import Meta

from sunset.errors import MALFORMED_YAML, ExtensionError
from sunset.system.names import scenario_name

Suite: TypeAlias = Annotated[
    tuple[tuple[str, ...], ...] | str, Meta(description="tuples of faults or a YAML text")
]
"""Scenarios, each the faults that are injected together, as `fault` or `fault=value`; or a YAML list of scenarios."""


@lru_cache(maxsize=64)
def names_in_suite(name: str, suite: Suite) -> tuple[str, ...]:
    """Return the names of a suite's scenarios, in its order.

    Raises:
        ExtensionError: the text is not a YAML list of mappings with names, or a scenario is there twice.

    >>> names_in_suite("mine", "[{name: late, faults: []}]"), names_in_suite("mine", (("gpu_failure",),))
    (('mine/late',), ('mine/gpu_failure',))
    """
    if not isinstance(suite, str):
        names = tuple(scenario_name(name, faults) for faults in suite)
        for scenario in names:
            if names.count(scenario) > 1:
                raise ExtensionError(f"The suite {name} has the scenario {scenario} twice; name each once.")
        return names
    error = f"The suite {name} must be a YAML list of scenarios"
    try:
        scenarios = yaml.safe_load(suite)
    except (yaml.YAMLError, *MALFORMED_YAML) as cause:
        raise ExtensionError(f"{error}: {' '.join(str(cause).split())}.") from cause
    if not isinstance(scenarios, list) or not all(
        isinstance(item, dict) and "name" in item for item in scenarios
    ):
        raise ExtensionError(f"{error}: each must be a mapping with a name.")
    return tuple(f"{name}/{item['name']}" for item in scenarios)
