"""The command that starts a program: its words, and the files that it names."""

import shlex
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from sunset.errors import ManagerError

PREFIX: Final = "exec:"
"""Begins the name of a managing system that is a program; its command follows."""

_INSTALLED: Final = frozenset({"bin", "sbin"})
"""Folders of programs that are not a managing system's own."""
_MOST_FILES: Final = 1000


@dataclass(frozen=True, slots=True)
class Command:
    """How a program is started.

    Attributes:
        words: the program and its arguments; paths of what exists are absolute.
        files: those that the command names, and those below folders that it names, sorted; without a program that is
            installed: found on PATH, or in a folder that is called bin.
    """

    words: tuple[str, ...]
    files: tuple[Path, ...]


def parse_command(spec: str) -> Command:
    """Return the command of `exec:COMMAND`, whose words are as in a shell; no shell runs it.

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
    found = _found(spec, program)
    own = "/" in program and found.parent.name not in _INSTALLED
    named = [*([found] if own else []), *(Path(word).absolute() for word in arguments if Path(word).exists())]
    words = [str(Path(word).absolute()) if Path(word).exists() else word for word in arguments]
    return Command(
        (str(found), *words), tuple(sorted({file for path in named for file in _files(spec, path)}))
    )


def resolved_spec(spec: str) -> str:
    """Return `exec:COMMAND` such that it is the same in another working directory, and with another PATH.

    Raises:
        ManagerError: as `parse_command`.
    """
    return PREFIX + shlex.join(parse_command(spec).words)


def _files(spec: str, path: Path) -> Iterator[Path]:
    """Yield a file, or the files below a folder."""
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


def _found(spec: str, program: str) -> Path:
    """Return the absolute path of a program."""
    if found := shutil.which(program):
        return Path(found).absolute()
    if Path(program).is_file():
        remedy = f"let it be run (chmod +x {program}), or name what runs it, as exec:python3 {program}"
        if "/" not in program:
            remedy = f"a program that is not on PATH is named by its path, exec:./{program}"
        raise ManagerError(f"The managing system {spec} cannot be started: {remedy}.")
    where = f"is no file {program}" if "/" in program else f"is no program {program} on PATH"
    raise ManagerError(f"The managing system {spec} cannot be started: there {where}.")
