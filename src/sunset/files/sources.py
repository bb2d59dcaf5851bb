"""Importing users' Python files without bytecode, and checksums of source files.

Python accepts a file's bytecode if size and modification time, in whole seconds, match. Both may match after an edit
within a second.
"""

import hashlib
import importlib.util
import inspect
import os
import sys
import traceback
from collections.abc import Iterable, Sequence
from functools import cache
from importlib.machinery import EXTENSION_SUFFIXES, SOURCE_SUFFIXES, ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Final

import sunset
from sunset.texts.sentences import line_text

PACKAGES: Final = {
    name: Path(str(spec.origin)).parent
    for name in ("sunset", "sunset_ros", "sunset_town", "sunset_lab")
    if (spec := importlib.util.find_spec(name))
}
"""Name → folder of this package, the client library, the town and the lab, whose modules are not a user's."""

_folders: set[Path] = set()
"""Folders whose modules are imported without bytecode."""
_known: set[Path] = set()
"""Importable files in folders that cannot be listed."""
_compiled: dict[Path, str] = {}
"""File → the SHA-256 of its text when it was compiled."""

LIBRARIES: Final = frozenset({"site-packages", "dist-packages"})
"""The names of folders of installed packages."""

_OWN: Final = (".py", ".yaml")
"""Endings of the packages' own files that decide results; models and flights have checksums of their own."""
_MODULES: Final = (*EXTENSION_SUFFIXES, *SOURCE_SUFFIXES)


@cache
def package_version() -> str:
    """Return SUNSET's version with a checksum of the sources of `PACKAGES`, such as `0.1.0+c3f2a1b4`.

    Edited files make another version, since results may differ.
    """
    digest = hashlib.sha256()
    for package, place in PACKAGES.items():
        root = str(place)  # a Path a file takes as long as reading it
        for folder, folders, files in os.walk(root):
            folders[:] = sorted(set(folders) - {"__pycache__"})
            for name in sorted(file for file in files if file.endswith(_OWN)):
                path = f"{folder}/{name}"
                with open(path, "rb", buffering=0) as file:  # noqa: PTH123  as above
                    text = file.read()
                digest.update(f"{package}{path.removeprefix(root)} {len(text)}\n".encode())
                digest.update(text)
    return f"{sunset.__version__}+{digest.hexdigest()[:8]}"


class _Loader(SourceFileLoader):
    """Compiles the current text of a file, and writes no bytecode."""

    def get_code(self, fullname: str) -> CodeType:
        path = self.get_filename(fullname)
        text = self.get_data(path)
        _compiled[Path(path)] = hashlib.sha256(text).hexdigest()
        code: CodeType = self.source_to_code(text, path)
        return code


class _Finder:
    """Finds modules as Python does, and loads those in users' folders without bytecode."""

    @staticmethod
    def find_spec(
        name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        spec = _known_spec(name, path) or PathFinder.find_spec(name, path, target)
        if (
            spec is not None
            and type(spec.loader) is SourceFileLoader
            and name.partition(".")[0] not in PACKAGES
        ):
            depth = name.count(".") + (spec.submodule_search_locations is not None)
            if _folders.intersection([*Path(spec.loader.path).parents][depth : depth + 1]):
                spec.loader = _Loader(name, spec.loader.path)
        return spec


def _known_spec(name: str, path: Sequence[str] | None) -> ModuleSpec | None:
    """Return the spec of a module in the files of `_known`; None if they do not contain it."""
    last = name.rpartition(".")[2]
    for entry in sys.path if path is None else path:
        place = Path(entry, last)
        for suffix in _MODULES:
            package, module = place / f"__init__{suffix}", place.with_name(f"{last}{suffix}")
            if package in _known:
                return importlib.util.spec_from_file_location(
                    name, package, submodule_search_locations=[str(place)]
                )
            if module in _known:
                return importlib.util.spec_from_file_location(name, module)
        if any(place in file.parents for file in _known):  # a namespace
            spec = ModuleSpec(name, None, is_package=True)
            spec.submodule_search_locations = [str(place)]
            return spec
    return None


def find_modules(folders: Iterable[Path], files: Iterable[Path]) -> None:
    """Make files in folders that cannot be listed importable, before modules of the same name elsewhere.

    `PACKAGES` stay importable, too, where each has been installed from a source folder.
    """
    given = [*files]
    _known.update(place / "__init__.py" for place in PACKAGES.values())
    for folder in reversed([*folders]):
        _known.update(file for file in given if file.is_relative_to(folder))
        import_from(folder)


def modules_beside(folder: Path) -> tuple[Path, ...]:
    """Return the Python files in a folder, and in packages in it.

    Links to other files are left out, and names that are not UTF-8, which Python cannot import.
    """
    modules: list[Path] = []
    try:
        entries = sorted(folder.iterdir())
    except OSError:  # the user may lack the permission
        return ()
    for entry in entries:
        if any("\udc80" <= letter <= "\udcff" for letter in entry.name):
            continue
        if entry.name.endswith(_MODULES) and entry.is_file():
            modules += [entry] if entry.resolve().name.endswith(_MODULES) else []
        elif (entry / "__init__.py").is_file():
            modules += modules_beside(entry)
    return tuple(modules)


def installed_folders() -> tuple[Path, ...]:
    """Return the folders of Python, this package, and packages installed anywhere in `sys.path`.

    Files in a folder of `sys.path` that `has_libraries` are not the user's own, except in the working directory.
    """
    prefixes = [sys.prefix, sys.base_prefix, sys.exec_prefix, sys.base_exec_prefix]
    prefixes += map(str, PACKAGES.values())
    here = {"", str(Path.cwd())}
    libraries = [entry for entry in sys.path if entry not in here and has_libraries(Path(entry))]
    return tuple(dict.fromkeys(Path(place).resolve() for place in (*prefixes, *libraries)))


@cache
def has_libraries(folder: Path) -> bool:
    """Return whether a folder holds installed packages, by its name or by the metadata of a package in it."""
    return folder.name in LIBRARIES or any(folder.glob("*.dist-info"))


def is_installed(path: Path) -> bool:
    """Return whether a path is in one of `installed_folders`, or holds one of `PACKAGES`."""
    if any(path == package.parent for package in PACKAGES.values()):
        return True
    return any(path.is_relative_to(place) for place in installed_folders())


def import_file(path: Path, name: str) -> ModuleType:
    """Import a Python file, an absolute path, under a name; its exceptions pass."""
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
    """Return the last line of the imported file that ran; empty if no line ran, as after a `SyntaxError`."""
    frames = traceback.extract_tb(error.__traceback__)
    file = next((frame.filename for frame in frames if frame.name == "<module>"), "")
    inner = [frame for frame in frames if frame.filename == file][-1:]
    return "".join(line_text(file, frame.lineno or 0, frame.name) for frame in inner)


def import_from(folder: Path) -> None:
    """Import modules from a folder before namesakes elsewhere, as a script does with its own folder."""
    _folders.add(folder)
    if _Finder not in sys.meta_path:
        sys.meta_path.insert(sys.meta_path.index(PathFinder), _Finder)
    sys.path[:] = [str(folder), *(path for path in sys.path if path != str(folder))]
    importlib.invalidate_caches()  # a module may be younger than the cached listing of the folder


def compiled_checksum(path: Path) -> str:
    """Return the SHA-256 of a file's text when it was imported here, in hexadecimal; empty if it was not."""
    return _compiled.get(path, "")


def functions_of(origin: object) -> list[FunctionType]:
    """Return the functions of a class, also of properties and decorated methods; or a function itself."""
    members: list[object] = []
    for value in vars(origin).values() if isinstance(origin, type) else [origin]:
        if isinstance(value, property):
            members += [value.fget, value.fset, value.fdel]
        else:
            members.append(value.__func__ if isinstance(value, staticmethod | classmethod) else value)
    return [inspect.unwrap(member) for member in members if isinstance(member, FunctionType)]
