"""Finding a managing system by name, in a module, or in a file of one's own."""

import hashlib
import importlib
import importlib.util
import inspect
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Final, Self, cast

from sunset.errors import ManagerError
from sunset.managing.base import ManagingSystem
from sunset.managing.baseline import Baseline
from sunset.managing.none import NoAdaptation
from sunset.managing.symptoms import Symptoms
from sunset.texts import suggestion

MANAGERS: Final[Mapping[str, type[ManagingSystem]]] = MappingProxyType(
    {"none": NoAdaptation, "baseline": Baseline}
)
"""The managing systems that come with SUNSET, by name."""

_OURS: Final = frozenset({"sunset", "__main__", "__mp_main__"})
"""Top-level modules that are not part of a managing system, wherever they are."""

_LABEL: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.+-]{0,39}")
_RESERVED: Final = frozenset({*MANAGERS, "external"})

_registered: dict[str, type[ManagingSystem]] = {}
"""Those that were passed as classes, by the names that they are loaded by in this process and in those it forks."""
_origins: dict[str, Callable[..., ManagingSystem]] = {}
"""What was passed: the class, or the function that makes one."""

_folders: set[Path] = set()
"""Where files were loaded from."""


def split_label(text: str) -> tuple[str, str]:
    """Return the label of `LABEL=MANAGER` and what stands behind it; an empty label if there is none.

    A path or a module before the first `=` is not a label: `a=b/mine.py:Mine` is a file in the folder `a=b`.

    Raises:
        ManagerError: the label has other characters than a label may have, is too long, or is the name of a
            managing system that comes with SUNSET.

    >>> split_label("mine-2=mine.py:Mine"), split_label("baseline")
    (('mine-2', 'mine.py:Mine'), ('', 'baseline'))
    """
    label, separator, manager = text.partition("=")
    if not separator or "/" in label or ":" in label:
        return "", text
    if not _LABEL.fullmatch(label):
        raise ManagerError(
            f"The label of the managing system {text!r} must be 1 to 40 of the letters a to z and A to Z, digits, "
            f"'_', '.', '+' and '-', and begin with a letter or digit, got {label!r}."
        )
    if label in _RESERVED:
        raise ManagerError(
            f"The label {label!r} is the name of a managing system that comes with SUNSET; choose another for "
            f"{manager}."
        )
    return label, manager


def load_manager(spec: str) -> type[ManagingSystem]:
    """Return the class of a managing system.

    Args:
        spec: a name of `MANAGERS`, or `module:Class`, or `path/to/file.py:Class`.

    Raises:
        ManagerError: there is none of that name, or its module does not load, or it is not a managing system.

    >>> load_manager("baseline").__name__
    'Baseline'
    """
    if known := MANAGERS.get(spec) or _registered.get(spec):
        return known
    if not spec.isprintable():
        raise ManagerError(
            f"The managing system {spec!r} has a character in its name that no record can hold."
        )
    where, separator, name = spec.rpartition(":")
    if not separator or not where or not name:
        if spec.endswith(".py"):
            raise ManagerError(
                f"The managing system {spec!r} is a file: name its class too, as {spec}:Class."
            )
        raise ManagerError(
            f"There is no managing system {spec!r}: {suggestion(spec, MANAGERS)}name {', '.join(MANAGERS)}, or your "
            "own as module:Class or path/to/file.py:Class."
        )
    module = _load_file(Path(where)) if where.endswith(".py") else _load_module(where)
    with _translated(spec):
        return _checked(spec, where, module, name)


def register_manager(manager: Callable[..., ManagingSystem]) -> str:
    """Return the name by which this process, and those that it forks, load a managing system of their own.

    Args:
        manager: a class, or a function that makes one: it gets the keyword arguments of `ManagingSystem`.

    Raises:
        ManagerError: it is neither, or not a managing system.
    """
    if isinstance(manager, ManagingSystem) or not callable(manager):
        raise ManagerError(
            "A managing system must be a name, a subclass of ManagingSystem or a function that makes one, got "
            f"an object of type {type(manager).__name__}: pass the class itself, without parentheses."
        )
    function = getattr(manager, "func", manager)  # of a functools.partial
    name = f"{function.__module__}:{getattr(function, '__qualname__', type(function).__name__)}"
    made = manager if isinstance(manager, type) else _class_of_factory(name, manager)
    _registered[name], _origins[name] = _checked_class(name, made), function
    return name


def is_registered(name: str) -> bool:
    """Return whether a managing system was passed as a class, so that only this process and its forks have it."""
    return name in _registered


def _class_of_factory(name: str, make: Callable[..., ManagingSystem]) -> type[ManagingSystem]:
    """Return a class of which every instance is what a function makes."""

    class Made(ManagingSystem):
        __signature__ = inspect.signature(make)

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
            f"The managing system {spec} cannot be looked at: it raised {type(error).__name__}: {error}."
        ) from error


def manager_sources(spec: str, made: type[ManagingSystem]) -> tuple[Path, ...]:
    """Return the files in which a managing system is written: its own, with what it imports beside it, or its package.

    `spec` is its name, `made` what `load_manager` returned for it.
    """
    with _translated(spec):
        return _sources(spec, _source_file(_origins.get(spec, made)))


def _source_file(origin: Callable[..., ManagingSystem]) -> str | None:
    """Return the file that defines something; None where that is a notebook's cell or a console."""
    try:
        source = inspect.getsourcefile(origin)
    except (OSError, TypeError):
        return None
    return source if source and Path(source).is_file() else None


def _sources(spec: str, source: str | None) -> tuple[Path, ...]:
    where = spec.rpartition(":")[0]
    if source is None and where.endswith(".py"):
        source = str(Path(where).resolve())  # its class may claim to be of any module
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

    Where there is no file, as for a class of a notebook, it is that of the methods' source if Python still has it; else
    an empty text.
    """
    texts = [source.read_bytes() for source in sources] or _method_texts(_origins.get(spec))
    return (
        hashlib.sha256(b"".join(hashlib.sha256(text).digest() for text in texts)).hexdigest() if texts else ""
    )


def _method_texts(origin: Callable[..., ManagingSystem] | None) -> list[bytes]:
    functions = vars(origin).values() if isinstance(origin, type) else [origin]
    try:
        return [inspect.getsource(one).encode() for one in functions if inspect.isfunction(one)]
    except OSError:
        return []


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


def _load_file(path: Path) -> ModuleType:
    """Import a file under a name that depends on its path only.

    Modules beside it can be imported, as those beside a script. They are loaded anew each time, as it is: nothing is
    left of an earlier run, nor of another file's neighbour of the same name.
    """
    if not path.is_file():
        raise ManagerError(f"There is no file {path}.")
    resolved = path.resolve()
    name = "sunset_manager_" + "".join(c if c.isalnum() else "_" for c in str(resolved.with_suffix("")))
    spec = importlib.util.spec_from_file_location(name, resolved)
    if spec is None or spec.loader is None:
        raise ManagerError(f"{path} is not a Python file.")
    _folders.add(resolved.parent)
    for old in [name for known in _folders for name in _beside(known)]:
        del sys.modules[old]
    folder = str(resolved.parent)
    sys.path[:] = [folder, *(path for path in sys.path if path != folder)]
    importlib.invalidate_caches()  # a neighbour may be younger than what is known of the folder
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and pickle look a class's module up
    try:
        spec.loader.exec_module(module)
    except BaseException as error:
        del sys.modules[name]
        raise _import_error(str(path), error) from error
    return module


def _import_error(where: str, error: BaseException) -> ManagerError:
    if isinstance(error, SyntaxError):
        line = f", line {error.lineno}" if error.lineno else ""
        return ManagerError(f"{where}{line}: this is not valid Python: {error.msg}.")
    return ManagerError(f"Importing {where} raised {type(error).__name__}: {error}.")


def _checked(spec: str, where: str, module: ModuleType, name: str) -> type[ManagingSystem]:
    found = getattr(module, name, None)
    if found is None:
        classes = [
            other
            for other, value in vars(module).items()
            if isinstance(value, type) and issubclass(value, ManagingSystem) and value is not ManagingSystem
        ]
        hint = f": {suggestion(name, classes)}name one of {', '.join(classes)}" if classes else ""
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
            f"The method adapt of {spec} must accept one argument, symptoms ({error})."
        ) from error
