"""The files in which a managing system is written, and their checksum. None of its code runs here."""

import ast
import hashlib
import importlib.util
import inspect
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from sunset.errors import ManagerError
from sunset.files.sources import is_installed, modules_beside
from sunset.managing.loading import MANAGERS, PASSED
from sunset.managing.program import PREFIX, parse_command


def checksum(spec: str) -> str:
    """Return the SHA-256 of a managing system's files as they are now, in hexadecimal.

    It covers `source_files` and `partial_arguments`, and is empty if these do not identify the code.

    Raises:
        ManagerError: a file is missing, or not Python.
    """
    texts = [source.read_bytes() for source in source_files(spec)]
    return sources_digest([*texts, *partial_arguments(spec)])


def sources_digest(texts: Iterable[bytes]) -> str:
    """Return the checksum of files with these contents, in their order; empty without files."""
    digests = b"".join(hashlib.sha256(text).digest() for text in texts)
    return hashlib.sha256(digests).hexdigest() if digests else ""


def source_files(spec: str) -> tuple[Path, ...]:
    """Return the files of a managing system, given by its name as in `load_manager`.

    - `FILE.py:Class`: the file, the modules beside it that import statements reach, and the data that it declares;
    - `module:Class`: all files of the package, and the data;
    - `exec:COMMAND`: the files that the command names;
    - a class or function that was passed: its file and the files of its base classes; empty if a class has no file.

    Raises:
        ManagerError: a file is missing, or not Python.
    """
    if spec.startswith(PREFIX):
        return parse_command(spec).files
    if spec in MANAGERS:
        return (Path(inspect.getfile(MANAGERS[spec])),)
    if spec in PASSED:
        return PASSED[spec].files
    where = spec.rpartition(":")[0]
    if where.endswith(".py"):
        if not Path(where).is_file():
            raise ManagerError(f"There is no file {where}.")
        return tuple(sorted({*_imported_files(Path(where).resolve()), *manager_data(spec)}))
    package = where.partition(".")[0]
    described = importlib.util.find_spec(where if package == "sunset" else package) if where else None
    if described is None:
        return ()
    folders = map(Path, described.submodule_search_locations or ())
    files = {file for folder in folders for file in folder.rglob("*.py")} or {Path(described.origin or "")}
    return tuple(sorted({*files, *manager_data(spec)}))


def partial_arguments(spec: str) -> tuple[bytes, ...]:
    """Return the arguments of a `functools.partial` that was passed, as text; they are part of the checksum."""
    return PASSED[spec].arguments if spec in PASSED else ()


def manager_code(spec: str) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Return the folders in which a managing system's modules are looked up, and all Python files in them.

    The folders are the folder of its file or package, and folders of `sys.path` without installed packages.
    """
    file, where = _own_file(spec), spec.rpartition(":")[0]
    folders = [Path(entry).resolve() for entry in sys.path if entry]
    roots = [folder for folder in folders if folder.is_dir() and not is_installed(folder)]
    files: list[Path] = []
    if file:
        links = [Path(where).absolute()] if where.endswith(".py") else []  # the links on the way to it
        files = [*links, file]
        roots.insert(0, file.parents[file.stem == "__init__"])
    roots = list(dict.fromkeys(roots))
    files += [module for root in roots for module in modules_beside(root)]
    return tuple(roots), tuple(dict.fromkeys(files))


def manager_data(spec: str) -> tuple[Path, ...]:
    """Return the files that a managing system's class declares as `files`, relative to its own file.

    The declaration is a tuple of literal texts, such as `files = ("weights.npz",)`.

    Raises:
        ManagerError: `files` is anything else, or one of them is not a file.
    """
    file, name = _own_file(spec), spec.rpartition(":")[2]
    if file is None or not file.is_file():
        return ()
    paths = []
    for text in _declared_names(file, name):
        path = Path(os.path.normpath(file.parent / text))  # a link to it is shown, too
        if not path.is_file():
            raise ManagerError(
                f"The managing system {spec} names a file {text} in files, and {path} is not a file."
            )
        paths.append(path)
    return tuple(paths)


def _imported_files(main: Path) -> set[Path]:
    """Return a file and the modules beside it that it imports, directly or through other modules."""
    root = main.parent
    beside = {_module_name(file, root): file for file in modules_beside(root)}
    files, todo = set[Path](), [main]
    while todo:
        file = todo.pop()
        if file in files:
            continue
        files.add(file)
        for name in _imported_names(file, root) if file.suffix == ".py" else ():
            parts = name.split(".")
            parents = (".".join(parts[:end]) for end in range(1, len(parts) + 1))
            todo += [beside[parent] for parent in parents if parent in beside]
    return files


def _module_name(file: Path, root: Path) -> str:
    *packages, name = file.relative_to(root).parts
    return ".".join([*packages, name.partition(".")[0]]).removesuffix(".__init__")


def _imported_names(file: Path, root: Path) -> Iterator[str]:
    """Yield the modules that a file's import statements name, and names in them that may be modules."""
    package = file.parent.relative_to(root).parts
    try:
        tree = ast.parse(file.read_bytes())
    except (SyntaxError, ValueError) as error:
        raise ManagerError(f"The file {file} cannot be read as Python: {error}.") from error
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else ()
            base = [*above, *filter(None, [node.module])]
            yield from (".".join([*base, alias.name]) for alias in node.names)


def _declared_names(file: Path, name: str) -> list[str]:
    """Return the names that the class `name` of a file declares in `files`."""
    try:
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError):  # loading it reports that
        return []
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == name]
    for statement in (statement for kind in classes for statement in kind.body):
        match statement:
            case (
                ast.Assign(targets=[ast.Name("files")], value=value)
                | ast.AnnAssign(target=ast.Name("files"), value=ast.expr() as value)
            ):
                return _literal_names(file, name, value)
    return []


def _literal_names(file: Path, name: str, value: ast.expr) -> list[str]:
    try:
        names = ast.literal_eval(value)
    except ValueError:
        names = None
    if not isinstance(names, tuple | list) or not all(isinstance(text, str) and text for text in names):
        raise ManagerError(
            f"{file.name}, line {value.lineno}: files of {name} must be a tuple of names, written out, such as "
            f'files = ("weights.npz",), got {ast.unparse(value)}.'
        )
    return list(names)


def _own_file(spec: str) -> Path | None:
    """Return the file of a managing system's class or package, if it is the user's own and not installed."""
    where, _, name = spec.rpartition(":")
    if spec.startswith(PREFIX) or spec in MANAGERS or spec in PASSED or not where or not name:
        return None
    if where.endswith(".py"):
        return Path(where).resolve()
    try:
        described = importlib.util.find_spec(where.partition(".")[0])
    except (ImportError, ValueError):
        return None
    if described is None or described.origin is None:
        return None
    origin = Path(described.origin).resolve()
    return None if is_installed(origin) or not origin.is_file() else origin
