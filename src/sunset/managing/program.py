"""A managing system that is a program in any language, with JSON lines on its standard input and output."""

import fcntl
import json
import math
import os
import select
import subprocess
import termios
from contextlib import suppress
from pathlib import Path
from typing import Annotated, ClassVar, Final

import msgspec
from msgspec import Meta

from sunset.errors import ManagerError
from sunset.managing.base import LONGEST_THOUGHT_S, ManagingSystem
from sunset.managing.command import Command, parse_command
from sunset.managing.symptoms import Symptoms
from sunset.system.vocabulary import AdaptationKind, Value, current_system
from sunset_ros.task import Future
from sunset_ros.texts import shorten, suggestion

_LONGEST: Final = 2**20
"""The longest line of a program's output, in bytes."""
_PIECE: Final = 2**16
_PARTING_S: Final = 10.0
"""How long a program that has closed its output may take to end, so that the error can name its exit code."""
_LOOK_S: Final = 0.1
"""The wait for output between two looks whether the program has ended."""
_QUOTED: Final = 100


class _Adaptation(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="kind"):
    node: str
    id: int | str | None = None

    def do(self, manager: ManagingSystem) -> Future[bool]:
        """Call the method with the name of this kind."""
        *given, node, _ = msgspec.structs.astuple(self)  # fields of a subclass come first
        future: Future[bool] = getattr(manager, str(self.__struct_config__.tag))(node, *given)
        return future


class _SetParameter(_Adaptation, frozen=True, tag="set_parameter"):
    name: str
    value: bool | Annotated[int, Meta(ge=-(2**63), le=2**63 - 1)] | float | str


class _ChangeTopic(_Adaptation, frozen=True, tag="change_topic"):
    name: str
    value: str


class _Activate(_Adaptation, frozen=True, tag="activate"):
    pass


class _Deactivate(_Adaptation, frozen=True, tag="deactivate"):
    pass


class _Restart(_Adaptation, frozen=True, tag="restart"):
    pass


class _Redeploy(_Adaptation, frozen=True, tag="redeploy"):
    pass


class Answer(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A line of a program's output."""

    adaptations: Annotated[
        list[_SetParameter | _ChangeTopic | _Activate | _Deactivate | _Restart | _Redeploy],
        Meta(max_length=100),
    ] = []
    diagnosis: dict[str, Annotated[float, Meta(ge=0, le=1)]] | None = None
    think_s: Annotated[float, Meta(ge=0, le=LONGEST_THOUGHT_S)] = 0.0


_ANSWERS: Final = msgspec.json.Decoder(Answer)


class Program(ManagingSystem):
    """Runs a program that decides: `adapt` writes a line to it and reads a line from it.

    Attributes:
        command: starts the program.
    """

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
                "symptoms": {name: value for name, value in symptoms.items() if not _is_absent(value)},
                "results": [{"id": name, "accepted": future.result()} for name, future in answered],
            }
        )
        self.think(answer.think_s)
        if answer.diagnosis is not None:
            self.diagnose(answer.diagnosis)
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


def load_program(spec: str, folder: Path = Path()) -> type[Program]:
    """Return the class of `exec:COMMAND`, whose relative paths begin in `folder`."""
    return type("Program", (Program,), {"command": parse_command(spec, folder), "__module__": __name__})


def _is_absent(value: Value) -> bool:
    return isinstance(value, float) and not math.isfinite(value)


def _quoted(output: bytes) -> str:
    return repr(shorten(output[: 4 * _QUOTED].decode("utf-8", "backslashreplace"), _QUOTED))
