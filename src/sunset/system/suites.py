"""Suites as the description has them: faults as texts, or a YAML text that lists scenarios."""

from functools import lru_cache
from pathlib import Path
from typing import Final, TypeAlias

import yaml

from sunset.errors import MALFORMED_YAML, ExtensionError
from sunset.input_files import read_text
from sunset.system.names import scenario_name

Suite: TypeAlias = tuple[tuple[str, ...], ...] | str
"""Scenarios, each the faults that are injected together, as `fault` or `fault=value`; or a YAML text, a list."""

_FOLDER: Final = Path(__file__).parent / "suite_files"


def suite_text(name: str) -> str:
    """Return the YAML text of a suite that comes with SUNSET."""
    return read_text(_FOLDER / f"{name}.yaml")


@lru_cache(maxsize=64)
def names_in_suite(name: str, suite: Suite) -> tuple[str, ...]:
    """Return the names of a suite's scenarios, in its order.

    Raises:
        ExtensionError: it is a text that is not a YAML list of mappings with names, or has the same faults twice.

    >>> names_in_suite("mine", "[{name: late, faults: []}]"), names_in_suite("mine", (("gpu_failure",),))
    (('mine/late',), ('mine/gpu_failure',))
    """
    if not isinstance(suite, str):
        names = tuple(scenario_name(name, faults) for faults in suite)
        for number, one in enumerate(names):
            if one in names[:number]:
                raise ExtensionError(f"The suite {name} has the scenario {one} twice; name each once.")
        return names
    what = f"The suite {name} must be a YAML list of scenarios"
    try:
        scenarios = yaml.safe_load(suite)
    except (yaml.YAMLError, *MALFORMED_YAML) as error:
        raise ExtensionError(f"{what}: {' '.join(str(error).split())}.") from error
    if not isinstance(scenarios, list) or not all(
        isinstance(one, dict) and "name" in one for one in scenarios
    ):
        raise ExtensionError(f"{what}: each must be a mapping with a name.")
    return tuple(f"{name}/{one['name']}" for one in scenarios)
