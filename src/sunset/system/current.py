"""The managed system in use: the paper's, and the parts that extensions add.

A context variable holds it. Its default is the process's system, so threads share that, unless they are in an
`extended_system`. A thread or process that is started in an `extended_system` does not inherit it.
"""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Final

from sunset.errors import ExtensionError, ScenarioError
from sunset.files.inputs import file_digest
from sunset.system.checks import check_extension, check_system
from sunset.system.description import Fault
from sunset.system.extension import Extension, Suite, names_in_suite
from sunset.system.loading import LoadedExtension, import_extension
from sunset.system.paper import PAPER
from sunset.system.system import System
from sunset_ros.texts import suggestion

_UNLISTED: Final = "sunset.nodes.wild"
"""The package of the faults that no catalogue lists; managing systems cannot read it."""


@dataclass(eq=False)
class _Use:
    """A managed system and its extensions, in the order in which they were loaded."""

    system: System = field(default_factory=lambda: System(PAPER))
    extensions: Mapping[LoadedExtension, Extension] = field(default_factory=dict)


_use: Final[ContextVar[_Use]] = ContextVar("_use", default=_Use())  # noqa: B039  of the process, which may extend it


def current_system() -> System:
    """Return the managed system of this process, or of the `extended_system` that this thread is in."""
    return _use.get().system


def loaded_extensions() -> tuple[LoadedExtension, ...]:
    """Return its extensions, in the order in which they were loaded."""
    return tuple(_use.get().extensions)


def load_extension(where: str | Path, *, checksum: str = "") -> None:
    """Add an extension to the current managed system, unless it is loaded already.

    Args:
        where: a Python file, whose variable EXTENSION is the `Extension`; or the name of an entry point of the group
            `sunset.extensions`.
        checksum: the expected checksum of its file; any if empty.

    Raises:
        ExtensionError: it cannot be imported, does not fit the system, or has another checksum; or it was edited since
            it was loaded.
    """
    is_file = str(where).endswith(".py") or Path(where).is_file()
    place = str(Path(where).resolve()) if is_file else str(where)
    known = next((loaded for loaded in loaded_extensions() if loaded.where == place), None)
    if known and is_file and not checksum and file_digest(Path(place)) != known.checksum:
        raise ExtensionError(
            f"The extension {where} was edited after it was loaded: load it in a new process."
        )
    loaded, part = (known, None) if known else import_extension(place, is_file=is_file)
    if checksum not in {"", loaded.checksum}:
        raise ExtensionError(
            f"The extension {where} has changed since the run was planned; run it in a new folder."
        )
    if part is not None:
        _add(loaded, part, where)


def _add(loaded: LoadedExtension, part: Extension, where: str | Path) -> None:
    """Add a part to the current system, whose parts are in the order of their names, not of loading."""
    use = _use.get()
    if loaded.name in {other.name for other in use.extensions}:
        raise ExtensionError(f"The name of the extension {loaded.name} is taken: rename {where}.")
    extensions = {**use.extensions, loaded: part}
    system = System(PAPER, *(extensions[key] for key in sorted(extensions, key=lambda key: key.name)))
    try:
        check_system(system)
        check_extension(part, system, use.system)
    except ExtensionError as error:
        raise ExtensionError(f"The extension {where} does not fit the system: {error}") from error
    use.system, use.extensions = system, extensions


@contextmanager
def extended_system(wheres: Iterable[str | Path]) -> Iterator[System]:
    """Load extensions for as long as the context lasts, in this thread only, and give the system with them."""
    use = _use.get()
    with using_system(use.system, use.extensions):
        for where in wheres:
            load_extension(where)
        yield current_system()


@contextmanager
def using_system(system: System, extensions: Mapping[LoadedExtension, Extension]) -> Iterator[None]:
    """Let a system with these extensions be the current system for as long as the context lasts, in this thread."""
    token = _use.set(_Use(system, extensions))
    try:
        yield
    finally:
        _use.reset(token)


@cache
def unlisted() -> Extension:
    """Return the faults that no catalogue lists, and their suite; nothing in a process that walls keep from them."""
    try:
        part: Extension = import_module(f"{_UNLISTED}.causes").UNLISTED
    except OSError:
        return Extension()
    return part


def unlisted_names(*, sealed: bool) -> tuple[str, ...]:
    """Return the names of the faults that no catalogue lists; those without a suite only if `sealed`."""
    kept: tuple[str, ...] = import_module(f"{_UNLISTED}.causes").SEALED
    return tuple(fault.name for fault in unlisted().faults if sealed or fault.name not in kept)


@contextmanager
def system_with(faults: Iterable[str]) -> Iterator[None]:
    """Add the unlisted faults to the system within the context, if one of these faults is unlisted.

    Managing systems must be started outside of it.

    Raises:
        ExtensionError: an extension replaces a node that these faults replace, too.
    """
    use = _use.get()
    if all(name in use.system.faults for name in faults):
        yield
        return
    part = replace(unlisted(), node_classes=import_module(f"{_UNLISTED}.nodes").NODE_CLASSES)
    for loaded, extension in use.extensions.items():
        if taken := sorted(part.node_classes.keys() & extension.node_classes):
            raise ExtensionError(
                f"The extension {loaded.name} has a class for the node {taken[0]}, which a run with an unlisted fault "
                "has, too: leave the extension out, or take another scenario."
            )
    with using_system(System(*use.system.parts, part), use.extensions):
        yield


def find_fault(name: str) -> Fault | None:
    """Return a fault by name, listed or not; None if it is unknown."""
    known = current_system().faults.get(name)
    return known or next((fault for fault in unlisted().faults if fault.name == name), None)


def get_fault(name: str) -> Fault:
    """Return a fault by name, listed or not.

    >>> get_fault("gpu_failure").redeploy_only
    True
    """
    if fault := find_fault(name):
        return fault
    known = current_system().faults
    raise ScenarioError(
        f"There is no fault {name!r}: {suggestion(name, known)}choose one of {', '.join(known)}."
    )


def all_suites() -> Mapping[str, Suite]:
    """Return the suites of the system, and the suite of the faults that no catalogue lists."""
    own = current_system().suites
    return {**own, **unlisted().suites, **own}  # an extension may have a suite of that name


def excluding_pairs() -> tuple[tuple[str, str], ...]:
    """Return the pairs of faults that cannot be there at the same time, listed or not."""
    return (*current_system().exclusive, *unlisted().exclusive)


def degradations_of(names: Iterable[str]) -> str:
    """Return the degradations by which runs with these faults are clustered.

    The value of a segmentation depends on its degradations. Outages differ in their duration only, so no interval
    generalizes beyond the outages that were run. Without degradations, it is the failures.
    """
    system = current_system()
    faults = {name: find_fault(name) for name in names}
    failures = {name: fault.failure if fault else "" for name, fault in faults.items()}
    degradations = [name for name, failure in failures.items() if failure not in system.outages]
    return "+".join(sorted(degradations or set(failures.values())))


def suite_size(suite: str, scenario: str) -> int:
    """Return the number of scenarios in the suite of a scenario; 0 if the system lacks the suite."""
    names = names_in_suite(suite, all_suites().get(suite, ()))
    return len(names) if scenario in names else 0
