"""Publishers and subscriptions on DDS."""

from collections.abc import Callable

from sunset.interfaces import Message, serialize, type_name
from sunset.rmw.core.node import NodeHandle
from sunset.rmw.core.port import (
    DurabilityPolicy,
    PublisherHandle,
    QoSProfile,
    ReliabilityPolicy,
    SubscriptionHandle,
)
from sunset.rmw.dds import _library as dds
from sunset.rmw.dds import _wheel as wheel
from sunset.rmw.dds._entity import ReadingEntity
from sunset.rmw.dds._host import DdsEndpoint, DdsHost
from sunset.rmw.dds._names import topic_name


class DdsPublisher(DdsEndpoint, PublisherHandle):
    """A writer; never blocks, except one that keeps all samples while a reader does not confirm any."""

    __slots__ = ("_reliable", "_topic", "_transient_local", "_writer")

    def __init__(
        self, process: DdsHost, node: NodeHandle, message_type: type[Message], topic: str, qos: QoSProfile
    ) -> None:
        super().__init__(process, node, f"publisher of {topic}")
        self._topic = topic
        self._reliable = qos.reliability is ReliabilityPolicy.RELIABLE
        self._transient_local = qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        link = self.process.link
        with self.process.topic(topic_name(topic), message_type) as dds_topic:
            self._writer = dds.create_writer(link.publisher, dds_topic, qos, link.type_data(message_type))
        self.readers, self.writers = (), (dds.guid_of(self._writer),)
        self.join()

    def publish(self, message: Message) -> None:
        """Send a message.

        Raises:
            InterfaceError: a field's value does not fit the definition.
            MiddlewareError: the publisher is destroyed, or DDS refuses.
        """
        if not self.alive:
            self.check_alive(f"publish on {self._topic}")
        wheel.write(self._writer, serialize(message), self._topic)

    @property
    def wanted(self) -> bool:
        """Whether anybody would get a message sent now, or could get it later."""
        return self.alive and (self._transient_local or self.matched > 0)

    @property
    def matched(self) -> int:
        """Number of subscriptions that get what is sent."""
        return len(dds.matched_subscriptions(self._writer)) if self.alive else 0

    def reliable_writers(self) -> tuple[int, ...]:
        """Return its writer, if it is reliable."""
        return (self._writer,) if self._reliable else ()

    def take_turn(self) -> bool:
        """Do nothing: a publisher has no callbacks."""
        return False

    def retire(self) -> None:
        """Leave the graph; what was sent arrives."""
        super().retire()
        dds.delete(self._writer)


class DdsSubscription(ReadingEntity, SubscriptionHandle):
    """A reader, which holds at most `depth` samples that were not handled yet, and drops the oldest."""

    __slots__ = ("_handler", "_kind", "_topic")

    def __init__(
        self,
        process: DdsHost,
        node: NodeHandle,
        message_type: type[Message],
        topic: str,
        qos: QoSProfile,
        *,
        handler: Callable[[Message], None],
        label: str,
    ) -> None:
        super().__init__(process, node, label)
        self._topic = topic
        self._kind = message_type
        self._handler = handler
        link = self.process.link
        with self.process.topic(topic_name(topic), message_type) as dds_topic:
            reader = dds.create_reader(link.subscriber, dds_topic, qos, link.type_data(message_type))
        self.readers, self.writers = (dds.guid_of(reader),), ()
        self.listen_to(reader)

    def handle(self, payload: bytes, writer: int) -> bool:
        """Call the handler with a message."""
        del writer
        message = self.decoded(payload, self._kind, f"{self._topic} ({type_name(self._kind)})")
        if message is None:
            return False
        self.process.call(self, self._handler, message)
        return True

    @property
    def matched(self) -> int:
        """Number of publishers whose messages arrive here."""
        return len(dds.matched_publications(self._reader)) if self.alive else 0

    def retire(self) -> None:
        """Leave the graph; messages not yet handled are dropped."""
        super().retire()
        dds.delete(self._reader)
