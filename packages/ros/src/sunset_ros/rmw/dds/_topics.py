"""Publishers and subscriptions on DDS."""

from sunset_ros.interfaces import Message, deserialize, serialize, type_name
from sunset_ros.rmw.core.node import NodeHandle
from sunset_ros.rmw.core.port import PublisherHandle, SubscriptionHandle
from sunset_ros.rmw.core.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sunset_ros.rmw.dds import _library as dds
from sunset_ros.rmw.dds import _wheel as wheel
from sunset_ros.rmw.dds._entity import ReadingEntity
from sunset_ros.rmw.dds._host import DdsEndpoint, DdsHost
from sunset_ros.rmw.dds._names import topic_name


class DdsPublisher(DdsEndpoint, PublisherHandle):
    """Sends samples; it blocks only while it keeps all samples and a reader confirms none."""

    def __init__(
        self, process: DdsHost, node: NodeHandle, message_type: type[Message], topic: str, qos: QoSProfile
    ) -> None:
        super().__init__(process, node, f"publisher of {topic}")
        self._topic = topic
        self._reliable = qos.reliability is ReliabilityPolicy.RELIABLE
        self._transient_local = qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        with process.undisturbed():
            self._writer = process.link.create_writer(topic_name(topic), message_type, qos)
        self.readers, self.writers = (), (dds.guid_of(self._writer),)
        self.join()

    def publish(self, message: Message) -> None:
        if not self.alive:
            self.check_alive(f"publish on {self._topic}")
        wheel.write(self._writer, serialize(message), self._topic)

    @property
    def wanted(self) -> bool:
        return self.alive and (self._transient_local or self.matched > 0)

    @property
    def matched(self) -> int:
        return len(dds.matched_subscriptions(self._writer)) if self.alive else 0

    def reliable_writers(self) -> tuple[int, ...]:
        return (self._writer,) if self._reliable else ()

    def retire(self) -> None:
        super().retire()
        dds.delete(self._writer)


class DdsSubscription(ReadingEntity[Message], SubscriptionHandle):
    """Receives samples."""

    def open(self, ros_type: type[Message], qos: QoSProfile) -> None:
        self._kind = ros_type
        self.place = f"{self.name} ({type_name(ros_type)})"
        with self.process.undisturbed():
            reader = self.process.link.create_reader(topic_name(self.name), ros_type, qos)
        self.readers, self.writers = (dds.guid_of(reader),), ()
        self.listen_to(reader)

    def handle(self, payload: bytes, writer: int) -> bool:
        del writer
        self.process.call(self, self.handler, deserialize(payload, self._kind))
        return True

    @property
    def matched(self) -> int:
        return len(dds.matched_publications(self.reader)) if self.alive else 0
