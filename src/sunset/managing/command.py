"""The command that starts a program: its words, and the files that it names."""

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
from sunset.source_files import has_libraries

PREFIX: Final = "exec:"
"""Begins the name of a managing system that is a program; its command follows."""

_INSTALLED: Final = frozenset({"bin", "sbin"})
"""Folders of programs that are not a managing system's own."""
_SHIMS: Final = "shims"
"""What pyenv, asdf and others call the folder of the scripts that look for a program and run it."""
_PYTHON: Final = re.compile(r"(python|pypy)[\d.]*")
_ASKING: Final = "import sys; print(sys.executable, *filter(None, sys.path), sep='\\n')"
_LONGEST_LINE: Final = 256
_PATIENCE_S: Final = 300.0
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
        runs = [Path(word) for word in _interpreter(program)[:1]]
        started = [path for word in (program, *runs) for path in (word, word.resolve())]
        installed = [path for path in started if path.parent.name in _INSTALLED]
        beside = [path.parents[1] / part for path in installed for part in ("bin", "lib", "pyvenv.cfg")]
        libraries = [
            Path(entry)
            for word in (program, *runs)
            if _PYTHON.fullmatch(word.name)
            for entry in _asked(word)[1:]
            if has_libraries(Path(entry))
        ]
        return (program, *runs, *named, *beside, *libraries)


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
    own = found.parent.name not in _INSTALLED
    runs = _interpreter(found) if own else []
    if runs:
        runs[0] = str(_found(spec, runs[0], folder))
    paths = {word: (folder / word).absolute() for word in arguments if word and (folder / word).exists()}
    named = [*paths.values(), *([found] if own else [])]
    if (
        _PYTHON.fullmatch(found.name)
        and arguments
        and not arguments[0].startswith("-")
        and not paths.get(arguments[0])
    ):
        raise ManagerError(f"The managing system {spec} cannot be started: there is no file {arguments[0]}.")
    return Command(
        (*runs, str(found), *(str(paths.get(word, word)) for word in arguments)),
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


def _interpreter(program: Path) -> list[str]:
    """Return the words of a script's first line that say what runs it; none of a program that is not a script."""
    try:
        with program.open("rb") as file:
            line = file.readline(_LONGEST_LINE)
    except OSError:  # it may be run, and not be read
        return []
    words = os.fsdecode(line.removeprefix(b"#!")).strip().split(maxsplit=1) if line.startswith(b"#!") else []
    if len(words) > 1 and Path(words[0]).name == "env":
        with suppress(ValueError):
            looked_up = shlex.split(words[1].removeprefix("-S"))
            if looked_up and not looked_up[0].startswith("-") and "=" not in looked_up[0]:
                return looked_up
    return words


def _followed(spec: str, program: Path) -> Path:
    """Return the program that a script in its place would run, which is not to be found behind the walls."""
    if _PYTHON.fullmatch(program.name) and _interpreter(program):
        if (found := Path(_asked(program)[0])).is_file():
            return found
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
def _asked(python: Path) -> tuple[str, ...]:
    """Return where a Python is, and where it looks modules up; an empty text if it does not say."""
    variables = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    try:
        answer = subprocess.run(  # noqa: S603  the user's own command
            [python, "-c", _ASKING],
            env=variables,
            capture_output=True,
            text=True,
            check=False,
            timeout=_PATIENCE_S,
        )
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return ("",)
    return tuple(answer.stdout.splitlines()) or ("",)


def _found(spec: str, program: str, folder: Path) -> Path:
    """Return the absolute path of a program."""
    path = folder / program if "/" in program else Path(shutil.which(program) or "")
    # not by shutil.which, which asks for the real user: that of a confined process can do less than its effective one
    if path.is_file() and os.access(path, os.X_OK, effective_ids=os.access in os.supports_effective_ids):
        return _followed(spec, path.absolute())
    if (folder / program).is_file():
        remedy = f"let it be run (chmod +x {program}), or name what runs it, as exec:python3 {program}"
        if "/" not in program:
            remedy = f"a program that is not on PATH is named by its path, exec:./{program}"
        raise ManagerError(f"The managing system {spec} cannot be started: {remedy}.")
    where = f"is no file {program}" if "/" in program else f"is no program {program} on PATH"
    raise ManagerError(f"The managing system {spec} cannot be started: there {where}.")
