"""The catalogue: suites, scenarios, splits of scenarios, faults and managing systems."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import sunset
from sunset.api.arguments import Extensions, as_path, extended, names_of, whole_of
from sunset.scenarios import (
    SPLITS,
    Scenario,
    SplitDescription,
    SplitSpec,
    generate,
    load_suite,
    read_salt,
    scenario_names,
    suite_names,
    write_split,
)
from sunset.scenarios import check_split as check_folder
from sunset.system import Fault, current_system, get_fault

__all__ = [
    "SPLITS",
    "Fault",
    "check_split",
    "failure_text",
    "generate_split",
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


def generate_split(
    split: str,
    count: int,
    out: str | Path,
    *,
    seed: int = 0,
    flights: bool = False,
    salt_file: str | Path | None = None,
    extensions: Extensions = (),
) -> SplitDescription:
    """Write scenarios for training, validation or test into a folder, as `sunset scenarios generate --split` does.

    Args:
        split: `train`, `validation`, `test` or `wild`; they never share a scenario.
        count: how many scenarios, from 1 to 9999; a smaller split is the beginning of a larger split.
        out: the folder, which must not exist, or be empty.
        seed: of everything that is drawn.
        flights: whether each scenario has a flight of its own, in place of the default flight.
        salt_file: a file with a secret that the draws depend on besides.
        extensions: of the managed system, whose faults are drawn, too.

    Returns:
        The content of the folder's `split.json`; `sha256` pins the scenarios.

    Raises:
        InvalidInputError: the split is unknown, a number is out of range, or the salt is not usable.
        OutputError: the folder is not empty, or cannot be written.
    """
    folder, salt = as_path(out, "folder of the split"), _salt(salt_file)
    with extended(extensions):
        spec = SplitSpec(split=split, count=whole_of(count), seed=whole_of(seed), flights=flights, salt=salt)
        return write_split(spec, folder)


def check_split(
    folder: str | Path, *, salt_file: str | Path | None = None, extensions: Extensions = ()
) -> SplitDescription:
    """Generate the split of a folder again and compare the scenarios, as `sunset scenarios check` does.

    Args:
        folder: the folder that `generate_split` has written.
        salt_file: the file with the secret of the split.
        extensions: those that the split was generated with.

    Returns:
        The content of the folder's `split.json`.

    Raises:
        ScenarioError: the folder is not a split, or its scenarios differ from the generated scenarios.
        InvalidInputError: the salt is missing or wrong.
    """
    place, salt = as_path(folder, "folder of the split"), _salt(salt_file)
    with extended(extensions):
        return check_folder(place, salt)


def _salt(file: str | Path | None) -> bytes:
    return b"" if file is None else read_salt(as_path(file, "salt's file"))
