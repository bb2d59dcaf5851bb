"""What the two ends of the pipe say to each other, and how it travels.

The simulation speaks first, and after that they take turns: a frame is a number of bytes, the number of 4 bytes before
it. What it sends is a list of `Order`s: the last one gives the turn, and before it come calls that have waited for it.
What the managing side sends is a list of `Statement`s, of which the last one, and no other, gives the turn back: it is
`Done`, `Raised` or a question. Nothing of it is trusted: it is decoded into these structs, strictly, and messages are
CDR.
"""

import socket
import time
from collections.abc import Callable
from typing import Final, TypeAlias

from msgspec import DecodeError, Struct, ValidationError
from msgspec.msgpack import Decoder, Encoder

from sunset.common.errors import MiddlewareError
from sunset.rmw.core.port import EndpointKind
from sunset.rmw.core.qos import QoSProfile

LONGEST: Final = 64 << 20
"""Bytes of a frame."""

_HEADER: Final = 4
_CHUNK: Final = 1 << 16


class Call(Struct, array_like=True, tag=0, frozen=True):
    """Run a handler.

    Attributes:
        handler: its number; 0 is the program of the process.
        now_ns: the time.
        numbers: of a request, its client and sequence number; of a response, its sequence number.
        body: the message, if there is one.
    """

    handler: int
    now_ns: int
    numbers: tuple[int, ...] = ()
    body: bytes = b""


class Check(Struct, array_like=True, tag=1, frozen=True):
    """Evaluate the predicate that the managing side waits for."""

    now_ns: int


class Endpoint(Struct, array_like=True, frozen=True):
    """An endpoint of the graph, as `EndpointInfo`."""

    kind: EndpointKind
    name: str
    type_name: str
    node_name: str
    node_namespace: str
    qos: QoSProfile
    gid: bytes


class Answer(Struct, array_like=True, tag=2, frozen=True):
    """The answer to a question.

    Attributes:
        now_ns: the time.
        value: what was asked for,
        nodes: where that is nodes, and
        endpoints: where it is endpoints.
        error: why there is none; empty if there is.
        raised: the node and the name of the callback of this process that raised, if that is the reason.
    """

    now_ns: int
    value: bool | int = False
    nodes: list[tuple[str, str]] = []
    endpoints: list[Endpoint] = []
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
    """Which nodes are there?"""


class AskEndpoints(Struct, array_like=True, tag=17, frozen=True):
    """Which endpoints are there, on any topic or service or on one of this name?"""

    name: str | None


class AskMatched(Struct, array_like=True, tag=18, frozen=True):
    """How many endpoints does a publisher or subscription exchange messages with?"""

    number: int


class AskWanted(Struct, array_like=True, tag=19, frozen=True):
    """Would anybody get what a publisher sends?"""

    number: int


class AskReady(Struct, array_like=True, tag=20, frozen=True):
    """Is there a server for a client?"""

    number: int


Order: TypeAlias = Call | Check | Answer
"""What the simulation sends."""

Question: TypeAlias = Spin | Wait | AskNodes | AskEndpoints | AskMatched | AskWanted | AskReady
"""What the simulation answers."""

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
"""What needs no answer: where it cannot be done, the managing side knows."""

Statement: TypeAlias = Change | Done | Raised | Question

_encode = Encoder().encode
_decode_orders: Callable[[bytes], list[Order]] = Decoder(list[Order]).decode
_decode_statements: Callable[[bytes], list[Statement]] = Decoder(list[Statement]).decode


class PipeError(MiddlewareError):
    """The other end of the pipe is gone, is silent, or sends what is not of the protocol; the end of a sentence."""


class EndError(PipeError):
    """The other end is closed."""


class RaisedError(PipeError):
    """The other end's program has raised what it does not catch."""


class SilenceError(PipeError):
    """The other end did not answer in time."""


class Pipe:
    """One end of the pipe.

    Args:
        door: a connected stream.
        wait: waits for so many seconds until something comes on it, and returns whether it does; None to just wait.
    """

    def __init__(self, door: socket.socket, wait: Callable[[float | None], bool] | None = None) -> None:
        self._door = door
        self._wait = wait
        self._rest = bytearray()

    def close(self) -> None:
        """Let the other end know that nothing more comes."""
        self._door.close()

    def send(self, body: bytes, end_s: float | None = None) -> None:
        """Send a frame.

        Args:
            body: its bytes.
            end_s: until when it may take, by the clock `time.monotonic`; for ever if it is None.

        Raises:
            PipeError: it is too long; as an `EndError` or `SilenceError`, the other end does not take it.
        """
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
        """Return the next frame; `end_s` as of `send`.

        Raises:
            PipeError: what comes is not a frame; as an `EndError` or `SilenceError`, none comes.
        """
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


def write_orders(orders: list[Order]) -> bytes:
    """Return what the simulation sends, as bytes."""
    return _encode(orders)


def read_orders(body: bytes) -> list[Order]:
    """Return what the simulation sent."""
    return _decode_orders(body)


def write_statements(statements: list[Statement]) -> bytes:
    """Return what the managing side sends, as bytes."""
    return _encode(statements)


def read_statements(body: bytes) -> list[Statement]:
    """Return what the managing side sent.

    Raises:
        PipeError: it is not of the protocol.
    """
    try:
        return _decode_statements(body)
    except (ValidationError, DecodeError, MiddlewareError, RecursionError) as error:
        raise PipeError(f"sent what is not of the protocol: {error}") from error
