"""The protocol of the pipe between a gateway and its remote process.

They take turns, and the gateway begins. A frame is its length, in 4 bytes, and its content. The gateway sends a list
of `Order`s: calls that have waited, and the order that gives the turn. The remote process sends a list of `Statement`s,
the last of which gives the turn back: `Done`, `Raised` or a question. Statements are not trusted: they are decoded
into these structs, strictly, and messages are CDR.
"""

import socket
import time
from collections.abc import Callable, Sequence
from typing import Final, TypeAlias

from msgspec import DecodeError, Struct, ValidationError
from msgspec.msgpack import Decoder, Encoder

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind
from sunset_ros.rmw.core.qos import QoSProfile

LONGEST: Final = 64 << 20
"""Bytes of a frame."""

_HEADER: Final = 4
_CHUNK: Final = 1 << 16


class Call(Struct, array_like=True, tag=0, frozen=True):
    """Run a handler.

    Attributes:
        handler: its number; 0 is the program of the process.
        now_ns: the time.
        numbers: client and sequence number of a request, or the sequence number of a response.
        body: the message, if there is any.
    """

    handler: int
    now_ns: int
    numbers: tuple[int, ...] = ()
    body: bytes = b""


class Check(Struct, array_like=True, tag=1, frozen=True):
    """Evaluate the predicate that the remote process waits for."""

    now_ns: int


class Answer(Struct, array_like=True, tag=2, frozen=True):
    """The answer to a question.

    Attributes:
        now_ns: the time.
        value: a number or a truth value.
        nodes: the nodes of the graph.
        endpoints: the endpoints of the graph.
        error: the reason why there is no answer; empty if there is an answer.
        raised: node and name of the callback of the remote process that raised, if it did.
    """

    now_ns: int
    value: bool | int = False
    nodes: list[tuple[str, str]] = []
    endpoints: list[EndpointInfo] = []
    error: str = ""
    raised: tuple[str, str] | None = None


class MakeNode(Struct, array_like=True, tag=0, frozen=True):
    """Enter the graph with a node."""

    number: int
    name: str
    namespace: str


class MakeEndpoint(Struct, array_like=True, tag=1, frozen=True):
    """Make an endpoint of a node."""

    number: int
    node: int
    kind: EndpointKind
    type_name: str
    name: str
    qos: QoSProfile
    label: str


class MakeTimer(Struct, array_like=True, tag=2, frozen=True):
    """Make a timer of a node."""

    number: int
    node: int
    period_ns: int
    label: str


class Post(Struct, array_like=True, tag=3, frozen=True):
    """Let a handler be called once, as a callback of a node."""

    number: int
    node: int
    label: str


class Publish(Struct, array_like=True, tag=4, frozen=True):
    """Send a message from a publisher, or a request from a client."""

    number: int
    body: bytes


class Respond(Struct, array_like=True, tag=5, frozen=True):
    """Answer a request."""

    number: int
    client: int
    sequence: int
    body: bytes


class SetPeriod(Struct, array_like=True, tag=6, frozen=True):
    """Change the period of a timer."""

    number: int
    period_ns: int


class Reset(Struct, array_like=True, tag=7, frozen=True):
    """Start a timer again."""

    number: int


class Cancel(Struct, array_like=True, tag=8, frozen=True):
    """Stop a timer."""

    number: int


class Destroy(Struct, array_like=True, tag=9, frozen=True):
    """Take a node, an endpoint or a timer off the graph."""

    number: int


class Attach(Struct, array_like=True, tag=10, frozen=True):
    """Let the callbacks of a node run, or hold them back."""

    number: int
    attached: bool


class Shutdown(Struct, array_like=True, tag=11, frozen=True):
    """Leave the network."""


class Defer(Struct, array_like=True, tag=21, frozen=True):
    """Let the calls of a subscription's handler wait for the next turn, which saves one for each message."""

    number: int


class Done(Struct, array_like=True, tag=12, frozen=True):
    """The handler has returned, or the predicate has this value."""

    value: bool = False


class Raised(Struct, array_like=True, tag=13, frozen=True):
    """The handler has raised; the reason is the end of a sentence."""

    reason: str


class Spin(Struct, array_like=True, tag=14, frozen=True):
    """Wait for a callback of the process."""

    timeout_ns: int | None


class Wait(Struct, array_like=True, tag=15, frozen=True):
    """Wait for a predicate, which the simulation asks for by `Check`."""

    timeout_ns: int | None


class AskNodes(Struct, array_like=True, tag=16, frozen=True):
    """Ask for the nodes of the graph."""


class AskEndpoints(Struct, array_like=True, tag=17, frozen=True):
    """Ask for all endpoints of the graph, or the endpoints of a topic or service."""

    name: str | None


class AskMatched(Struct, array_like=True, tag=18, frozen=True):
    """Ask for the number of endpoints that a publisher or subscription is connected to."""

    number: int


class AskWanted(Struct, array_like=True, tag=19, frozen=True):
    """Ask whether messages of a publisher are wanted."""

    number: int


class AskReady(Struct, array_like=True, tag=20, frozen=True):
    """Ask whether a client has a server."""

    number: int


Order: TypeAlias = Call | Check | Answer

Question: TypeAlias = Spin | Wait | AskNodes | AskEndpoints | AskMatched | AskWanted | AskReady

Change: TypeAlias = (
    MakeNode
    | MakeEndpoint
    | MakeTimer
    | Post
    | Publish
    | Respond
    | SetPeriod
    | Reset
    | Cancel
    | Destroy
    | Attach
    | Shutdown
    | Defer
)

Statement: TypeAlias = Change | Done | Raised | Question

encode: Callable[[Sequence[Order | Statement]], bytes] = Encoder().encode
decode_orders: Callable[[bytes], list[Order]] = Decoder(list[Order]).decode
_decode_statements: Callable[[bytes], list[Statement]] = Decoder(list[Statement]).decode


class PipeError(MiddlewareError):
    """The other end has failed; the text is the end of a sentence."""


class EndError(PipeError):
    """The other end is closed."""


class RaisedError(PipeError):
    """The program at the other end has raised an exception."""


class SilenceError(PipeError):
    """The other end did not answer in time."""


class Pipe:
    """One end of the pipe.

    Args:
        door: a connected stream.
        wait: waits for some seconds until the stream has data, and returns whether it has; None to just wait.
    """

    def __init__(self, door: socket.socket, wait: Callable[[float | None], bool] | None = None) -> None:
        self._door = door
        self._wait = wait
        self._rest = bytearray()

    def close(self) -> None:
        """Close this end."""
        self._door.close()

    def send(self, body: bytes, end_s: float | None = None) -> None:
        """Send a frame, until `end_s` of the clock `time.monotonic` at the latest."""
        if len(body) > LONGEST:
            raise PipeError(f"cannot be sent {len(body)} bytes at once, only {LONGEST}")
        self._limit(end_s)
        try:
            self._door.sendall(len(body).to_bytes(_HEADER, "little") + body)
        except TimeoutError as error:
            raise SilenceError("does not read") from error
        except OSError as error:
            raise EndError("is gone") from error

    def receive(self, end_s: float | None = None) -> bytes:
        """Return the next frame; see `send` for `end_s`."""
        rest = self._rest
        self._fill(_HEADER, end_s)
        size = int.from_bytes(rest[:_HEADER], "little")
        if size > LONGEST:
            raise PipeError(f"sent {size} bytes at once, where {LONGEST} are the most")
        self._fill(_HEADER + size, end_s)
        if len(rest) > _HEADER + size:
            raise PipeError("spoke when it was not its turn")
        body = bytes(memoryview(rest)[_HEADER:])
        rest.clear()
        return body

    def _fill(self, size: int, end_s: float | None) -> None:
        while len(self._rest) < size:
            if self._wait is not None and not self._wait(None if end_s is None else end_s - time.monotonic()):
                late = end_s is not None and time.monotonic() >= end_s
                raise SilenceError("did not answer") if late else EndError("is gone")
            self._limit(end_s)
            try:
                chunk = self._door.recv(max(_CHUNK, size - len(self._rest)))
            except TimeoutError as error:
                raise SilenceError("did not answer") from error
            except OSError as error:
                raise EndError("is gone") from error
            if not chunk:
                raise EndError("is gone")
            self._rest += chunk

    def _limit(self, end_s: float | None) -> None:
        if end_s is not None:
            self._door.settimeout(max(end_s - time.monotonic(), 0.001))


def read_statements(body: bytes) -> list[Statement]:
    """Decode the content of a frame of the remote process."""
    try:
        return _decode_statements(body)
    except (ValidationError, DecodeError, MiddlewareError, RecursionError) as error:
        raise PipeError(f"sent what is not of the protocol: {error}") from error
