"""Finding a managing system by name, in a module, or in a file of one's own."""

import hashlib
import importlib
import inspect
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import FunctionType, ModuleType
from typing import Final, Self, cast

from sunset.errors import ManagerError
from sunset.managing.base import ManagingSystem
from sunset.managing.command import PREFIX
from sunset.managing.names import MANAGERS, check_printable
from sunset.managing.program import Program, load_program
from sunset.managing.symptoms import Symptoms
from sunset.source_files import class_texts, functions_of, import_file, import_from, import_place, is_edited
from sunset.texts import described_error, suggestion

_OURS: Final = frozenset({"sunset", "__main__", "__mp_main__"})
"""Top-level modules that are not part of a managing system, wherever they are."""

_KNOWN: Final = frozenset({"sunset", "builtins"})
"""Top-level modules whose classes every managing system may inherit from."""

_registered: dict[str, type[ManagingSystem]] = {}
"""Those that were passed as classes, by the names that they are loaded by in this process and in those it forks."""
_passed: dict[str, Callable[..., ManagingSystem]] = {}
"""What was passed: the class, or the function that makes one."""
_first: dict[str, tuple[object, str]] = {}
"""The class or function in that, and the checksum of its files when it was passed first."""

_folders: set[Path] = set()
"""Where files were loaded from."""


def load_manager(spec: str, folder: Path = Path()) -> type[ManagingSystem]:
    """Return the class of a managing system.

    Args:
        spec: a name of `MANAGERS`, or `module:Class`, or `path/to/file.py:Class`, or `exec:COMMAND`.
        folder: where a path begins that is not absolute.

    Raises:
        ManagerError: there is none of that name, or its module does not load, or it is not a managing system.

    >>> load_manager("baseline").__name__
    'Baseline'
    """
    if known := MANAGERS.get(spec) or _registered.get(spec):
        return known
    check_printable(spec)
    if spec.startswith(PREFIX):
        return load_program(spec, folder)
    where, separator, name = spec.rpartition(":")
    if not separator or not where or not name:
        if spec.endswith(".py"):
            raise ManagerError(
                f"The managing system {spec!r} is a file: name its class too, as {spec}:Class."
            )
        raise ManagerError(
            f"There is no managing system {spec!r}: {suggestion(spec, MANAGERS)}name {', '.join(MANAGERS)}, or your "
            "own as module:Class, path/to/file.py:Class or exec:COMMAND."
        )
    module = _load_file(Path(where), folder) if where.endswith(".py") else _load_module(where)
    with _translated(spec):
        return _checked(spec, where, module, name)


def register_manager(manager: Callable[..., ManagingSystem], name: str = "") -> str:
    """Return the name by which this process, and those that it forks, load a managing system of their own.

    Args:
        manager: a class, or a function that makes one: it gets the keyword arguments of `ManagingSystem`.
        name: the name; if empty, that of the class or function, with its module.

    Raises:
        ManagerError: it is neither, or not a managing system; or its file was edited after it was imported.
    """
    if isinstance(manager, ManagingSystem) or not callable(manager):
        raise ManagerError(
            "A managing system must be a name, a subclass of ManagingSystem or a function that makes one, got "
            f"an object of type {type(manager).__name__}: pass the class itself, without parentheses."
        )
    origin = _origin(manager)
    name = name or f"{origin.__module__}:{getattr(origin, '__qualname__', type(origin).__name__)}"
    made = manager if isinstance(manager, type) else _class_of_factory(name, manager)
    _registered[name], _passed[name] = _checked_class(name, made), manager
    digest = sources_digest(source.read_bytes() for source in manager_sources(name, made))
    if _first.get(name, (None,))[0] is not origin:
        _first[name] = origin, digest
    if _first[name][1] != digest:
        raise _edited_error(name)
    return name


def is_registered(name: str) -> bool:
    """Return whether a managing system was passed as a class, so that only this process and its forks have it."""
    return name in _registered


def _class_of_factory(name: str, make: Callable[..., ManagingSystem]) -> type[ManagingSystem]:
    """Return a class of which every instance is what a function makes.

    Raises:
        ManagerError: it cannot be called with what it was given.
    """
    try:
        signature = inspect.signature(make)
    except (TypeError, ValueError) as error:
        raise ManagerError(f"{name} cannot make a managing system: {str(error).rstrip('.')}.") from error

    class Made(ManagingSystem):
        __signature__ = signature

        def __new__(cls, **options: object) -> Self:
            manager = make(**options)
            if not isinstance(manager, ManagingSystem):
                raise ManagerError(
                    f"{name} must make a managing system, an instance of a subclass of ManagingSystem, got "
                    f"an object of type {type(manager).__name__}."
                )
            return cast("Self", manager)  # Python does not initialise it again, since it is of another class

        def adapt(self, symptoms: Symptoms) -> None:
            raise NotImplementedError

    Made.__qualname__ = Made.__name__ = name.rpartition(":")[2]
    return Made


@contextmanager
def _translated(spec: str) -> Iterator[None]:
    """Turn what a managing system's own module or class raises when it is looked at into one `ManagerError`."""
    try:
        yield
    except ManagerError:
        raise
    except BaseException as error:
        raise ManagerError(
            f"The managing system {spec} cannot be looked at: it raised {described_error(error)}."
        ) from error


def _origin(manager: Callable[..., ManagingSystem]) -> Callable[..., ManagingSystem]:
    """Return what a managing system that was passed is made by, without the arguments that it has already."""
    return manager.func if isinstance(manager, partial) else manager


def _lineage(origin: Callable[..., ManagingSystem]) -> list[Callable[..., ManagingSystem]]:
    """Return what a managing system inherits from, that is not SUNSET's or Python's own, behind itself."""
    bases = origin.__mro__[1:] if isinstance(origin, type) else ()
    return [origin, *(base for base in bases if base.__module__.partition(".")[0] not in _KNOWN)]


def manager_sources(
    spec: str,
    made: type[ManagingSystem],
    folder: Path = Path(),
) -> tuple[Path, ...]:
    """Return the files in which a managing system is written: its own, with what it imports beside it, or its package.

    Of one that was passed as a class, those of the classes that it inherits from, too. `spec` is its name, `made` what
    `load_manager` returned for it and for the folder.

    Raises:
        ManagerError: it cannot be looked at, or one of them was edited after it was imported.
    """
    if issubclass(made, Program):
        return made.command.files
    with _translated(spec):
        passed = spec in _passed
        lineage = _lineage(_origin(_passed[spec]) if passed else made)
        written = [(origin, _source_file(origin)) for origin in lineage]
        sources = set(_sources(spec, written[0][1], folder))
        sources.update(Path(source) for _, source in written if source and passed)
        parts = [
            *((source, None) for source in sources),
            *((Path(source), origin) for origin, source in written if source),
        ]
        if any(is_edited(source, origin) for source, origin in parts if source in sources):
            raise _edited_error(spec)
        return tuple(sorted(sources))


def _edited_error(spec: str) -> ManagerError:
    return ManagerError(
        f"The managing system {spec} was edited after it was imported: reload it, or begin a new process."
    )


def _source_file(origin: Callable[..., ManagingSystem]) -> str | None:
    """Return the file that defines something; None where that is a notebook's cell or a console."""
    try:
        source = inspect.getsourcefile(origin)
    except (OSError, TypeError):
        return None
    if source is None or not Path(source).is_file():
        return None
    places = [Path(function.__code__.co_filename) for function in functions_of(origin)]
    # Python says of a class that was passed to exec that it is of its caller's file
    return source if not places or any(place.is_file() for place in places) else None


def _sources(spec: str, source: str | None, folder: Path) -> tuple[Path, ...]:
    where = spec.rpartition(":")[0]
    if source is None and where.endswith(".py"):
        source = str((folder / where).resolve())  # its class may claim to be of any module
    if source is None:
        return ()
    package = where.partition(".")[0]
    files = {Path(source)}
    if where.endswith(".py"):
        loaded = [vars(sys.modules[name]).get("__file__") for name in _beside(Path(source).parent)]
        files.update(Path(file) for file in loaded if file is not None)
    elif package not in {"", *_OURS}:  # all of it: what is loaded depends on what was run before
        folders = vars(sys.modules[package]).get("__path__", ())
        files.update(file for folder in folders for file in Path(folder).rglob("*.py"))
    return tuple(sorted(files))


def checksum(spec: str, sources: Iterable[Path]) -> str:
    """Return the SHA-256 of what stands in a managing system's files now, in hexadecimal.

    Of one that was passed as a class, the source of classes that have no file, as in a notebook, is part of it, and so
    are the arguments of a `functools.partial`. It is an empty text where these do not say what is run.
    """
    return contents_checksum(sources, unfiled_sources(spec))


def contents_checksum(sources: Iterable[Path], others: Iterable[bytes] | None) -> str:
    """Return what `checksum` returns of a managing system of these files, and of what `unfiled_sources` returned."""
    return "" if others is None else sources_digest([*(source.read_bytes() for source in sources), *others])


def unfiled_sources(spec: str) -> list[bytes] | None:
    """Return what `checksum` is made of besides files; None where it does not say what is run."""
    return _passed_texts(_passed[spec]) if spec in _passed else []


def sources_digest(texts: Iterable[bytes]) -> str:
    """Return the SHA-256 that `checksum` returns of these contents, in their order; empty if there is none."""
    digests = b"".join(hashlib.sha256(text).digest() for text in texts)
    return hashlib.sha256(digests).hexdigest() if digests else ""


def _passed_texts(manager: Callable[..., ManagingSystem]) -> list[bytes] | None:
    """Return what says, besides files, what runs of a managing system that was passed; None if it cannot be said.

    So it is with a closure, and with what is made in a function: their values stand nowhere.
    """
    origin, values, texts = _origin(manager), list[object](), list[bytes]()
    if isinstance(manager, partial):
        values += [manager.args, manager.keywords]
    if isinstance(origin, FunctionType):
        values += [origin.__defaults__, origin.__kwdefaults__]
        told = not origin.__closure__ and origin.__name__ != "<lambda>" and _source_file(origin) is not None
    else:
        lineage = _lineage(origin)
        told = all(isinstance(kind, type) and "<locals>" not in kind.__qualname__ for kind in lineage)
        try:
            texts += [text for kind in lineage if not _source_file(kind) for text in class_texts(kind)]
        except (OSError, SyntaxError):
            told = False
    if not told or not _is_plain(values):
        return None
    return [*texts, repr(values).encode()] if any(values) else texts


def _is_plain(value: object) -> bool:
    """Return whether what Python prints of a value is all that there is to it."""
    if type(value) is dict:
        return all(map(_is_plain, value.items()))
    if type(value) in {list, tuple}:
        return all(map(_is_plain, cast("Iterable[object]", value)))
    return value is None or type(value) in {bool, int, float, str, bytes}


def _beside(folder: Path) -> list[str]:
    """Return the names of the loaded modules that a folder holds, and of those in them."""
    found = set()
    for name, module in sys.modules.items():
        # not getattr: some modules make up what is asked for
        about = vars(module) if isinstance(module, ModuleType) else {}
        where = [*about.get("__path__", ()), about.get("__file__")][0]
        if "." not in name and where and Path(where).parent == folder:
            found.add(name)
    return [name for name in sys.modules if name.partition(".")[0] in found - _OURS]


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
    """Import a file under a name that depends on its path only.

    Modules beside it can be imported, as those beside a script. They are loaded anew each time, as it is: nothing is
    left of an earlier run, nor of another file's neighbour of the same name.
    """
    if not (folder / path).is_file():
        raise ManagerError(f"There is no file {path}.")
    resolved = (folder / path).resolve()
    name = "sunset_manager_" + "".join(c if c.isalnum() else "_" for c in str(resolved.with_suffix("")))
    _folders.add(resolved.parent)
    for old in [name for known in _folders for name in _beside(known)]:
        del sys.modules[old]
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
    if isinstance(error, ValueError) and not place:  # so some versions of Python say it of null bytes
        return ManagerError(f"{where}: this is not valid Python: {error}.")
    return ManagerError(f"Importing {where} raised {described_error(error)}{place}.")


def _checked(spec: str, where: str, module: ModuleType, name: str) -> type[ManagingSystem]:
    found = getattr(module, name, None)
    if found is None:
        classes = [
            other
            for other, value in vars(module).items()
            if isinstance(value, type) and issubclass(value, ManagingSystem) and value is not ManagingSystem
        ]
        match classes:
            case []:
                hint = ""
            case [only]:
                hint = f": name {only}"
            case _:
                hint = f": {suggestion(name, classes)}name one of {', '.join(classes)}"
        raise ManagerError(f"There is no class {name} in {where}{hint}.")
    return _checked_class(spec, found)


def _checked_class(spec: str, found: object) -> type[ManagingSystem]:
    if not (isinstance(found, type) and issubclass(found, ManagingSystem)):
        raise ManagerError(f"{spec} is not a managing system: it must be a subclass of ManagingSystem.")
    if inspect.isabstract(found) or found.adapt is ManagingSystem.adapt:
        raise ManagerError(f"{spec} has no method adapt(self, symptoms).")
    if inspect.isgeneratorfunction(found.adapt) or inspect.isasyncgenfunction(found.adapt):
        raise ManagerError(
            f"The method adapt of {spec} contains yield, so that a call of it does nothing: call the adaptations, or "
            "write 'async def adapt' and await them."
        )
    _check_signatures(spec, found)
    return found


def _check_signatures(spec: str, found: type[ManagingSystem]) -> None:
    """Check that the class can be made and called as the experiment will."""
    try:
        inspect.signature(found).bind(context=None, cli_args=None, parameter_overrides=None)
    except TypeError as error:
        raise ManagerError(
            f"{spec} cannot be made: __init__ must accept context, cli_args and parameter_overrides "
            f"as keyword arguments ({error}); to prepare something, override on_start instead."
        ) from error
    try:
        inspect.signature(found.adapt).bind(None, None)
    except TypeError as error:
        raise ManagerError(
            f"The method adapt of {spec} must accept one argument, symptoms: 'def adapt(self, symptoms)'."
        ) from error
