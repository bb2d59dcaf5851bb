"""The managed system in use: the paper's, the parts that extensions add, and whether a cure is in place.

A context variable holds it. Its default is the process's system, so threads share that, unless they are in an
`extended_system`. A thread or process that is started in an `extended_system` does not inherit it.
"""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, redirect_stdout
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Final

from sunset.errors import ExtensionError, ScenarioError
from sunset.files.inputs import file_digest
from sunset.files.sources import compiled_checksum, import_file, import_place
from sunset.system.checks import check_extension, check_system
from sunset.system.description import Adaptation, Fault
from sunset.system.names import full_name
from sunset.system.paper import PAPER
from sunset.system.system import Extension, Suite, System
from sunset.texts.names import ros_text
from sunset.texts.sentences import described_error
from sunset_ros.texts import suggestion

STATE: Final = ""
"""The lifecycle state of a node, in place of a parameter's name."""

Key = tuple[str, str]
"""A node, without namespace, and one of its parameters, or `STATE`."""

_GROUP: Final = "sunset.extensions"
"""The group of entry points of installed extensions."""
_ATTRIBUTE: Final = "EXTENSION"
"""The variable of a file that holds its extension."""
_UNLISTED: Final = "sunset.wild"
"""The package of the faults that no catalogue lists; managing systems cannot read it."""


@dataclass(frozen=True, slots=True)
class LoadedExtension:
    """An extension that is part of the managed system.

    Attributes:
        name: the file's name, or the entry point's.
        where: the file's absolute path, or the name of the entry point.
        checksum: the SHA-256 of the file with its source, in hexadecimal.
        source: the path of that file.
    """

    name: str
    where: str
    checksum: str
    source: str


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
    loaded, part = (known, None) if known else _imported(place, is_file=is_file)
    if checksum not in {"", loaded.checksum}:
        raise ExtensionError(
            f"The extension {where} has changed since the run was planned; run it in a new folder."
        )
    if part is not None:
        _add(loaded, part, where)


def _imported(place: str, *, is_file: bool) -> tuple[LoadedExtension, Extension]:
    """Import an extension from a Python file, or from the entry point of a name."""
    module, extension = _from_file(Path(place)) if is_file else _from_entry_point(place)
    if not isinstance(extension, Extension):
        raise ExtensionError(
            f"The extension {place} must have an Extension as {_ATTRIBUTE}, got {type(extension).__name__}."
        )
    source = Path(str(module.__file__))
    checksum = compiled_checksum(source) or file_digest(source)
    return LoadedExtension(Path(place).name, place, checksum, str(source)), extension


def _from_file(path: Path) -> tuple[ModuleType, object]:
    if not path.is_file():
        raise ExtensionError(f"There is no extension {path}: name a Python file.")
    if path.suffix != ".py":
        raise ExtensionError(f"The extension {path} is not a Python file.")
    with _translated(path):
        module = import_file(path, f"sunset_extension_{path.stem}")
    names = vars(module)
    if _ATTRIBUTE not in names:
        others = [name for name, value in names.items() if isinstance(value, Extension)]
        remedy = f"rename {others[0]}" if others else "assign it an Extension"
        raise ExtensionError(f"The extension {path} has no {_ATTRIBUTE}: {remedy}.")
    return module, names[_ATTRIBUTE]


def _from_entry_point(name: str) -> tuple[ModuleType, object]:
    from importlib.metadata import entry_points  # noqa: PLC0415  slow, and rarely needed

    installed = {point.name: point for point in entry_points(group=_GROUP)}
    if name not in installed:
        raise ExtensionError(
            f"There is no extension {name!r}: {suggestion(name, installed)}name a Python file, or an installed "
            f"extension ({', '.join(installed) or 'there is none'})."
        )
    with _translated(name):
        extension = installed[name].load()
    return sys.modules[installed[name].module], extension


@contextmanager
def _translated(where: object) -> Iterator[None]:
    """Turn an exception of an extension's import into an `ExtensionError`, and print its output to stderr."""
    with redirect_stdout(sys.stderr):
        try:
            yield
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise ExtensionError(
                f"The extension {where} cannot be imported: it raised {described_error(error)}{import_place(error)}."
            ) from error


def _add(loaded: LoadedExtension, part: Extension, where: str | Path) -> None:
    """Add a part to the current system, whose parts are in the order of their names, not of loading."""
    use = _use.get()
    if loaded.name in {other.name for other in use.extensions}:
        raise ExtensionError(f"The name of the extension {loaded.name} is taken: rename {where}.")
    extensions = {**use.extensions, loaded: part}
    try:
        system = System(PAPER, *(extensions[key] for key in sorted(extensions, key=lambda key: key.name)))
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


def comparable_text(key: Key, value: object) -> str:
    """Return a parameter's value, or a state, for comparison: as ROS writes it, topics by their full names."""
    text = ros_text(value)
    return full_name(text) if key in current_system().topic_parameters else text


def goal_of(step: Adaptation) -> tuple[Key, str] | None:
    """Return the parameter or state that a step of a cure sets, and its value; None for restarts and redeploys."""
    if step.parameter:
        key = step.node, step.parameter
        return key, comparable_text(key, step.value)
    state = step.kind.goal_state
    return None if state is None else ((step.node, STATE), state)


def is_in_place(fault: Fault, cure: Sequence[Adaptation], setting: Callable[[Key], str | None]) -> bool:
    """Return whether a cure of a fault is in place: all of its steps are done, and undo enough of the fault.

    Args:
        fault: a fault.
        cure: one of its cures; a cure with a restart or redeploy is never in place.
        setting: returns the current value, as `comparable_text` writes it; None if it is unknown.
    """
    goals = [goal_of(step) for step in cure]
    amounts = [setting((step.node, fault.parameter)) for step in cure]
    return all(goal is not None and setting(goal[0]) == goal[1] for goal in goals) and fault.is_undone(
        setting((fault.node, fault.parameter)), amounts
    )
