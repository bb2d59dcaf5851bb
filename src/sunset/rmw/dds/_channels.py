"""The readers of an observer: one for each topic, two for each service, of whatever appears on the graph."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import count
from typing import NamedTuple

from sunset.interfaces import Message, get_message, get_service
from sunset.rmw.core.port import EndpointKind
from sunset.rmw.core.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    incompatibility,
)
from sunset.rmw.dds import _library as dds
from sunset.rmw.dds._link import FIRST_NUMBER, Link
from sunset.rmw.dds._names import OBSERVER, RosName, topic_name, topic_names_of_service

_SERVICE_QOS = QoSProfile(history=HistoryPolicy.KEEP_ALL)


class Channel(NamedTuple):
    """A reader of the observer.

    Attributes:
        reader: the DDS reader.
        condition: holds while it has samples.
        writers: what its writers are: publishers, clients (it gets requests) or services (it gets responses).
        name: of the topic or service.
        message: what its samples are.
        qos: what it asks for.
    """

    reader: int
    condition: int
    writers: EndpointKind
    name: str
    message: type[Message]
    qos: QoSProfile


class Channels:
    """The readers of an observer's participant, which lose nothing: they keep all until it is taken."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._numbers = count(FIRST_NUMBER)
        self._channels: dict[int, Channel] = {}

    def __iter__(self) -> Iterator[Channel]:
        return iter(list(self._channels.values()))

    def get(self, number: int) -> Channel | None:
        """Return the channel of a number, if it is one's."""
        return self._channels.get(number)

    def watch(self, number: int) -> None:
        """Get to know, once, when a channel has samples."""
        self._link.waitset.watch(number, self._channels[number].condition)

    def listen(self, ros: RosName, qos: QoSProfile) -> None:
        """Make readers for the topic or service of an endpoint that has a QoS, unless there are some that hear it.

        Raises:
            InterfaceError: its type has no definition here.
        """
        if ros.kind in {EndpointKind.CLIENT, EndpointKind.SERVICE}:
            self._listen_to_service(ros)
        else:
            self._listen_to_topic(ros, qos)

    def hears(self, channel: Channel, qos: QoSProfile) -> bool:
        """Return whether it is this channel that is to be heard, of those which get what a publisher offers."""
        compatible = (
            each for each in self._of(channel.name, channel.message) if incompatibility(qos, each.qos) is None
        )
        return next(compatible, channel) is channel

    def _of(self, name: str, message: type[Message]) -> list[Channel]:
        return [
            channel
            for channel in self._channels.values()
            if (channel.name, channel.message) == (name, message)
        ]

    def _listen_to_service(self, ros: RosName) -> None:
        service = get_service(ros.type_name)
        if self._of(ros.name, service.Request):
            return
        requests, responses = topic_names_of_service(ros.name)
        for topic, message, writers, own_id in (
            (requests, service.Request, EndpointKind.CLIENT, "serviceid"),
            (responses, service.Response, EndpointKind.SERVICE, "clientid"),
        ):
            # an id that no other endpoint has, so that clients and servers are not misled
            self._open(topic, writers, ros.name, message, own_id=f"{own_id}={OBSERVER};")

    def _listen_to_topic(self, ros: RosName, qos: QoSProfile) -> None:
        message = get_message(ros.type_name)
        there = self._of(ros.name, message)
        if ros.kind is EndpointKind.SUBSCRIPTION:
            if there or qos.reliability is ReliabilityPolicy.BEST_EFFORT:  # what will be offered is not known
                return
            qos = replace(qos, durability=DurabilityPolicy.VOLATILE)
        elif any(incompatibility(qos, channel.qos) is None for channel in there):
            return
        qos = replace(qos, history=HistoryPolicy.KEEP_ALL, lifespan_ns=None)
        self._open(topic_name(ros.name), EndpointKind.PUBLISHER, ros.name, message, qos=qos)

    def _open(
        self,
        topic: str,
        writers: EndpointKind,
        name: str,
        message: type[Message],
        *,
        qos: QoSProfile = _SERVICE_QOS,
        own_id: str = "",
    ) -> None:
        reader = self._link.create_reader(topic, message, qos, f"{OBSERVER}=1;{own_id}")
        number = next(self._numbers)
        self._channels[number] = Channel(reader, dds.data_condition(reader), writers, name, message, qos)
        self.watch(number)
