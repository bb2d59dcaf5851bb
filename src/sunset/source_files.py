"""The door for Python files: what runs is what stood in a user's file, and the version of this package's own.

Python takes bytecode for that of a file if the file's size and its time of change, in whole seconds, are those that
stand in it. A file that is edited within a second may have both.
"""

import hashlib
import importlib.util
import inspect
import os
import sys
import traceback
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES, SOURCE_SUFFIXES, ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Final

from sunset import __version__
from sunset.texts import line_text

_PACKAGE: Final = Path(__file__).parent

_folders: set[Path] = set()
"""Whose modules are imported without bytecode."""
_known: dict[str, frozenset[Path]] = {}
"""Folders that cannot be listed, and the files below them that can be imported."""
_compiled: dict[Path, str] = {}
"""The SHA-256 of what was compiled, by the file that it stood in."""


LIBRARIES: Final = frozenset({"site-packages", "dist-packages"})
"""The names of folders of installed packages."""

_OWN: Final = (".py", ".yaml")
"""Endings of this package's own files that decide results; models and flights have checksums of their own."""


@cache
def package_version() -> str:
    """Return this package's version with a checksum of its source files, such as `0.1.0+c3f2a1b4`.

    Edited files make another version, since results may differ.
    """
    root, digest = os.path.dirname(__file__), hashlib.sha256()  # noqa: PTH120  a Path a file takes as long as reading it
    for folder, folders, files in os.walk(root):
        folders[:] = sorted(set(folders) - {"__pycache__"})
        for name in sorted(file for file in files if file.endswith(_OWN)):
            path = f"{folder}/{name}"
            with open(path, "rb", buffering=0) as file:  # noqa: PTH123  likewise
                text = file.read()
            digest.update(f"{path.removeprefix(root)} {len(text)}\n".encode())
            digest.update(text)
    return f"{__version__}+{digest.hexdigest()[:8]}"


class _Loader(SourceFileLoader):
    """Compiles what stands in a file now, and writes no bytecode."""

    def get_code(self, fullname: str) -> CodeType:
        path = self.get_filename(fullname)
        text = self.get_data(path)
        _compiled[Path(path)] = hashlib.sha256(text).hexdigest()
        code: CodeType = self.source_to_code(text, path)
        return code


class _Finder:
    """Finds what Python would, and lets what is beside users' files be loaded as they are."""

    @staticmethod
    def find_spec(
        name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        spec = _known_spec(name, path) or PathFinder.find_spec(name, path, target)
        if spec is not None and type(spec.loader) is SourceFileLoader and name.partition(".")[0] != "sunset":
            depth = name.count(".") + (spec.submodule_search_locations is not None)
            if _folders.intersection([*Path(spec.loader.path).parents][depth : depth + 1]):
                spec.loader = _Loader(name, spec.loader.path)
        return spec


def _known_spec(name: str, path: Sequence[str] | None) -> ModuleSpec | None:
    """Return what Python would find of a module if it could list folders; None if none of them is known to have it."""
    last = name.rpartition(".")[2]
    for entry in sys.path if path is None else path:
        for root, files in _known.items():
            place = Path(entry, last)
            if not place.is_relative_to(root):
                continue
            for suffix in (*EXTENSION_SUFFIXES, *SOURCE_SUFFIXES):
                package, module = place / f"__init__{suffix}", place.with_name(f"{last}{suffix}")
                if package in files:
                    return importlib.util.spec_from_file_location(
                        name, package, submodule_search_locations=[str(place)]
                    )
                if module in files:
                    return importlib.util.spec_from_file_location(name, module)
            if any(place in file.parents for file in files):  # a namespace
                spec = ModuleSpec(name, None, is_package=True)
                spec.submodule_search_locations = [str(place)]
                return spec
    return None


def find_modules(folders: Iterable[Path], files: Iterable[Path]) -> None:
    """Let files below folders that cannot be listed be imported, before modules of the same name elsewhere."""
    given = frozenset(files)
    for folder in reversed([*folders]):
        _known[str(folder)] = frozenset(file for file in given if file.is_relative_to(folder))
        import_from(folder)


def modules_beside(folder: Path) -> tuple[Path, ...]:
    """Return the Python files in a folder, and those of the packages in it.

    A link to what is not such a file is none, nor is what Python cannot be told of, since its name is not UTF-8.
    """
    suffixes = (*SOURCE_SUFFIXES, *EXTENSION_SUFFIXES)
    found: list[Path] = []
    try:
        entries = sorted(folder.iterdir())
    except OSError:  # it may be closed to the user, too
        return ()
    for entry in entries:
        if any("\udc80" <= letter <= "\udcff" for letter in entry.name):
            continue
        if entry.name.endswith(suffixes) and entry.is_file():
            found += [entry] if entry.resolve().name.endswith(suffixes) else []
        elif (entry / "__init__.py").is_file():
            found += modules_beside(entry)
    return tuple(found)


def installed_folders() -> tuple[Path, ...]:
    """Return the folders that hold Python, this package, and packages installed anywhere in `sys.path`.

    A folder of `sys.path` that `has_libraries` is taken to hold no files of the user's own, unless it is the working
    directory.
    """
    prefixes = [sys.prefix, sys.base_prefix, sys.exec_prefix, sys.base_exec_prefix, str(_PACKAGE)]
    here = {"", str(Path.cwd())}
    libraries = [entry for entry in sys.path if entry not in here and has_libraries(Path(entry))]
    return tuple(dict.fromkeys(Path(place).resolve() for place in (*prefixes, *libraries)))


@cache
def has_libraries(folder: Path) -> bool:
    """Return whether a folder holds installed packages, by its name or by the metadata of one in it."""
    return folder.name in LIBRARIES or any(folder.glob("*.dist-info"))


def is_installed(path: Path) -> bool:
    """Return whether a file or folder is in one of `installed_folders`, or holds this package."""
    return path == _PACKAGE.parent or any(path.is_relative_to(place) for place in installed_folders())


def import_file(path: Path, name: str) -> ModuleType:
    """Import a Python file, an absolute path, under a name; what it raises is left to be translated."""
    loader = _Loader(name, str(path))
    module = importlib.util.module_from_spec(
        importlib.util.spec_from_file_location(name, path, loader=loader) or ModuleSpec(name, loader)
    )
    sys.modules[name] = module  # dataclasses and pickle look a class's module up
    try:
        loader.exec_module(module)
    except BaseException:
        sys.modules.pop(name, None)
        raise
    return module


def import_place(error: BaseException) -> str:
    """Return which line of the file that is imported was the last to run; empty if none was, as of a `SyntaxError`."""
    frames = traceback.extract_tb(error.__traceback__)
    file = next((frame.filename for frame in frames if frame.name == "<module>"), "")
    inner = [frame for frame in frames if frame.filename == file][-1:]
    return "".join(line_text(file, frame.lineno or 0, frame.name) for frame in inner)


def import_from(folder: Path) -> None:
    """Let modules in a folder be imported before those of the same name elsewhere, as those beside a script."""
    _folders.add(folder)
    if _Finder not in sys.meta_path:
        sys.meta_path.insert(sys.meta_path.index(PathFinder), _Finder)
    sys.path[:] = [str(folder), *(path for path in sys.path if path != str(folder))]
    importlib.invalidate_caches()  # a module may be younger than what is known of the folder


def compiled_checksum(path: Path) -> str:
    """Return the SHA-256 of what stood in a file when it was imported here, in hexadecimal; empty if it was not."""
    return _compiled.get(path, "")


def functions_of(origin: object) -> list[FunctionType]:
    """Return the functions of a class, those of its properties and decorated ones too; or a function itself."""
    found: list[object] = []
    for value in vars(origin).values() if isinstance(origin, type) else [origin]:
        if isinstance(value, property):
            found += [value.fget, value.fset, value.fdel]
        else:
            found.append(value.__func__ if isinstance(value, staticmethod | classmethod) else value)
    return [inspect.unwrap(one) for one in found if isinstance(one, FunctionType)]


def is_edited(path: Path, origin: object = None) -> bool:
    """Return whether a file has another text than when it was imported, where that can be known.

    Of a file that Python itself imported, the functions of `origin`, a class or a function of it, and of its module are
    compared with what would be compiled now.
    """
    try:
        text = path.read_bytes()
        if path in _compiled:
            return _compiled[path] != hashlib.sha256(text).hexdigest()
        module = sys.modules.get(getattr(origin, "__module__", ""))
        loader = vars(module).get("__loader__") if module else None
        if (
            type(loader) is not SourceFileLoader
        ):  # another one may compile something else, as that of pytest does
            return False
        codes = list(_codes(loader.source_to_code(text, str(path))))
    except (OSError, SyntaxError, ValueError):
        return True
    functions = [function for one in [origin, *vars(module).values()] for function in functions_of(one)]
    here = [one.__code__ for one in functions if Path(one.__code__.co_filename).resolve() == path.resolve()]
    return any(code not in codes for code in here)


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)
