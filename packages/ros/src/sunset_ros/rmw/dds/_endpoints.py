"""The parts of nodes on DDS: endpoints, compatible with `rmw_cyclonedds`, and timers.

Requests and responses are samples on two topics, and begin with the client's id and running number. All clients of a
service receive all responses, and drop responses to other clients. Endpoints are volatile, so a server delays a
response until the client's reader is connected.
"""

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from functools import partial
from struct import Struct
from typing import ClassVar, Final

from sunset_ros.errors import InterfaceError
from sunset_ros.interfaces import Message, deserialize, serialize
from sunset_ros.rmw.core.node import (
    ClientHandle,
    Parts,
    PublisherHandle,
    ServiceHandle,
    SubscriptionHandle,
    Timer,
)
from sunset_ros.rmw.core.port import CallbackError, EndpointKind, RequestId
from sunset_ros.rmw.core.qos import DurabilityPolicy, ReliabilityPolicy
from sunset_ros.rmw.dds import _library as dds
from sunset_ros.rmw.dds import _wheel as wheel
from sunset_ros.rmw.dds._config import read_configuration
from sunset_ros.rmw.dds._graph import parse_user_data, topic_name, topic_names_of_service
from sunset_ros.rmw.dds._process import DdsEndpoint, DdsEntity, DdsProcess

_HEADER: Final = Struct("<Qq")
_ENCAPSULATION_SIZE: Final = 4
_FIELDS: Final = _ENCAPSULATION_SIZE + _HEADER.size
_LATE_NS: Final = 10_000_000_000
"""How long a response waits for the client's reader, since a busy machine connects late."""
_LATE_STEP_NS: Final = 2_000_000
_LATE: Final = 20
"""The most responses of a server that wait."""


def split_sample(payload: bytes) -> tuple[RequestId, bytes]:
    """Return the header of a request or response, and the payload of its message."""
    if len(payload) < _FIELDS:
        raise InterfaceError(f"A payload of {len(payload)} bytes has no header of a request or response.")
    header = RequestId(*_HEADER.unpack_from(payload, _ENCAPSULATION_SIZE))
    return header, payload[:_ENCAPSULATION_SIZE] + payload[_FIELDS:]


class _Writing(DdsEndpoint):
    """An endpoint with a DDS writer."""

    def write_to(self, topic: str, user_data: str = "") -> None:
        """Make the writer."""
        with self.process.undisturbed():
            self._writer = self.process.link.create_writer(topic, self.sent, self.qos, user_data)
        self.writers = (dds.guid_of(self._writer),)

    def reliable_writers(self) -> tuple[int, ...]:
        return (self._writer,) if self.qos.reliability is ReliabilityPolicy.RELIABLE else ()

    def retire(self) -> None:
        super().retire()
        dds.delete(self._writer)


class _Reading(DdsEndpoint, DdsEntity):
    """An endpoint with a DDS reader; samples wait in the reader, which drops the oldest beyond its depth."""

    def read_from(self, topic: str, user_data: str = "") -> None:
        """Make the reader."""
        with self.process.undisturbed():
            self._reader = self.process.link.create_reader(topic, self.received, self.qos, user_data)
        self.readers = (dds.guid_of(self._reader),)

    def join(self) -> None:
        self._number = self.process.link.waitset.add(self._reader)
        self.process.readers[self._number] = self
        super().join()
        self.process.link.waitset.watch(self._number)

    def take_turn(self) -> bool:
        sample = wheel.take(self._reader)
        if sample is None:
            self.process.link.waitset.watch(self._number)
            return False
        self.process.queue.put(self)  # other entities take their turn before its next sample
        payload, writer, _ = sample
        try:
            return self.handle(payload, writer)
        except InterfaceError as error:
            self.process.report(self.name, f"dropped a malformed message: {error}", self.node)
            return False

    @abstractmethod
    def handle(self, payload: bytes, writer: int) -> bool:
        """Handle the payload of a sample; return whether a callback ran."""

    def retire(self) -> None:
        self.process.link.waitset.forget(self._number)
        self.process.readers.pop(self._number, None)
        super().retire()
        dds.delete(self._reader)


class DdsPublisher(_Writing, PublisherHandle):
    """Sends samples; it blocks only while it keeps all samples and a reader confirms none."""

    def open(self) -> None:
        self.write_to(topic_name(self.name))

    def publish(self, message: Message) -> None:
        if not self.alive:
            self.check_alive(f"publish on {self.name}")
        wheel.write(self._writer, serialize(message), self.name)

    @property
    def wanted(self) -> bool:
        is_kept = self.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        return self.alive and (is_kept or self.matched > 0)

    @property
    def matched(self) -> int:
        return len(dds.matched_subscriptions(self._writer)) if self.alive else 0


class DdsSubscription(_Reading, SubscriptionHandle):
    """Receives samples."""

    def open(self) -> None:
        self.read_from(topic_name(self.name))

    def handle(self, payload: bytes, writer: int) -> bool:
        del writer
        self.process.call(self, self.handler, deserialize(payload, self.received))
        return True

    @property
    def matched(self) -> int:
        return len(dds.matched_publications(self._reader)) if self.alive else 0


class _ServiceEnd(_Reading, _Writing):
    """A client or server: a writer and a reader with a common id, under a key in their user data."""

    id_key: ClassVar[str]

    def open(self) -> None:
        super().open()
        own_id = f"{self.id_key}={self.process.new_endpoint_id()};"
        written, read = topic_names_of_service(self.name)
        if self.kind is EndpointKind.SERVICE:
            written, read = read, written
        self.write_to(written, own_id)
        self.read_from(read, own_id)

    def send_sample(self, request_id: RequestId, payload: bytes) -> None:
        """Send a request or response with its header."""
        header = _HEADER.pack(*request_id)
        sample = payload[:_ENCAPSULATION_SIZE] + header + payload[_ENCAPSULATION_SIZE:]
        wheel.write(self._writer, sample, self.name)

    def listeners(self, id_key: str) -> set[str]:
        """Return the ids of the readers that are connected to the writer; an empty id for those without."""
        handles = dds.matched_subscriptions(self._writer)
        return _ids((wheel.matched_subscription(self._writer, handle) for handle in handles), id_key)


def _ids(ends: Iterable[wheel.Endpoint | None], id_key: str) -> set[str]:
    return {parse_user_data(end.user_data).get(id_key, "") for end in ends if end is not None}


class DdsClient(_ServiceEnd, ClientHandle):
    """Sends requests, and receives responses."""

    id_key = "clientid"

    def open(self) -> None:
        super().open()
        self._id = dds.instance_handle_of(self._writer)

    def send(self, number: int, request: Message, payload: bytes) -> None:
        del request
        self.send_sample(RequestId(self._id, number), payload)

    def handle(self, payload: bytes, writer: int) -> bool:
        del writer
        request_id, response = split_sample(payload)
        if request_id.client != self._id:
            return False
        message = deserialize(response, self.received)
        self.process.call(self, self.handler, request_id.sequence, message)
        return True

    def server_ready(self) -> bool:
        """Return whether the reader and the writer of a server are connected to this client."""
        if not self.alive:
            return False
        with self.process.undisturbed():
            asked = self.listeners("serviceid")
            handles = dds.matched_publications(self._reader)
            ends = (wheel.matched_publication(self._reader, handle) for handle in handles)
            answering = _ids(ends, "serviceid")
        anonymous = "" in asked | answering
        return bool(asked & answering) or (anonymous and bool(asked and answering))


class DdsService(_ServiceEnd, ServiceHandle):
    """Receives requests, and sends responses."""

    id_key = "serviceid"

    def open(self) -> None:
        super().open()
        self._heard: set[int] = set()
        self._late: list[tuple[int, RequestId, bytes, int]] = []
        self._late_timer: DdsTimer | None = None

    def handle(self, payload: bytes, writer: int) -> bool:
        request_id, request = split_sample(payload)
        if request_id in self.asked:
            return False
        message = deserialize(request, self.received)
        self.asked[request_id] = partial(self._answer, writer, request_id)
        try:
            self.process.call(self, self.handler, request_id, message)
        except CallbackError:
            self.asked.pop(request_id, None)  # without a response
            raise
        return True

    def _answer(self, writer: int, request_id: RequestId, response: Message, payload: bytes) -> None:
        """Send a response, as soon as the client's reader is connected."""
        del response
        self._late.append((writer, request_id, payload, self.process.steady_ns() + _LATE_NS))
        self._send_late()
        if self._late and self._late_timer is None:
            self._late_timer = DdsTimer(self.node, _LATE_STEP_NS, self._send_late, f"{self.label}, late")

    def _hears(self, writer: int) -> bool | None:
        """Return whether a client's reader is connected; None if the client has left."""
        client = wheel.matched_publication(self._reader, writer)
        if client is None:
            return None
        (client_id,) = _ids([client], "clientid")
        return not client_id or client_id in self.listeners("clientid")

    def settle(self) -> bool:
        self._send_late()
        return not self._late

    def _send_late(self) -> None:
        """Send responses to connected clients; drop responses to clients that have left, or wait too long."""
        waiting, self._late = self._late, []
        for late in waiting:
            writer, request_id, payload, limit_ns = late
            heard = writer in self._heard or self._hears(writer)
            if heard:
                self._heard.add(writer)
                self.send_sample(request_id, payload)
            elif heard is False and self.process.steady_ns() < limit_ns and len(self._late) < _LATE:
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


class DdsTimer(DdsEntity, Timer):
    """A timer of the monotonic clock."""

    def set_alarm(self, due_ns: int | None) -> None:
        if due_ns is None:
            self.process.alarms.pop(self, None)
        else:
            self.process.alarms[self] = due_ns

    def take_turn(self) -> bool:
        if self.canceled or self in self.process.alarms:  # it was reset meanwhile
            return False
        self.process.call(self, self.run)
        return True


class CycloneDDS(DdsProcess):
    """A process on DDS, to be given to `Context.init(middleware=…)`.

    Args:
        domain_id: the domain, 0 to 232; ROS_DOMAIN_ID, else 0, if None.
        network: whether to communicate beyond this computer.
        distro: the ROS 2 distribution of other nodes, such as "jazzy" or "humble", which decides the form of
            announcements; None to begin with the form of ROS_DISTRO, and adapt to other nodes.
        environment: has ROS_DOMAIN_ID, ROS_LOCALHOST_ONLY, ROS_AUTOMATIC_DISCOVERY_RANGE, ROS_DISTRO and
            CYCLONEDDS_URI; `os.environ` if None.

    Attributes:
        domain_id: the domain.
        problems: topic, service or node → number of samples that could not be used.

    Raises:
        MiddlewareError: a setting cannot be used, or the domain cannot be entered.
    """

    parts = Parts(DdsPublisher, DdsSubscription, DdsClient, DdsService, DdsTimer)

    def __init__(
        self,
        *,
        domain_id: int | None = None,
        network: bool = False,
        distro: str | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        super().__init__(read_configuration(environment, domain_id=domain_id, network=network, distro=distro))

    def __repr__(self) -> str:
        return f"<CycloneDDS domain {self.domain_id} {'alive' if self.alive else 'ended'}>"
