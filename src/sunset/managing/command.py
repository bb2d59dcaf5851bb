"""The command that starts a program: its words and its files."""

import os
import re
import shlex
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from sunset.errors import ManagerError
from sunset.files.sources import has_libraries

PREFIX: Final = "exec:"
"""Begins the name of a managing system that is a program; its command follows."""

_INSTALLED: Final = frozenset({"bin", "sbin"})
"""Folders of installed programs."""
_SHIMS: Final = "shims"
"""The folder in which pyenv, asdf and others keep scripts that look for a program and run it."""
_PYTHON: Final = re.compile(r"(python|pypy)[\d.]*")
_PRINT_PLACES: Final = "import sys; print(sys.executable, *filter(None, sys.path), sep='\\n')"
_LONGEST_LINE: Final = 256
_PATIENCE_S: Final = 300.0
_MOST_FILES: Final = 1000


@dataclass(frozen=True, slots=True)
class Command:
    """A command; as a text, `exec:COMMAND` that is the same in every folder and with any PATH.

    Attributes:
        words: the program and its arguments, with absolute paths of files that exist.
        files: the files that the command names, also in folders, sorted; without an installed program.
    """

    words: tuple[str, ...]
    files: tuple[Path, ...]

    def __str__(self) -> str:
        return PREFIX + shlex.join(self.words)

    @property
    def places(self) -> tuple[Path, ...]:
        """The files and folders that the program must be able to read: its own, and those installed with it."""
        program, *arguments = map(Path, self.words)
        named = [path for path in arguments if path.is_absolute() and path.exists()]
        runs = [Path(word) for word in _interpreter(program)[:1]]
        started = [path for word in (program, *runs) for path in (word, word.resolve())]
        installed = [path for path in started if path.parent.name in _INSTALLED]
        beside = [path.parents[1] / part for path in installed for part in ("bin", "lib", "pyvenv.cfg")]
        libraries = [
            Path(entry)
            for word in (program, *runs)
            if _PYTHON.fullmatch(word.name)
            for entry in _python_places(word)[1:]
            if has_libraries(Path(entry))
        ]
        return (program, *runs, *named, *beside, *libraries)


def parse_command(spec: str, folder: Path = Path()) -> Command:
    """Return the command of `exec:COMMAND`, which is split as in a shell.

    Args:
        spec: the managing system's name.
        folder: the folder in which relative paths begin.

    Raises:
        ManagerError: it is empty, its quotes do not match, or its program cannot be found or run.
    """
    try:
        program, *arguments = shlex.split(spec.removeprefix(PREFIX))
    except ValueError as error:
        reason = "a command must follow" if "unpack" in str(error) else f"{error}".lower()
        raise ManagerError(
            f"The managing system {spec!r} cannot be started: {reason}; name it as exec:PROGRAM ARGUMENTS, with words "
            "that have spaces in quotes."
        ) from error
    executable = _executable(spec, program, folder)
    is_own = executable.parent.name not in _INSTALLED
    runs = _interpreter(executable) if is_own else []
    if runs:
        runs[0] = str(_executable(spec, runs[0], folder))
    paths = {word: (folder / word).absolute() for word in arguments if word and (folder / word).exists()}
    named = [*paths.values(), *([executable] if is_own else [])]
    script = arguments[0] if arguments and _PYTHON.fullmatch(executable.name) else "-"
    if not script.startswith("-") and script not in paths:
        raise ManagerError(f"The managing system {spec} cannot be started: there is no file {script}.")
    return Command(
        (*runs, str(executable), *(str(paths.get(word, word)) for word in arguments)),
        tuple(sorted({file for path in named for file in _files(spec, path)})),
    )


def _files(spec: str, path: Path) -> Iterator[Path]:
    if path.is_file():
        yield path
        return
    inside = (file for file in path.rglob("*") if file.is_file() and "__pycache__" not in file.parts)
    for number, file in enumerate(inside):
        if number == _MOST_FILES:
            raise ManagerError(
                f"The managing system {spec} names the folder {path}, which holds more than {_MOST_FILES} files: name "
                "one that holds its program only."
            )
        yield file


def _interpreter(program: Path) -> list[str]:
    """Return the words of a script's `#!` line; empty for a program that is not a script."""
    try:
        with program.open("rb") as file:
            line = file.readline(_LONGEST_LINE)
    except OSError:  # executable, but not readable
        return []
    words = os.fsdecode(line.removeprefix(b"#!")).strip().split(maxsplit=1) if line.startswith(b"#!") else []
    if len(words) > 1 and Path(words[0]).name == "env":
        with suppress(ValueError):
            looked_up = shlex.split(words[1].removeprefix("-S"))
            if looked_up and not looked_up[0].startswith("-") and "=" not in looked_up[0]:
                return looked_up
    return words


def _without_shim(spec: str, program: Path) -> Path:
    """Return the Python that a shim runs, which the shim itself cannot find behind the walls, or the program."""
    if _PYTHON.fullmatch(program.name) and _interpreter(program):
        if (python := Path(_python_places(program)[0])).is_file():
            return python
        raise ManagerError(
            f"The managing system {spec} cannot be started: {program} does not say which Python it runs; name that by "
            "its path."
        )
    if program.parent.name == _SHIMS:
        raise ManagerError(
            f"The managing system {spec} cannot be started: {program} only looks for the program {program.name} and "
            "runs it, in files that a managing system cannot see; name the program itself by its path."
        )
    return program


@cache
def _python_places(python: Path) -> tuple[str, ...]:
    """Return the path of a Python and its `sys.path`; an empty text if it does not print them."""
    variables = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    try:
        done = subprocess.run(  # noqa: S603  the user's own command
            [python, "-c", _PRINT_PLACES],
            env=variables,
            capture_output=True,
            text=True,
            check=False,
            timeout=_PATIENCE_S,
        )
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return ("",)
    return tuple(done.stdout.splitlines()) or ("",)


def _executable(spec: str, program: str, folder: Path) -> Path:
    """Return the absolute path of a program."""
    path = folder / program if "/" in program else Path(shutil.which(program) or "")
    # shutil.which asks for the real user, who can do less than the effective user of a confined process
    if path.is_file() and os.access(path, os.X_OK, effective_ids=os.access in os.supports_effective_ids):
        return _without_shim(spec, path.absolute())
    if (folder / program).is_file():
        remedy = f"let it be run (chmod +x {program}), or name what runs it, as exec:python3 {program}"
        if "/" not in program:
            remedy = f"a program that is not on PATH is named by its path, exec:./{program}"
        raise ManagerError(f"The managing system {spec} cannot be started: {remedy}.")
    where = f"is no file {program}" if "/" in program else f"is no program {program} on PATH"
    raise ManagerError(f"The managing system {spec} cannot be started: there {where}.")
