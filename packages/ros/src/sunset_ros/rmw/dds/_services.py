"""Clients and servers of services on DDS, compatible with `rmw_cyclonedds`.

Requests and responses are samples on two topics, and begin with the client's id and running number. All clients of a
service receive all responses, and drop responses to other clients. Endpoints are volatile, so a server delays a
response until the client's reader is connected.
"""

import threading
from itertools import count
from struct import Struct
from typing import ClassVar, Final, NamedTuple

from sunset_ros.errors import InterfaceError, MiddlewareError
from sunset_ros.interfaces import Message, Service, deserialize, serialize
from sunset_ros.rmw.core.port import CallbackError, ClientHandle, RequestId, ServiceHandle
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.dds import _library as dds
from sunset_ros.rmw.dds import _wheel as wheel
from sunset_ros.rmw.dds._entity import DdsTimer, ReadingEntity
from sunset_ros.rmw.dds._names import parse_user_data, topic_names_of_service

_HEADER: Final = Struct("<Qq")
_ENCAPSULATION_SIZE: Final = 4
_FIELDS: Final = _ENCAPSULATION_SIZE + _HEADER.size
_PATIENCE_NS: Final = 100_000_000
"""How long a server blocks for a client's reader, as `rmw_cyclonedds` does."""
_STEP_S: Final = 0.001
_LATE_NS: Final = 10_000_000_000
"""How long a response waits for a reader after that, since a busy machine connects late."""
_LATE_STEP_NS: Final = 20_000_000
_LATE: Final = 20
"""The most responses of a server that wait."""
_REMEMBERED: Final = 1000
"""The most requests without a response, and clients with a known connection, of a server."""


def _sample(client: int, number: int, message: Message) -> bytes:
    """Return the payload of a request or response with the header."""
    payload = serialize(message)
    return payload[:_ENCAPSULATION_SIZE] + _HEADER.pack(client, number) + payload[_ENCAPSULATION_SIZE:]


def split_sample(payload: bytes) -> tuple[RequestId, bytes]:
    """Return the header of a request or response, and the payload of its message."""
    if len(payload) < _FIELDS:
        raise InterfaceError(f"A payload of {len(payload)} bytes has no header of a request or response.")
    header = RequestId(*_HEADER.unpack_from(payload, _ENCAPSULATION_SIZE))
    return header, payload[:_ENCAPSULATION_SIZE] + payload[_FIELDS:]


class _ServiceEnd(ReadingEntity[Service]):
    """A client or server: a writer and a reader with a common id.

    Attributes:
        id_name: the key of the id in their user data.
        answers: whether it is a server, which reads requests and writes responses.
    """

    id_name: ClassVar[str]
    answers: ClassVar[bool]

    def open(self, ros_type: type[Service], qos: QoSProfile) -> None:
        own_id = f"{self.id_name}={self.process.new_endpoint_id()};"
        ends = zip(topic_names_of_service(self.name), (ros_type.Request, ros_type.Response), strict=True)
        (written, sent), (read, self._kind) = reversed(list(ends)) if self.answers else ends
        with self.process.undisturbed():
            self._writer = self.process.link.create_writer(written, sent, qos, own_id)
            reader = self.process.link.create_reader(read, self._kind, qos, own_id)
        self.readers, self.writers = (dds.guid_of(reader),), (dds.guid_of(self._writer),)
        self.listen_to(reader)

    def send(self, sample: bytes) -> None:
        """Send a request or response."""
        wheel.write(self._writer, sample, self.name)

    def reliable_writers(self) -> tuple[int, ...]:
        return (self._writer,)

    def retire(self) -> None:
        super().retire()
        dds.delete(self._writer)


class DdsClient(_ServiceEnd, ClientHandle):
    """Sends requests, and receives responses."""

    id_name = "clientid"
    answers = False

    def open(self, ros_type: type[Service], qos: QoSProfile) -> None:
        super().open(ros_type, qos)
        self._id = dds.instance_handle_of(self._writer)
        self._numbers = count(1)

    def send_request(self, request: Message) -> int:
        self.check_alive(f"call {self.name}")
        number = next(self._numbers)
        self.send(_sample(self._id, number, request))
        return number

    def handle(self, payload: bytes, writer: int) -> bool:
        del writer
        request_id, response = split_sample(payload)
        if request_id.client != self._id:
            return False
        self.process.call(self, self.handler, request_id.sequence, deserialize(response, self._kind))
        return True

    def server_ready(self) -> bool:
        """Return whether the reader and the writer of a server are connected to this client."""
        if not self.alive:
            return False
        with self.process.undisturbed():
            hearing = [
                wheel.matched_subscription(self._writer, each)
                for each in dds.matched_subscriptions(self._writer)
            ]
            heard = [
                wheel.matched_publication(self.reader, each) for each in dds.matched_publications(self.reader)
            ]
        asked, answering = (
            {_id_of(end, "serviceid") for end in ends if end is not None} for ends in (hearing, heard)
        )
        anonymous = "" in asked | answering
        return bool(asked & answering) or (anonymous and bool(asked and answering))


def _id_of(end: wheel.Endpoint, name: str) -> str:
    return parse_user_data(end.user_data).get(name, "")


class _LateResponse(NamedTuple):
    """A response to a client without a connected reader."""

    writer: int
    sample: bytes
    limit_ns: int


class DdsService(_ServiceEnd, ServiceHandle):
    """Receives requests, and sends responses."""

    id_name = "serviceid"
    answers = True

    def open(self, ros_type: type[Service], qos: QoSProfile) -> None:
        self._asked: dict[RequestId, int] = {}
        self._heard: dict[int, bool] = {}
        self._late: list[_LateResponse] = []
        self._late_timer: DdsTimer | None = None
        super().open(ros_type, qos)

    def handle(self, payload: bytes, writer: int) -> bool:
        request_id, request = split_sample(payload)
        if request_id in self._asked:
            return False
        if len(self._asked) >= _REMEMBERED:
            self.process.report(self.name, "dropped a request: too many wait for their response.", self.node)
            return False
        message = deserialize(request, self._kind)
        self._asked[request_id] = writer
        try:
            self.process.call(self, self.handler, request_id, message)
        except CallbackError:
            self._asked.pop(request_id, None)  # without a response
            raise
        return True

    def send_response(self, request_id: RequestId, response: Message) -> None:
        self.check_alive(f"answer on {self.name}")
        writer = self._asked.pop(request_id, None)
        if writer is None:
            raise MiddlewareError(f"Service {self.name} has no request {tuple(request_id)} to answer.")
        sample = _sample(*request_id, response)
        if self._is_heard_by(writer):
            self.send(sample)
        else:
            self._late.append(_LateResponse(writer, sample, self.process.steady_ns() + _LATE_NS))
            if self._late_timer is None:
                self._late_timer = DdsTimer(
                    self.process, self.node, _LATE_STEP_NS, self._send_late, f"{self.label}, late"
                )

    def _is_heard_by(self, writer: int) -> bool:
        """Return whether a client's reader is connected; wait for its first connection."""
        if self._heard.get(writer):
            return True
        heard = self._hears(writer)
        if heard is False and writer not in self._heard:
            end_ns = self.process.steady_ns() + _PATIENCE_NS
            pause = threading.Event()
            while heard is False and self.process.steady_ns() < end_ns:
                pause.wait(_STEP_S)
                heard = self._hears(writer)
        if len(self._heard) >= _REMEMBERED:
            self._heard.clear()
        self._heard[writer] = heard is True
        return heard is True

    def _hears(self, writer: int) -> bool | None:
        """Return whether a client's reader is connected; None if the client has left."""
        request_writer = wheel.matched_publication(self.reader, writer)
        if request_writer is None:
            return None
        client = _id_of(request_writer, "clientid")
        readers = (
            wheel.matched_subscription(self._writer, each) for each in dds.matched_subscriptions(self._writer)
        )
        return not client or any(
            reader is not None and _id_of(reader, "clientid") == client for reader in readers
        )

    def settle(self) -> bool:
        self._send_late()
        return not self._late

    def _send_late(self) -> None:
        """Send late responses to connected clients; drop responses to clients that have left, or wait too long."""
        waiting, self._late = self._late, []
        for late in waiting:
            heard = self._hears(late.writer)
            if heard:
                self._heard[late.writer] = True
                self.send(late.sample)
            elif heard is False and self.process.steady_ns() < late.limit_ns and len(self._late) < _LATE:
                self._late.append(late)
            elif heard is False:
                self.process.report(self.name, "did not answer a client that does not listen.", self.node)
        if not self._late and self._late_timer is not None:
            self._late_timer.destroy()
            self._late_timer = None

    def retire(self) -> None:
        if self._late_timer is not None:
            self._late_timer.destroy()
        super().retire()
