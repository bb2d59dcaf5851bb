"""An observer of a live network, which reads all topics and services."""

import math
import threading
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from heapq import heappop, heappush
from itertools import count
from queue import Empty
from typing import Final, NamedTuple

from sunset_ros.errors import InterfaceError, MiddlewareError
from sunset_ros.interfaces import Message, deserialize, get_message, get_service
from sunset_ros.rmw.core.live import LiveObserver
from sunset_ros.rmw.core.port import EndpointKind, RequestId, qualified_name
from sunset_ros.rmw.core.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    incompatibility,
)
from sunset_ros.rmw.core.tap import Tap
from sunset_ros.rmw.dds import _wheel as wheel
from sunset_ros.rmw.dds._config import read_configuration
from sunset_ros.rmw.dds._endpoints import split_sample
from sunset_ros.rmw.dds._graph import (
    OBSERVER,
    Graph,
    Participant,
    RosName,
    parse_user_data,
    ros_name,
    topic_name,
    topic_names_of_service,
)
from sunset_ros.rmw.dds._link import Link, WaitingLine

_HOLD_NS: Final = 100_000_000
"""How long a sample waits for samples that were sent earlier and come later."""

_PATIENCE_NS: Final = 3_000_000_000
"""How long a sample waits for the announcement of its node, and a response for its request."""

_LATEST_NS: Final = 1_000_000_000
"""The longest delivery; an earlier or future time of sending is replaced."""

_STEP_S: Final = 0.02
_SERVICE_QOS = QoSProfile(history=HistoryPolicy.KEEP_ALL)


class _Channel(NamedTuple):
    """A reader of the observer for a topic, or for the requests or responses of a service.

    Attributes:
        writers: the kind of its writers: publishers, clients (of requests) or services (of responses).
    """

    reader: int
    writers: EndpointKind
    name: str
    message: type[Message]
    qos: QoSProfile


class _Channels:
    """The readers of an observer's participant, which keep all samples until they are taken.

    Attributes:
        by_number: the channels by the numbers of their readers.
    """

    def __init__(self, link: Link) -> None:
        self.by_number: dict[int, _Channel] = {}
        self._link = link

    def listen(self, ros: RosName, qos: QoSProfile) -> None:
        """Make readers for the topic or service of an endpoint, unless existing readers hear it."""
        if ros.kind in {EndpointKind.CLIENT, EndpointKind.SERVICE}:
            self._listen_to_service(ros)
        else:
            self._listen_to_topic(ros, qos)

    def hears(self, channel: _Channel, qos: QoSProfile) -> bool:
        """Return whether a channel is the first that receives samples of a publisher with this QoS."""
        compatible = (
            each for each in self._of(channel.name, channel.message) if incompatibility(qos, each.qos) is None
        )
        return next(compatible, channel) is channel

    def _of(self, name: str, message: type[Message]) -> list[_Channel]:
        return [each for each in self.by_number.values() if (each.name, each.message) == (name, message)]

    def _listen_to_service(self, ros: RosName) -> None:
        service = get_service(ros.type_name)
        if not self._of(ros.name, service.Request):
            requests, responses = topic_names_of_service(ros.name)
            # a unique id, which matches no client and no server
            self._open(requests, EndpointKind.CLIENT, ros, service.Request, id_key="serviceid")
            self._open(responses, EndpointKind.SERVICE, ros, service.Response, id_key="clientid")

    def _listen_to_topic(self, ros: RosName, qos: QoSProfile) -> None:
        message = get_message(ros.type_name)
        there = self._of(ros.name, message)
        if ros.kind is EndpointKind.SUBSCRIPTION:
            if there or qos.reliability is ReliabilityPolicy.BEST_EFFORT:  # the offered QoS is not known yet
                return
            qos = replace(qos, durability=DurabilityPolicy.VOLATILE)
        elif any(incompatibility(qos, channel.qos) is None for channel in there):
            return
        qos = replace(qos, history=HistoryPolicy.KEEP_ALL, lifespan_ns=None)
        self._open(topic_name(ros.name), EndpointKind.PUBLISHER, ros, message, qos=qos)

    def _open(
        self,
        topic: str,
        writers: EndpointKind,
        ros: RosName,
        message: type[Message],
        *,
        qos: QoSProfile = _SERVICE_QOS,
        id_key: str = "own",
    ) -> None:
        user_data = f"{OBSERVER}=1;{id_key}={OBSERVER};"
        reader = self._link.create_reader(topic, message, qos, user_data)
        number = self._link.waitset.add(reader)
        self.by_number[number] = _Channel(reader, writers, ros.name, message, qos)
        self._link.waitset.watch(number)


class _Event(NamedTuple):
    """A sample on its way to the tap; events compare by the time of sending.

    A request or response has its id.
    """

    sent_ns: int
    age: int
    arrived_ns: int
    channel: _Channel
    writer: int
    request_id: RequestId | None
    payload: bytes


class _News(Graph):
    """Queues news of the graph."""

    def __init__(self, queue: WaitingLine[object]) -> None:
        super().__init__()
        self._queue = queue

    def learn_nodes(self, participant: Participant) -> bool:
        is_known = super().learn_nodes(participant)
        if is_known:
            self._queue.put(participant)
        return is_known

    def learn_endpoints(self, endpoints: Sequence[wheel.Endpoint], *, writers: bool) -> None:
        for endpoint in endpoints:
            self._queue.put((endpoint, writers))


class CycloneTap(LiveObserver):
    """Passes the events of a live network to a tap; it has no node, and sends no samples.

    Its domain and environment are as in `CycloneDDS`. The tap's methods are called on a separate thread, in the order
    of sending, about 0.1 s later, with times of sending by the system clock; a sender's time counts within the second
    before the sample came. A response waits up to 3 s for its request, which may have to be sent again, and a sample
    for the announcement of its node, whose name is empty without it. Connecting takes some hundredths of a second
    after an endpoint appears; earlier samples are lost unless they are kept for late readers. `on_request` is called
    once for each node that offers the service.

    Attributes:
        problems: topic or service → number of samples that could not be used.

    Raises:
        MiddlewareError: a setting cannot be used, or the domain cannot be entered.
    """

    def __init__(
        self,
        tap: Tap,
        *,
        domain_id: int | None = None,
        environment: Mapping[str, str] | None = None,
    ) -> None:
        self.problems: Counter[str] = Counter()
        self._tap = tap
        self._queue: WaitingLine[object] = WaitingLine()
        self._failure: Exception | None = None
        self._writers: dict[int, wheel.Endpoint] = {}
        self._servers: dict[bytes, str] = {}
        self._gone_ns: dict[bytes, int] = {}
        self._unannounced: dict[bytes, RosName] = {}
        self._node_of: dict[bytes, str] = {}
        self._nodes: set[tuple[bytes, str]] = set()
        self._events: list[_Event] = []
        self._requests: set[tuple[str, RequestId | None]] = set()
        self._ages = count()
        configuration = read_configuration(environment, domain_id=domain_id)
        self._link = Link(
            configuration,
            on_data=self._queue.put,
            on_problem=lambda where, _: self.problems.update([where]),
            on_failure=self._queue.put,
            graph=_News(self._queue),
        )
        self._channels = _Channels(self._link)
        self._thread = threading.Thread(target=self._run, name="tap", daemon=True)
        self._thread.start()

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._stop()
        self._link.leave(())
        if kind is None:
            self.check()

    def check(self) -> None:
        if self._failure is not None:
            raise self._failure

    def finish(self) -> None:
        self._stop()
        self.check()

    def _stop(self) -> None:
        if self._thread.is_alive():
            self._queue.put(None)
            self._thread.join()

    # Its thread

    def _run(self) -> None:
        try:
            while self._handle_next():
                self._pass_due_on(time.time_ns())
            self._link.look()
            for channel in self._channels.by_number.values():
                self._take(channel)
            while self._queue:
                self._handle_next()
            self._pass_due_on(None)
        except Exception as error:  # noqa: BLE001  `close` raises it
            self._failure = error

    def _handle_next(self) -> bool:
        """Handle the next item, if there is any within a moment; return whether to go on."""
        try:
            item = self._queue.get(_STEP_S if self._events else None)
        except Empty:
            return True
        if isinstance(item, Exception):
            raise item
        if isinstance(item, int):
            if item in self._channels.by_number:  # else news of the graph, which is queued separately
                self._take(self._channels.by_number[item])
                self._link.waitset.watch(item)
        elif isinstance(item, Participant):
            self._learn_nodes(item)
        elif isinstance(item, tuple):
            self._learn_endpoint(*item)
        return item is not None

    def _take(self, channel: _Channel) -> None:
        while (sample := wheel.take(channel.reader)) is not None:
            payload, writer, sent_ns = sample
            now_ns = time.time_ns()
            sent_ns = min(max(sent_ns, now_ns - _LATEST_NS), now_ns)
            request_id = None
            if channel.writers is not EndpointKind.PUBLISHER:
                try:
                    request_id, payload = split_sample(payload)
                except InterfaceError:
                    self.problems[channel.name] += 1
                    continue
            event = _Event(sent_ns, next(self._ages), now_ns, channel, writer, request_id, payload)
            heappush(self._events, event)

    # The graph

    def _learn_nodes(self, participant: Participant) -> None:
        for node in participant.nodes:
            name = qualified_name(node.namespace, node.name)
            self._node_of.update(dict.fromkeys((*node.readers, *node.writers), name))
            if (participant.guid, name) not in self._nodes:
                self._nodes.add((participant.guid, name))
                self._tap.on_node("", name)
        for guid in [guid for guid in self._unannounced if guid in self._node_of]:
            self._pass_reader_on(guid)

    def _pass_reader_on(self, guid: bytes) -> None:
        ros = self._unannounced.pop(guid)
        self._tap.on_endpoint(self._node_of[guid], ros.kind, ros.name)

    def _learn_endpoint(self, endpoint: wheel.Endpoint, writes: bool) -> None:
        guid = endpoint.guid
        if OBSERVER in parse_user_data(endpoint.user_data):
            return
        if endpoint.topic and writes:
            self._writers[endpoint.handle] = endpoint
        ros = ros_name(endpoint.topic, endpoint.type_name, writes=writes)
        if ros is not None:
            try:
                self._channels.listen(ros, endpoint.qos)
            except MiddlewareError:  # an unknown type, or a name that DDS refuses
                self.problems[ros.name] += 1
            if not writes:
                self._unannounced[guid] = ros
            if ros.kind is EndpointKind.SERVICE:
                self._servers[guid] = ros.name
            if guid in self._unannounced and guid in self._node_of:
                self._pass_reader_on(guid)
        if not endpoint.alive:
            self._gone_ns[guid] = time.time_ns()

    # Samples

    def _pass_due_on(self, now_ns: int | None) -> None:
        """Pass on samples that have waited long enough, or all at the end."""
        while self._events:
            event = self._events[0]
            waited_ns = _PATIENCE_NS if now_ns is None else now_ns - event.arrived_ns
            if waited_ns < (_HOLD_NS if self._is_complete(event) else _PATIENCE_NS):
                return
            self._pass_on(heappop(self._events))

    def _is_complete(self, event: _Event) -> bool:
        """Return whether the nodes at both ends are known and, for a response, its request."""
        writer = self._writers.get(event.writer)
        return (
            writer is not None
            and writer.guid in self._node_of
            and all(guid in self._node_of for guid in self._servers_of(event))
            and (
                event.channel.writers is not EndpointKind.SERVICE
                or (event.channel.name, event.request_id) in self._requests
            )
        )

    def _servers_of(self, event: _Event) -> list[bytes]:
        """Return the readers that have received a request."""
        if event.channel.writers is not EndpointKind.CLIENT:
            return []
        return [
            guid
            for guid, service in self._servers.items()
            if service == event.channel.name and self._gone_ns.get(guid, math.inf) > event.sent_ns
        ]

    def _pass_on(self, event: _Event) -> None:
        channel, writer = event.channel, self._writers.get(event.writer)
        node = "" if writer is None else self._node_of.get(writer.guid, "")
        if (
            channel.writers is EndpointKind.PUBLISHER
            and writer
            and not self._channels.hears(channel, writer.qos)
        ):
            return
        try:
            message = deserialize(event.payload, channel.message)
        except InterfaceError:
            self.problems[channel.name] += 1
            return
        sent_ns, name, request_id = event.sent_ns, channel.name, event.request_id
        if request_id is None:
            self._tap.on_message(sent_ns, name, node, message)
        elif channel.writers is EndpointKind.SERVICE:
            self._tap.on_response(sent_ns, name, node, message, request_id)
        else:
            self._requests.add((name, request_id))
            for server in dict.fromkeys(self._node_of.get(guid, "") for guid in self._servers_of(event)):
                self._tap.on_request(sent_ns, name, node, server, message, request_id)
