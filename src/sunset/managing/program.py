"""A managing system that is a program in any language, with JSON lines on its standard input and output."""

import fcntl
import json
import math
import os
import re
import select
import shlex
import shutil
import subprocess
import termios
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import ClassVar, Final

import msgspec

from sunset.errors import ManagerError
from sunset.files.sources import has_libraries
from sunset.managing.answer import Answer
from sunset.managing.base import ManagingSystem
from sunset.managing.symptoms import Symptoms
from sunset.system.vocabulary import AdaptationKind, current_system
from sunset_ros.task import Future
from sunset_ros.texts import shorten, suggestion

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
_LONGEST: Final = 2**20
"""The longest line of a program's output, in bytes."""
_PIECE: Final = 2**16
_PARTING_S: Final = 10.0
"""How long a program that has closed its output may take to end, so that the error can name its exit code."""
_LOOK_S: Final = 0.1
"""The wait for output between two looks whether the program has ended."""
_QUOTED: Final = 100


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
        output = subprocess.check_output(  # noqa: S603  the user's own command
            [python, "-c", _PRINT_PLACES], env=variables, stderr=subprocess.DEVNULL, timeout=_PATIENCE_S
        )
        return tuple(output.decode().splitlines()) or ("",)
    except (OSError, ValueError, subprocess.SubprocessError):
        return ("",)


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


_ANSWERS: Final = msgspec.json.Decoder(Answer)


class Program(ManagingSystem):
    """Runs a program that decides: `adapt` writes a line to it and reads a line from it."""

    command: ClassVar[Command]

    def on_start(self) -> None:
        """Start the program, and send it the greeting.

        Raises:
            ManagerError: it cannot be started.
        """
        self.__output = bytearray()
        self.__lines = 0  # of its output, so far
        self.__requests = 0  # adaptations, so far
        self.__pending: list[tuple[int | str, Future[bool]]] = []
        try:
            self.__process = subprocess.Popen(  # noqa: S603  the user's own command
                self.command.words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
            )
        except OSError as error:
            reason = error.strerror or str(error)
            raise ManagerError(
                f"Its program cannot be started: {reason[:1].lower()}{reason[1:]}; a script begins with #! and the "
                "program that runs it."
            ) from error
        assert self.__process.stdin is not None  # noqa: S101  pipes were asked for
        assert self.__process.stdout is not None  # noqa: S101  likewise
        self.__inlet, self.__outlet = self.__process.stdin.fileno(), self.__process.stdout.fileno()
        self.__write(self.greeting)

    def adapt(self, symptoms: Symptoms) -> None:
        """Ask the program for adaptations, and request them.

        Raises:
            ManagerError: its answer breaks the protocol.
        """
        answered = [(name, future) for name, future in self.__pending if future.done()]
        self.__pending = [call for call in self.__pending if call not in answered]
        answer = self.__ask(
            {
                "time": self.now_s,
                "symptoms": {
                    name: value
                    for name, value in symptoms.items()
                    if not isinstance(value, float) or math.isfinite(value)
                },
                "results": [{"id": name, "accepted": future.result()} for name, future in answered],
            }
        )
        self.think(answer.think_s)
        if answer.diagnosis is not None:
            self.diagnose(answer.diagnosis)
        if answer.cost is not None:
            self.spend(**msgspec.structs.asdict(answer.cost))
        for adaptation in answer.adaptations:
            self.__requests += 1
            name = self.__requests if adaptation.id is None else adaptation.id
            self.__pending.append((name, adaptation.do(self)))

    def destroy_node(self) -> None:
        """Leave the graph, and end the program."""
        self.__process.kill()
        with self.__process:
            super().destroy_node()

    def __ask(self, question: object) -> Answer:
        self.__lines += 1
        if self.__is_readable() and (piece := self.__read()):
            raise self.__error(
                f"came before it was asked for, {_quoted(piece)}: each line answers one of its input"
            )
        self.__write(question)
        line = self.__read_line()
        if self.__is_unread():
            raise self.__error("came before it had read the line of its input that it is to answer")
        if self.__output:
            raise self.__error(
                f"is followed by more, {_quoted(bytes(self.__output))}, before that was asked for: one line answers "
                "one of its input"
            )
        return self.__decode(line)

    def __decode(self, line: bytes) -> Answer:
        try:
            answer = _ANSWERS.decode(line)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            reason = str(error).removesuffix(".")
            kinds = f"; a kind is one of {', '.join(AdaptationKind)}" if reason.endswith(".kind`") else ""
            raise self.__error(
                f"is {_quoted(line)}, which is not an answer ({reason}): expected one JSON object such as "
                f'{{"adaptations": [{{"kind": "redeploy", "node": "camera"}}]}}{kinds}'
            ) from error
        nodes = current_system().nodes
        for node in [adaptation.node for adaptation in answer.adaptations if adaptation.node not in nodes]:
            raise self.__error(
                f"names the node {shorten(repr(node), _QUOTED)}: {suggestion(node, nodes)}name one of "
                f"{', '.join(nodes)}"
            )
        return answer

    def __write(self, document: object) -> None:
        line = memoryview(json.dumps(document, allow_nan=False, separators=(",", ":")).encode() + b"\n")
        with suppress(BrokenPipeError):  # reading its answer reports how it ended
            while line:
                line = line[os.write(self.__inlet, line) :]

    def __read_line(self) -> bytes:
        """Wait for a line of the program's output, and return it without its end."""
        while (end := self.__output.find(b"\n")) < 0:
            if len(self.__output) > _LONGEST:
                raise self.__error(f"is longer than {_LONGEST} bytes: {_quoted(bytes(self.__output))}")
            piece = self.__read() if self.__has_output() else b""
            if not piece:
                raise self.__error(f"is missing: {self.__ending()}")
            self.__output += piece
        line = bytes(self.__output[:end])
        del self.__output[: end + 1]
        return line

    def __read(self) -> bytes:
        return os.read(self.__outlet, _PIECE)

    def __has_output(self) -> bool:
        """Wait for output or its end; return False if the program has ended and its child keeps the output open."""
        while not self.__is_readable(_LOOK_S):
            if self.__process.poll() is not None:
                return self.__is_readable()
        return True

    def __is_readable(self, limit_s: float = 0) -> bool:
        return bool(select.select([self.__outlet], [], [], limit_s)[0])

    def __is_unread(self) -> bool:
        """Return whether the program has not read all of its input, as far as the system knows."""
        try:
            waiting = fcntl.ioctl(self.__inlet, termios.FIONREAD, b"\0\0\0\0")
        except OSError:
            return False
        return any(waiting)

    def __ending(self) -> str:
        try:
            code = self.__process.wait(_PARTING_S)
        except subprocess.TimeoutExpired:
            how = "it closed its output"
        else:
            how = f"it ended with exit code {code}" if code >= 0 else f"it was ended by signal {-code}"
        return f"{how} in the middle of {_quoted(bytes(self.__output))}" if self.__output else how

    def __error(self, problem: str) -> ManagerError:
        return ManagerError(f"Its program broke the protocol: line {self.__lines} of its output {problem}.")


def _quoted(output: bytes) -> str:
    return repr(shorten(output[: 4 * _QUOTED].decode("utf-8", "backslashreplace"), _QUOTED))
