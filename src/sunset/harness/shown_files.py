"""What a managing system may not be shown, whatever it names as its own: flights, records, scenarios."""

from collections.abc import Iterable
from pathlib import Path
from typing import Final

from sunset.data import cache_folder
from sunset.errors import ManagerError, ScenarioError
from sunset.recording import PLAN_FILE, RUN_FILE
from sunset.scenarios import load_scenario
from sunset.scenarios.split_files import is_scenario_file

_BAGS: Final = frozenset({".mcap", ".db3", ".bag"})
"""Suffixes of bags, which hold flights with their labels, or the messages of runs."""
_SYSTEM: Final = (Path("/proc"), Path("/sys"))
"""Folders that tell of the computer and its processes: the experiment's command line names scenario and seed."""


def check_shown(manager: str, places: Iterable[Path], files: Iterable[Path]) -> None:
    """Refuse a managing system that would see what its decisions are measured by.

    Args:
        manager: its name.
        places: the files and folders that its process may read, beside what is installed.
        files: those of them that are data, and those in folders that it names.

    Raises:
        ManagerError: one of them holds flights with their labels, the record of a run, or a scenario, or tells of the
            computer's processes; or its name is not UTF-8.
    """
    cache = cache_folder().resolve()
    for place in places:
        real = place.resolve()
        if cache.is_relative_to(real) or real.is_relative_to(cache):
            raise _refusal(manager, place, f"and {cache} is where SUNSET keeps flights and their labels")
        if any(real.is_relative_to(folder) for folder in _SYSTEM):
            raise _refusal(manager, place, "which tells of the computer and its processes")
        if not _is_utf8(str(place)):
            raise ManagerError(
                f"The managing system {manager} needs {place}, whose name is not UTF-8: rename it, or keep the "
                "managing system in another folder."
            )
    for file in files:
        real = file.resolve()
        if real.suffix in _BAGS:
            raise _refusal(manager, file, "which is a bag")
        if real.name in {RUN_FILE, PLAN_FILE}:
            raise _refusal(manager, file, "which is of the record of a run")
        if _is_scenario(real):
            raise _refusal(manager, file, "which is a scenario")


def _refusal(manager: str, place: Path, what: str) -> ManagerError:
    return ManagerError(
        f"The managing system {manager} names {place}, {what}: keep its files in a folder of their own."
    )


def _is_utf8(text: str) -> bool:
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _is_scenario(file: Path) -> bool:
    if not is_scenario_file(file):
        return False
    try:
        load_scenario(file)
    except ScenarioError:
        return False
    return True
