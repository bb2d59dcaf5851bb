"""The protocol of the pipe between a gateway and its remote process.

They take turns, and the gateway begins. A frame is its length, in 4 bytes, and its content. The gateway sends a list
of `Order`s: calls that have waited, and the order that gives the turn. The remote process sends a list of `Statement`s,
the last of which gives the turn back: `Done`, `Raised` or a question. Statements are not trusted: they are decoded
into these structs, strictly, and messages are CDR. The process itself is number 0; the others are made by statements.
"""

import socket
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final, Literal, TypeAlias

from msgspec import DecodeError, Struct
from msgspec.msgpack import Decoder, Encoder

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind, RequestId
from sunset_ros.rmw.core.qos import QoSProfile

_LONGEST: Final = 64 << 20
"""Bytes of a frame."""

_HEADER: Final = 4

_Sending: TypeAlias = Literal["publish", "send_request", "send_response"]
_Changing: TypeAlias = Literal[
    "attach", "cancel", "defer", "destroy", "detach", "reset", "set_period_ns", "shutdown"
]


class _Part(Struct, array_like=True, tag=True):
    """An order or a statement."""


class Call(_Part):
    """Run a handler, of which 0 is the program of the process, with the message in `body`, if there is any.

    `ids` has the id of a request, or the number of a response.
    """

    handler: int
    now_ns: int
    ids: tuple[RequestId | int, ...] = ()
    body: bytes = b""


class Answer(_Part):
    """The answer to a question: a value, nodes, endpoints, or in `error` the reason why there is none."""

    now_ns: int
    value: bool | int = False
    nodes: list[tuple[str, str]] = []
    endpoints: list[EndpointInfo] = []
    error: str = ""


class MakeNode(_Part):
    """Enter the graph with a node."""

    number: int
    name: str
    namespace: str


class MakeEndpoint(_Part):
    """Make an endpoint of a node."""

    number: int
    node: int
    kind: EndpointKind
    type_name: str
    name: str
    qos: QoSProfile
    label: str


class MakeTimer(_Part):
    """Make a timer of a node, or let a handler be called once if the period is None."""

    number: int
    node: int
    period_ns: int | None
    label: str


class Act(_Part):
    """Call a method, whose arguments follow; `defer` lets calls of a subscription's handler wait for the next turn."""

    number: int
    verb: _Sending | _Changing
    argument: RequestId | int | None = None
    body: bytes | None = None


class Done(_Part):
    """The handler has returned; the value is the truth of its result."""

    value: bool = False


class Raised(_Part):
    """The handler has raised; the reason is the end of a sentence."""

    reason: str


class Wait(_Part):
    """Wait until a handler returns True, which the gateway calls for it; if it is None, for a callback."""

    handler: int | None
    timeout_ns: int | None


class Ask(_Part):
    """Ask for a property of an endpoint, or for the graph: all of it, or the endpoints of a topic or service."""

    number: int
    about: Literal["matched", "wanted", "server_ready", "nodes", "endpoints"]
    name: str | None = None


Order: TypeAlias = Call | Answer
Question: TypeAlias = Wait | Ask
Change: TypeAlias = MakeNode | MakeEndpoint | MakeTimer | Act
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

    def close(self) -> None:
        """Close this end."""
        self._door.close()

    @contextmanager
    def _until(self, end_s: float | None, late: str) -> Iterator[None]:
        """Use the stream until `end_s` at the latest; raise a `PipeError` afterwards, or if it is closed."""
        if end_s is not None:
            self._door.settimeout(max(end_s - time.monotonic(), 0.001))
        try:
            yield
        except TimeoutError as error:
            raise SilenceError(late) from error
        except OSError as error:
            raise EndError("is gone") from error

    def send(self, body: bytes, end_s: float | None = None) -> None:
        """Send a frame, until `end_s` of the clock `time.monotonic` at the latest."""
        with self._until(end_s, "does not read"):
            self._door.sendall(len(body).to_bytes(_HEADER, "little") + body)

    def receive(self, end_s: float | None = None) -> bytes:
        """Return the next frame; see `send` for `end_s`."""
        size = int.from_bytes(self._read(_HEADER, end_s), "little")
        if size > _LONGEST:
            raise PipeError(f"sent {size} bytes at once, where {_LONGEST} are the most")
        return self._read(size, end_s)

    def _read(self, size: int, end_s: float | None) -> bytes:
        data = bytearray()
        while len(data) < size:
            if self._wait is not None and not self._wait(None if end_s is None else end_s - time.monotonic()):
                late = end_s is not None and time.monotonic() >= end_s
                raise SilenceError("did not answer") if late else EndError("is gone")
            with self._until(end_s, "did not answer"):
                chunk = self._door.recv(size - len(data))
            if not chunk:
                raise EndError("is gone")
            data += chunk
        return bytes(data)


def read_statements(body: bytes) -> list[Statement]:
    """Decode the content of a frame of the remote process."""
    try:
        return _decode_statements(body)
    except (DecodeError, MiddlewareError, RecursionError) as error:
        raise PipeError(f"sent what is not of the protocol: {error}") from error
