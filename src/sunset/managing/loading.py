"""Loading a managing system by name, from a module, from a file, or as a class or function that is passed."""

import importlib
import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Final, NamedTuple, Self, cast

from sunset.errors import ManagerError
from sunset.files.sources import (
    PACKAGES,
    functions_of,
    import_file,
    import_from,
    import_place,
)
from sunset.managing.base import ManagingSystem
from sunset.managing.baseline import Baseline, NoAdaptation, RandomAdaptation
from sunset.managing.diagnosing import Diagnosing
from sunset.managing.inspecting import Inspecting
from sunset.managing.oracle import ORACLE, Oracle
from sunset.managing.program import PREFIX, Program, parse_command
from sunset.managing.reactive import Reactive
from sunset.managing.symptoms import Symptoms
from sunset.texts.sentences import described_error
from sunset_ros.texts import suggestion

MANAGERS: Final[Mapping[str, type[ManagingSystem]]] = MappingProxyType(
    {
        "none": NoAdaptation,
        "random": RandomAdaptation,
        "baseline": Baseline,
        "reactive": Reactive,
        "diagnosing": Diagnosing,
        "inspecting": Inspecting,
        ORACLE: Oracle,
    }
)
"""The managing systems that come with SUNSET, by name."""

EXTERNAL: Final = "external"
"""The name of a managing system in another process on the graph, which its user starts."""

_LABEL: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,39}")
_KNOWN: Final = frozenset({*PACKAGES, "builtins"})
"""Top-level modules whose classes are not part of a managing system."""


class PassedManager(NamedTuple):
    """A managing system that was passed as a class or function.

    Attributes:
        origin: the class or function, without the arguments of a `functools.partial`.
        manager_class: a class whose instances are the managing system.
        files: the files of the class or function and of its base classes; empty if they do not identify its code.
        arguments: the arguments of a `functools.partial`, as text.
        texts: file → its content when the managing system was passed first.
    """

    origin: Callable[..., ManagingSystem]
    manager_class: type[ManagingSystem]
    files: tuple[Path, ...]
    arguments: tuple[bytes, ...]
    texts: Mapping[Path, bytes]


PASSED: Final[dict[str, PassedManager]] = {}
"""By the names under which this process, and those that it forks, load them."""


def load_manager(spec: str, folder: Path = Path()) -> type[ManagingSystem]:
    """Return the class of a managing system.

    Args:
        spec: a name of `MANAGERS`, or `module:Class`, or `path/to/file.py:Class`, or `exec:COMMAND`.
        folder: the folder in which relative paths begin.

    Raises:
        ManagerError: it does not exist, its module does not load, or it is not a managing system.

    >>> load_manager("baseline").__name__
    'Baseline'
    """
    if spec in MANAGERS:
        return MANAGERS[spec]
    if spec in PASSED:
        return PASSED[spec].manager_class
    _check_printable(spec)
    if spec.startswith(PREFIX):
        command = parse_command(spec, folder)
        return type("Program", (Program,), {"command": command, "__module__": Program.__module__})
    where, _, name = spec.rpartition(":")
    if not where or not name:
        if spec.endswith(".py"):
            raise ManagerError(
                f"The managing system {spec!r} is a file: name its class too, as {spec}:Class."
            )
        raise ManagerError(
            f"There is no managing system {spec!r}: {suggestion(spec, MANAGERS)}name {', '.join(MANAGERS)}, or your "
            "own as module:Class, path/to/file.py:Class or exec:COMMAND."
        )
    module = _load_file(Path(where), folder) if where.endswith(".py") else _load_module(where)
    manager_class = getattr(module, name, None)
    if manager_class is None:
        raise _missing_class_error(where, module, name)
    return _checked_class(spec, manager_class)


def register_manager(manager: Callable[..., ManagingSystem], name: str = "") -> str:
    """Return the name by which this process, and those that it forks, load a class or function.

    Args:
        manager: a class, or a function that takes the keyword arguments of `ManagingSystem` and returns an instance.
        name: the name; if empty, the name of the class or function, with its module.

    Raises:
        ManagerError: it is not a managing system, or its file was edited since it was first passed.
    """
    if isinstance(manager, ManagingSystem) or not callable(manager):
        raise ManagerError(
            "A managing system must be a name, a subclass of ManagingSystem or a function that makes one, got "
            f"an object of type {type(manager).__name__}: pass the class itself, without parentheses."
        )
    origin = manager.func if isinstance(manager, partial) else manager
    name = name or f"{origin.__module__}:{getattr(origin, '__qualname__', type(origin).__name__)}"
    manager_class = _checked_class(
        name, manager if isinstance(manager, type) else _class_of_factory(name, manager)
    )
    texts = {file: file.read_bytes() for file in sorted(set(_files_by_part(origin).values()))}
    known = PASSED.get(name)
    if known is not None and known.origin is origin and known.texts != texts:
        raise ManagerError(
            f"The managing system {name} was edited after it was imported: reload it, or begin a new process."
        )
    values = [manager.args, manager.keywords] if isinstance(manager, partial) else []
    files = tuple(texts) if _is_plain(values) else ()
    arguments = (repr(values).encode(),) if files and any(values) else ()
    PASSED[name] = PassedManager(origin, manager_class, files, arguments, texts)
    return name


def is_registered(name: str) -> bool:
    """Return whether a managing system was passed as a class, so that only this process and its forks have it."""
    return name in PASSED


def _class_of_factory(name: str, make: Callable[..., ManagingSystem]) -> type[ManagingSystem]:
    """Return a class whose instances are the results of a function."""
    try:
        signature = inspect.signature(make)
    except (TypeError, ValueError) as error:
        raise ManagerError(f"{name} cannot make a managing system: {str(error).rstrip('.')}.") from error

    class FromFactory(ManagingSystem):
        __signature__ = signature

        def __new__(cls, **options: object) -> Self:
            manager = make(**options)
            if not isinstance(manager, ManagingSystem):
                raise ManagerError(
                    f"{name} must make a managing system, an instance of a subclass of ManagingSystem, got "
                    f"an object of type {type(manager).__name__}."
                )
            return cast("Self", manager)  # Python does not initialise it again: its class is another

        def adapt(self, symptoms: Symptoms) -> None:
            raise NotImplementedError

    FromFactory.__qualname__ = FromFactory.__name__ = name.rpartition(":")[2]
    return FromFactory


def _files_by_part(origin: type | Callable[..., object]) -> Mapping[type | Callable[..., object], Path]:
    """Return the file of a class or function and of each base class; empty if one of them has no file."""
    bases = origin.__mro__[1:] if isinstance(origin, type) else ()
    parts = [origin, *(base for base in bases if base.__module__.partition(".")[0] not in _KNOWN)]
    files = {part: file for part in parts if (file := _source_file(part)) is not None}
    return files if len(files) == len(parts) else {}


def _source_file(part: type | Callable[..., object]) -> Path | None:
    """Return the file of a class or function; None if a notebook, a console or another function defines it."""
    if "<" in getattr(part, "__qualname__", "<object>"):  # such as make.<locals>.Mine
        return None
    try:
        source = Path(inspect.getsourcefile(part) or "")
    except (OSError, TypeError):
        return None
    places = [Path(function.__code__.co_filename) for function in functions_of(part)]
    # Python takes a class that exec defines for a class of the calling file
    is_own = not places or any(place.is_file() for place in places)
    return source if source.is_file() and is_own else None


def _is_plain(value: object) -> bool:
    """Return whether the text of a value, as `repr` returns it, says everything about it."""
    if type(value) is dict:
        return all(map(_is_plain, value.items()))
    if type(value) in {list, tuple}:
        return all(map(_is_plain, cast("Iterable[object]", value)))
    return value is None or type(value) in {bool, int, float, str, bytes}


def _load_module(name: str) -> ModuleType:
    if not all(part.isidentifier() for part in name.split(".")):
        raise ManagerError(f"{name!r} is not a module name, such as package.module.")
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        missing = error.name or name
        if name == missing or name.startswith(f"{missing}."):
            raise ManagerError(
                f"There is no module {name!r}; a file of your own is named by its path, "
                f"such as {name.replace('.', '/')}.py:Class."
            ) from error
        raise _import_error(name, error) from error
    except BaseException as error:
        raise _import_error(name, error) from error


def _load_file(path: Path, folder: Path) -> ModuleType:
    """Import a file under a name that depends on its path only; it can import modules beside it, as a script can."""
    if not (folder / path).is_file():
        raise ManagerError(f"There is no file {path}.")
    resolved = (folder / path).resolve()
    name = "sunset_manager_" + "".join(c if c.isalnum() else "_" for c in str(resolved.with_suffix("")))
    import_from(resolved.parent)
    try:
        return import_file(resolved, name)
    except BaseException as error:
        raise _import_error(str(path), error) from error


def _import_error(where: str, error: BaseException) -> ManagerError:
    place = import_place(error)
    if isinstance(error, SyntaxError) and not place:
        line = f", line {error.lineno}" if error.lineno else ""
        return ManagerError(f"{where}{line}: this is not valid Python: {error.msg}.")
    if isinstance(error, ValueError) and not place:  # some versions of Python raise it for null bytes
        return ManagerError(f"{where}: this is not valid Python: {error}.")
    return ManagerError(f"Importing {where} raised {described_error(error)}{place}.")


def _missing_class_error(where: str, module: ModuleType, name: str) -> ManagerError:
    classes = [
        other
        for other, value in vars(module).items()
        if isinstance(value, type) and issubclass(value, ManagingSystem) and value is not ManagingSystem
    ]
    hint = f": name {classes[0]}" if classes else ""
    if classes[1:]:
        hint = f": {suggestion(name, classes)}name one of {', '.join(classes)}"
    return ManagerError(f"There is no class {name} in {where}{hint}.")


def _checked_class(spec: str, manager_class: object) -> type[ManagingSystem]:
    """Return the class if an experiment can make instances and call `adapt`."""
    if not (isinstance(manager_class, type) and issubclass(manager_class, ManagingSystem)):
        raise ManagerError(f"{spec} is not a managing system: it must be a subclass of ManagingSystem.")
    if inspect.isabstract(manager_class) or manager_class.adapt is ManagingSystem.adapt:
        raise ManagerError(f"{spec} has no method adapt(self, symptoms).")
    if inspect.isgeneratorfunction(manager_class.adapt) or inspect.isasyncgenfunction(manager_class.adapt):
        raise ManagerError(
            f"The method adapt of {spec} contains yield, so that a call of it does nothing: call the adaptations, or "
            "write 'async def adapt' and await them."
        )
    try:
        inspect.signature(manager_class).bind(context=None, cli_args=None, parameter_overrides=None)
    except TypeError as error:
        raise ManagerError(
            f"{spec} cannot be made: __init__ must accept context, cli_args and parameter_overrides "
            f"as keyword arguments ({error}); to prepare something, override on_start instead."
        ) from error
    try:
        inspect.signature(manager_class.adapt).bind(None, None)
    except TypeError as error:
        raise ManagerError(
            f"The method adapt of {spec} must accept one argument, symptoms: 'def adapt(self, symptoms)'."
        ) from error
    return manager_class


def _check_printable(spec: str) -> None:
    """Refuse a name that a record cannot hold."""
    if not spec.isprintable():
        raise ManagerError(f"The managing system {spec!r} contains an unprintable character.")


def split_label(text: str) -> tuple[str, str]:
    """Return the label and the managing system of `LABEL=MANAGER`; the label is empty if there is none.

    A path or a module before the first `=` is not a label: `a=b/mine.py:Mine` is a file in the folder `a=b`.

    Raises:
        ManagerError: the label is malformed or reserved, or the text contains an unprintable character.

    >>> split_label("mine-2=mine.py:Mine"), split_label("baseline")
    (('mine-2', 'mine.py:Mine'), ('', 'baseline'))
    """
    label, separator, manager = text.partition("=")
    if not separator or "/" in label or ":" in label:
        _check_printable(text)
        return "", text
    if not _LABEL.fullmatch(label):
        raise ManagerError(
            f"The label of the managing system {text!r} must be 1 to 40 of the letters a to z and A to Z, digits, "
            f"'_', '.', '+' and '-', and begin with a letter or digit, got {label!r}."
        )
    if label in {*MANAGERS, EXTERNAL}:
        raise ManagerError(
            f"The label {label!r} is the name of a managing system that comes with SUNSET; choose another for "
            f"{manager}."
        )
    _check_printable(manager)
    return label, manager
