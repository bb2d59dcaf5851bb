"""The command that starts a program: its words, and the files that it names."""

import os
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
    """How a program is started; as a text, `exec:COMMAND` that is the same in every folder and with any PATH.

    Attributes:
        words: the program and its arguments; paths of what exists are absolute.
        files: those that the command names, and those below folders that it names, sorted; without a program that is
            installed, in a folder called bin.
    """

    words: tuple[str, ...]
    files: tuple[Path, ...]

    def __str__(self) -> str:
        return PREFIX + shlex.join(self.words)

    @property
    def places(self) -> tuple[Path, ...]:
        """What it needs to be read: its files, the folders that it names, and what is installed with its program."""
        program, *arguments = map(Path, self.words)
        named = [path for path in arguments if path.is_absolute() and path.exists()]
        installed = [path for path in (program, program.resolve()) if path.parent.name in _INSTALLED]
        beside = [path.parents[1] / part for path in installed for part in ("bin", "lib", "pyvenv.cfg")]
        return (program, *named, *beside)


def parse_command(spec: str, folder: Path = Path()) -> Command:
    """Return the command of `exec:COMMAND`, whose words are as in a shell; no shell runs it.

    Args:
        spec: the managing system's name.
        folder: where paths in it begin that are not absolute.

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
    if any("__pycache__" in Path(word).parts for word in arguments):
        raise ManagerError(
            f"The managing system {spec} names a path in __pycache__, which is Python's own: keep its files elsewhere."
        )
    found = _found(spec, program, folder)
    paths = {word: (folder / word).absolute() for word in arguments if word and (folder / word).exists()}
    named = [*paths.values(), *([] if found.parent.name in _INSTALLED else [found])]
    return Command(
        (str(found), *(str(paths.get(word, word)) for word in arguments)),
        tuple(sorted({file for path in named for file in _files(spec, path)})),
    )


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


def _found(spec: str, program: str, folder: Path) -> Path:
    """Return the absolute path of a program."""
    path = folder / program if "/" in program else Path(shutil.which(program) or "")
    # not by shutil.which, which asks for the real user: that of a confined process can do less than its effective one
    if path.is_file() and os.access(path, os.X_OK, effective_ids=os.access in os.supports_effective_ids):
        return path.absolute()
    if (folder / program).is_file():
        remedy = f"let it be run (chmod +x {program}), or name what runs it, as exec:python3 {program}"
        if "/" not in program:
            remedy = f"a program that is not on PATH is named by its path, exec:./{program}"
        raise ManagerError(f"The managing system {spec} cannot be started: {remedy}.")
    where = f"is no file {program}" if "/" in program else f"is no program {program} on PATH"
    raise ManagerError(f"The managing system {spec} cannot be started: there {where}.")
