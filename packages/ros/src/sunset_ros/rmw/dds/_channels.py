"""The readers of an observer: one reader for each topic on the graph, two for each service."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import count
from typing import NamedTuple

from sunset_ros.interfaces import Message, get_message, get_service
from sunset_ros.rmw.core.port import EndpointKind
from sunset_ros.rmw.core.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    incompatibility,
)
from sunset_ros.rmw.dds import _library as dds
from sunset_ros.rmw.dds._link import FIRST_NUMBER, Link
from sunset_ros.rmw.dds._names import OBSERVER, RosName, topic_name, topic_names_of_service

_SERVICE_QOS = QoSProfile(history=HistoryPolicy.KEEP_ALL)


class Channel(NamedTuple):
    """A reader of the observer.

    Attributes:
        reader: the DDS reader.
        condition: holds while the reader has samples.
        writers: the kind of its writers: publishers, clients (of requests) or services (of responses).
        name: the name of the topic or service.
        message: the class of its samples.
        qos: the profile that it requests.
    """

    reader: int
    condition: int
    writers: EndpointKind
    name: str
    message: type[Message]
    qos: QoSProfile


class Channels:
    """The readers of an observer's participant, which keep all samples until they are taken."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._numbers = count(FIRST_NUMBER)
        self._channels: dict[int, Channel] = {}

    def __iter__(self) -> Iterator[Channel]:
        return iter(list(self._channels.values()))

    def get(self, number: int) -> Channel | None:
        """Return the channel of a number; None if there is none."""
        return self._channels.get(number)

    def watch(self, number: int) -> None:
        """Watch once whether a channel has samples."""
        self._link.waitset.watch(number, self._channels[number].condition)

    def listen(self, ros: RosName, qos: QoSProfile) -> None:
        """Make readers for the topic or service of an endpoint, unless existing readers hear it."""
        if ros.kind in {EndpointKind.CLIENT, EndpointKind.SERVICE}:
            self._listen_to_service(ros)
        else:
            self._listen_to_topic(ros, qos)

    def hears(self, channel: Channel, qos: QoSProfile) -> bool:
        """Return whether a channel is the first that receives samples of a publisher with this QoS."""
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
            # a unique id, which matches no client and no server
            self._open(topic, writers, ros.name, message, own_id=f"{own_id}={OBSERVER};")

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
