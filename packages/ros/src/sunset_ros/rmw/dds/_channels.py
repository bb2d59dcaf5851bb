"""The readers of an observer: one reader for each topic on the graph, two for each service."""

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
from sunset_ros.rmw.dds._link import FIRST_NUMBER, Link
from sunset_ros.rmw.dds._names import OBSERVER, RosName, topic_name, topic_names_of_service

_SERVICE_QOS = QoSProfile(history=HistoryPolicy.KEEP_ALL)


class Channel(NamedTuple):
    """A reader of the observer.

    Attributes:
        reader: the DDS reader.
        writers: the kind of its writers: publishers, clients (of requests) or services (of responses).
        name: the name of the topic or service.
        message: the class of its samples.
        qos: the profile that it requests.
    """

    reader: int
    writers: EndpointKind
    name: str
    message: type[Message]
    qos: QoSProfile


class Channels:
    """The readers of an observer's participant, which keep all samples until they are taken.

    Attributes:
        by_number: the channels by the numbers of their readers.
    """

    def __init__(self, link: Link) -> None:
        self.by_number: dict[int, Channel] = {}
        self._link = link
        self._numbers = count(FIRST_NUMBER)

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
        number = next(self._numbers)
        self.by_number[number] = Channel(reader, writers, ros.name, message, qos)
        self._link.waitset.add(number, reader)
