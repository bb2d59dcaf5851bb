"""The files that a managing system needs: what is found out without running any of it."""

import ast
import importlib.util
import os
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from sunset.errors import ManagerError
from sunset.managing.command import PREFIX, parse_command
from sunset.managing.loading import is_registered
from sunset.managing.names import MANAGERS
from sunset.source_files import is_installed, modules_beside


def manager_code(spec: str) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Return the folders in which the modules of a managing system are looked up, and the Python files in them.

    The first is that of its own file or package; the others are those of `sys.path` in which nothing is installed. The
    files are all that can be imported from there, whether it does or not. `spec` is its name, as of `load_manager`.
    """
    file = _file(spec)
    folders = [Path(entry).resolve() for entry in sys.path if entry]
    roots = [folder for folder in folders if folder.is_dir() and not is_installed(folder)]
    found = [file] if file else []
    if file and spec.rpartition(":")[0].endswith(".py"):  # the links on the way to it, too
        found.insert(0, Path(spec.rpartition(":")[0]).absolute())
    if file:
        roots.insert(0, file.parents[file.stem == "__init__"])
    roots = list(dict.fromkeys(roots))
    return tuple(roots), tuple(
        dict.fromkeys([*found, *(module for root in roots for module in modules_beside(root))])
    )


def manager_data(spec: str, folder: Path | None = None) -> tuple[Path, ...]:
    """Return the files that a managing system says it reads: `files` of its class, relative to the file it stands in.

    The class says so with a tuple of texts, written out, such as `files = ("weights.npz",)`. A path in `spec` that is
    not absolute begins in `folder`, else in the working directory.

    Raises:
        ManagerError: `files` is anything else, or one of them is not a file.
    """
    file, name = _file(spec, folder), spec.rpartition(":")[2]
    if file is None or not file.is_file():
        return ()
    found = []
    for text in _declared(file, name):
        path = Path(os.path.normpath(file.parent / text))  # a link to it is shown, too
        if not path.is_file():
            raise ManagerError(
                f"The managing system {spec} names a file {text} in files, and {path} is not a file."
            )
        found.append(path)
    return tuple(found)


def written_files(spec: str) -> Iterator[tuple[Path, ...]]:
    """Yield the files that a managing system may be written in, the likeliest first, without running its code.

    The modules beside a file are found by import statements: first by those outside of functions and branches, then by
    all.

    Raises:
        ManagerError: its file or its program is gone, or a file is not Python.
    """
    where = spec.rpartition(":")[0]
    if spec.startswith(PREFIX):
        yield parse_command(spec).files
    elif where.endswith(".py"):
        if not Path(where).is_file():
            raise ManagerError(f"There is no file {where}.")
        for everywhere in (False, True):
            yield (*sorted(_with_imports(Path(where).resolve(), everywhere=everywhere)), *manager_data(spec))
    elif where and (found := importlib.util.find_spec(where.partition(".")[0])) is not None:
        folders = map(Path, found.submodule_search_locations or ())
        files = {file for folder in folders for file in folder.rglob("*.py")} or {Path(found.origin or "")}
        yield (*sorted(files), *manager_data(spec))


def _with_imports(main: Path, *, everywhere: bool) -> set[Path]:
    """Return a file, and those beside it that it imports, or that they do."""
    files, todo = set[Path](), [main]
    while todo:
        file = todo.pop()
        if file not in files:
            files.add(file)
            for name in _imported(file, main.parent, everywhere=everywhere):
                places = [
                    main.parent.joinpath(*name.split(".")[:end]) for end in range(1, name.count(".") + 2)
                ]
                todo += [
                    found
                    for place in places
                    for found in (place / "__init__.py", place.with_suffix(".py"))
                    if found.is_file()
                ]
    return files


def _imported(file: Path, root: Path, *, everywhere: bool) -> Iterator[str]:
    """Yield the names of the modules that a file imports, and of names in them that may be modules."""
    package = file.parent.relative_to(root).parts
    try:
        todo: list[ast.AST] = [ast.parse(file.read_bytes())]
    except (SyntaxError, ValueError) as error:
        raise ManagerError(f"The file {file} cannot be read as Python: {error}.") from error
    while todo:
        node = todo.pop()
        if everywhere or not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.If):
            todo += ast.iter_child_nodes(node)
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else ()
            base = [*above, *filter(None, [node.module])]
            yield from (".".join([*base, alias.name]) for alias in node.names)


def check_sources(spec: str, sources: Iterable[str], places: Iterable[Path]) -> None:
    """Check that a managing system's source files are ones that it may read, its own among them.

    Args:
        spec: its name, as of `load_manager`.
        sources: the source files that its process reports.
        places: the files and folders that the process may read, beside what is installed.

    Raises:
        ManagerError: they are not.
    """
    found = [Path(source).resolve() for source in sources]
    shown = [place.resolve() for place in places]
    own = _file(spec)
    if own is not None and spec.rpartition(":")[0].endswith(".py") and own not in found:
        raise ManagerError(
            f"The managing system {spec} reports another source file than {own}: do not change "
            "__file__ or the class's module."
        )
    for path in found:
        if not (is_installed(path) or any(path.is_relative_to(place) for place in shown)):
            raise ManagerError(
                f"The managing system {spec} reports the source file {path}, which it cannot read: do not change "
                "__file__ or the class's module."
            )


def _declared(file: Path, name: str) -> Iterator[str]:
    """Yield what the class of this name says in `files`."""
    try:
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError):  # loading it reports that
        return
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == name]
    for statement in (statement for kind in classes for statement in kind.body):
        if isinstance(statement, ast.AnnAssign):
            targets: list[ast.expr] = [statement.target]
        elif isinstance(statement, ast.Assign):
            targets = statement.targets
        else:
            continue
        if any(isinstance(target, ast.Name) and target.id == "files" for target in targets):
            yield from _texts(file, name, statement.value)


def _texts(file: Path, name: str, value: ast.expr | None) -> list[str]:
    try:
        texts = ast.literal_eval(value) if value is not None else ()
    except ValueError:
        texts = None
    if not isinstance(texts, tuple | list) or not all(isinstance(text, str) and text for text in texts):
        raise ManagerError(
            f"{file.name}, line {value.lineno if value else 0}: files of {name} must be a tuple of names, written out, "
            f'such as files = ("weights.npz",), got {ast.unparse(value) if value else None}.'
        )
    return list(texts)


def _file(spec: str, folder: Path | None = None) -> Path | None:
    """Return the file of a managing system that is not installed; None if it has none."""
    where, _, name = spec.rpartition(":")
    if spec.startswith(PREFIX) or spec in MANAGERS or is_registered(spec) or not where or not name:
        return None
    if where.endswith(".py"):
        return ((folder or Path()) / where).resolve()
    package = where.partition(".")[0]
    try:
        found = importlib.util.find_spec(package)
    except (ImportError, ValueError):
        return None
    if found is None or found.origin is None:
        return None
    origin = Path(found.origin).resolve()
    return None if is_installed(origin) or not origin.is_file() else origin
