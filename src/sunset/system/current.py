"""The managed system of this process: the paper's, and what extensions add to it."""

import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Final

from sunset.errors import ExtensionError
from sunset.input_files import file_digest
from sunset.source_files import compiled_checksum, import_file, import_place, is_edited
from sunset.system.checks import check_added_signals
from sunset.system.class_checks import check_fault_parameter, check_parameter, check_subclass
from sunset.system.description import Fault
from sunset.system.extension import Extension
from sunset.system.paper import PAPER
from sunset.system.suites import Suite, names_in_suite
from sunset.system.system import System
from sunset.texts import described_error, suggestion

_GROUP: Final = "sunset.extensions"
"""The group of entry points of installed extensions."""
_ATTRIBUTE: Final = "EXTENSION"
"""What a file calls the extension that it adds."""


@dataclass(frozen=True, slots=True)
class LoadedExtension:
    """An extension that is part of a process's system.

    Attributes:
        name: the file's name, or that of the entry point.
        where: the file's absolute path, or the name of the entry point.
        checksum: the SHA-256 of the file that it is written in, in hexadecimal.
        source: that file's path.
    """

    name: str
    where: str
    checksum: str
    source: str


@dataclass(eq=False)
class _State:
    """What this process, or one of its threads, describes, runs and scores.

    Attributes:
        system: the managed system.
        loaded: its extensions, in the order in which they were loaded.
        added: what they add, by their names.
        loading: those that are being loaded.
    """

    system: System = field(default_factory=lambda: System(PAPER))
    loaded: tuple[LoadedExtension, ...] = ()
    added: Mapping[str, Extension] = field(default_factory=dict)
    loading: set[str] = field(default_factory=set)


_process: Final = _State()
_own: Final[ContextVar[_State]] = ContextVar("_own")
"""That of a thread in an `extended_system`."""
_entered: Final[list[_State]] = []
"""Those of all threads; a thread that has not entered one takes the last."""


def _current() -> _State:
    return _own.get([_process, *_entered][-1])


def current_system() -> System:
    """Return the managed system that this process, or this thread, describes, runs and scores."""
    return _current().system


def loaded_extensions() -> tuple[LoadedExtension, ...]:
    """Return the extensions that are part of it, in the order in which they were loaded."""
    return _current().loaded


@cache
def unlisted() -> Extension:
    """Return the faults that no catalogue lists, and their suite; nothing where walls keep this process from them."""
    try:
        part: Extension = import_module("sunset.wild.causes").UNLISTED
    except OSError:
        return Extension()
    return part


def unlisted_names(*, sealed: bool) -> tuple[str, ...]:
    """Return the names of the faults that no catalogue lists; those that no suite has only if `sealed`."""
    kept: tuple[str, ...] = import_module("sunset.wild.causes").SEALED
    return tuple(fault.name for fault in unlisted().faults if sealed or fault.name not in kept)


def find_fault(name: str) -> Fault | None:
    """Return the fault of that name, which the catalogue may not list; None if there is none."""
    known = current_system().faults.get(name)
    return known or next((fault for fault in unlisted().faults if fault.name == name), None)


def all_suites() -> Mapping[str, Suite]:
    """Return the suites of the system, and that of the faults that no catalogue lists."""
    own = current_system().suites
    return {**own, **unlisted().suites, **own}  # an extension may have a suite of that name


def excluding_pairs() -> tuple[tuple[str, str], ...]:
    """Return the pairs of faults that cannot be there at the same time, listed or not."""
    return (*current_system().exclusive, *unlisted().exclusive)


@contextmanager
def system_with(faults: Iterable[str]) -> Iterator[None]:
    """Let nodes be made that can have these faults, where some are not listed, for as long as the context lasts.

    Managing systems must be started outside of it.

    Raises:
        ExtensionError: an extension has a class of its own for a node of the system.
    """
    outer = _current()
    if all(name in outer.system.faults for name in faults):
        yield
        return
    part = replace(unlisted(), node_classes=import_module("sunset.wild.nodes").NODE_CLASSES)
    for name, extension in outer.added.items():
        if taken := sorted(part.node_classes.keys() & extension.node_classes):
            raise ExtensionError(
                f"The extension {name} has a class for the node {taken[0]}, which a run with an unlisted fault has, "
                "too: leave the extension out, or take another scenario."
            )
    with _entered_state(_State(System(*outer.system.parts, part), outer.loaded, outer.added)):
        yield


def get_fault(name: str) -> Fault:
    """Return the fault of that name, which the catalogue may not list.

    Raises:
        ScenarioError: there is none; the message lists those that there are.

    >>> get_fault("gpu_failure").redeploy_only
    True
    """
    return find_fault(name) or current_system().fault(name)


def degradations_of(names: Iterable[str]) -> str:
    """Return the degradations by which runs with these faults are clustered.

    What a segmentation is worth depends on its degradations. Outages differ in how long they last, and are taken as
    they are: no interval speaks of others than those that were run. Without degradations, it is the failures.
    """
    system = current_system()
    found = {name: find_fault(name) for name in names}
    failures = {name: fault.failure if fault else "" for name, fault in found.items()}
    degradations = [name for name, failure in failures.items() if failure not in system.outages]
    return "+".join(sorted(degradations or set(failures.values())))


def suite_size(suite: str, scenario: str) -> int:
    """Return how many scenarios the suite of a scenario has; 0 if the system lacks such a suite."""
    names = names_in_suite(suite, all_suites().get(suite, ()))
    return len(names) if scenario in names else 0


def load_extension(where: str | Path, *, checksum: str = "") -> None:
    """Add an extension to the managed system of this process or context, unless it is loaded already.

    Args:
        where: a Python file, which has its `Extension` as EXTENSION; or the name of an entry point of the group
            `sunset.extensions`.
        checksum: what that of its file must be; any if empty.

    Raises:
        ExtensionError: it cannot be imported, has no extension, does not fit the system, or has another checksum; or it
            is loaded already, and was edited since.
    """
    state = _own.get(_process)
    is_file = str(where).endswith(".py") or Path(where).is_file()
    place = str(Path(where).resolve()) if is_file else str(where)
    loaded = next((one for one in state.loaded if one.where == place), None)
    added = None
    if loaded is None:
        if place in state.loading:
            raise ExtensionError(f"The extension {where} loads itself.")
        state.loading.add(place)
        try:
            module, added = _from_file(Path(place)) if is_file else _from_entry_point(place)
        finally:
            state.loading.remove(place)
        source = Path(str(module.__file__))
        digest = compiled_checksum(source) or file_digest(source)
        loaded = LoadedExtension(Path(place).name, place, digest, str(source))
        if loaded.name in {one.name for one in state.loaded}:
            raise ExtensionError(f"The name of the extension {loaded.name} is taken: rename {where}.")
    elif is_file and not checksum and is_edited(Path(place)):
        raise ExtensionError(
            f"The extension {where} was edited after it was loaded: load it in a new process."
        )
    if checksum not in {"", loaded.checksum}:
        raise ExtensionError(
            f"The extension {where} has changed since the run was planned; run it in a new folder."
        )
    if added is not None:
        extensions = {**state.added, loaded.name: added}
        state.system = _extended(where, added, extensions)
        state.loaded, state.added = (*state.loaded, loaded), extensions


@contextmanager
def extended_system(wheres: Iterable[str | Path]) -> Iterator[System]:
    """Load extensions for as long as the context lasts, and give the system with them; other threads keep their own.

    Raises:
        ExtensionError: as `load_extension`.
    """
    outer = _own.get(_process)
    with _entered_state(_State(outer.system, outer.loaded, outer.added)) as state:
        for where in wheres:
            load_extension(where)
        yield state.system


@contextmanager
def _entered_state(state: _State) -> Iterator[_State]:
    """Let a state be that of this thread for as long as the context lasts."""
    token = _own.set(state)
    _entered.append(state)
    try:
        yield state
    finally:
        _entered.remove(state)
        _own.reset(token)


def _extended(where: str | Path, extension: Extension, extensions: Mapping[str, Extension]) -> System:
    """Return the system with all extensions by their names, whose order is that of the names, whichever came first."""
    try:
        check_added_signals(extension.signals)
        system = System(PAPER, *(extensions[name] for name in sorted(extensions)))
        for name, node_class in extension.node_classes.items():
            check_subclass(name, node_class, current_system().node_class(name))
        for node in extension.nodes:
            system.node_class(node.name)
        for fault in extension.faults:
            for function in (fault.effect.degrade, fault.effect.restore) if fault.effect else ():
                if function is not None:
                    system.image_function(function)
        for adaptation in extension.named_adaptations:
            check_parameter(adaptation, system.node_class(adaptation.node))
        for fault in extension.faults:
            check_fault_parameter(fault, system.node_class(fault.node))
        for name, suite in extension.suites.items():
            names_in_suite(name, suite)
    except ExtensionError as error:
        raise ExtensionError(f"The extension {where} does not fit the system: {error}") from error
    return system


def _from_file(path: Path) -> tuple[ModuleType, Extension]:
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
    return module, _checked(path, names[_ATTRIBUTE])


@contextmanager
def _translated(where: object) -> Iterator[None]:
    """Turn what an extension raises when it is imported into one `ExtensionError`; what it prints goes to stderr."""
    with redirect_stdout(sys.stderr):
        try:
            yield
        except KeyboardInterrupt:
            raise
        except BaseException as error:
            raise ExtensionError(
                f"The extension {where} cannot be imported: it raised {described_error(error)}{import_place(error)}."
            ) from error


def _from_entry_point(name: str) -> tuple[ModuleType, Extension]:
    from importlib.metadata import entry_points  # noqa: PLC0415  slow, and rarely needed

    installed = {point.name: point for point in entry_points(group=_GROUP)}
    if name not in installed:
        raise ExtensionError(
            f"There is no extension {name!r}: {suggestion(name, installed)}name a Python file, or one that is "
            f"installed ({', '.join(installed) or 'none is'})."
        )
    with _translated(name):
        extension = installed[name].load()
    return sys.modules[installed[name].module], _checked(name, extension)


def _checked(where: object, found: object) -> Extension:
    if not isinstance(found, Extension):
        raise ExtensionError(
            f"The extension {where} must have an Extension as {_ATTRIBUTE}, got {type(found).__name__}."
        )
    return found
