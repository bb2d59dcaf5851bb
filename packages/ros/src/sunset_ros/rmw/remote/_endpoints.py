"""Parts of nodes in another process; each sends changes to its stand-in on the network."""

from functools import partial
from typing import Final

from sunset_ros.interfaces import Message, deserialize, serialize, type_name
from sunset_ros.rmw.core.node import (
    ClientHandle,
    Endpoint,
    Entity,
    Parts,
    PublisherHandle,
    ServiceHandle,
    SubscriptionHandle,
    Timer,
)
from sunset_ros.rmw.core.port import RequestId
from sunset_ros.rmw.remote._process import RemoteHost, RemoteNode
from sunset_ros.rmw.remote._protocol import Act, Ask, Call, MakeEndpoint, MakeTimer

_LONGEST_NS: Final = 1 << 62
"""A period of 146 years; the protocol's numbers have 64 bits."""


class _RemotePart(Entity):
    """A part with its number in the protocol."""

    process: RemoteHost
    node: RemoteNode
    number = -1

    def request(self, act: Act) -> None:
        """Let the stand-in do something, if it exists."""
        if self.number in self.process.handlers:
            self.process.request(act)

    def retire(self) -> None:
        super().retire()
        self.request(Act(self.number, "destroy"))
        self.process.handlers.pop(self.number, None)


class _RemoteEndpoint(_RemotePart, Endpoint):
    """An endpoint, whose handler gets the messages of calls."""

    def open(self) -> None:
        super().open()
        self.number = self.process.new_number(self.run)
        ros_type = type_name(self.ros_type)
        self.process.request(
            MakeEndpoint(self.number, self.node.number, self.kind, ros_type, self.name, self.qos, self.label)
        )

    def run(self, call: Call) -> None:
        """Call the handler with the message of a call."""
        self.handler(*call.ids, deserialize(call.body, self.received))


class RemotePublisher(_RemoteEndpoint, PublisherHandle):
    """Sends samples, and checks them."""

    def publish(self, message: Message) -> None:
        self.check_alive(f"publish on {self.name}")
        self.request(Act(self.number, "publish", body=serialize(message)))

    @property
    def wanted(self) -> bool:
        return self.alive and bool(self.process.ask(Ask(self.number, "wanted")).value)

    @property
    def matched(self) -> int:
        return self.process.ask(Ask(self.number, "matched")).value if self.alive else 0


class RemoteSubscription(_RemoteEndpoint, SubscriptionHandle):
    """Receives samples."""

    @property
    def matched(self) -> int:
        return self.process.ask(Ask(self.number, "matched")).value if self.alive else 0


class RemoteClient(_RemoteEndpoint, ClientHandle):
    """Sends requests to every server of its name and type."""

    def send(self, number: int, request: Message, payload: bytes) -> None:
        del number, request  # the stand-in counts, too
        self.request(Act(self.number, "send_request", body=payload))

    def server_ready(self) -> bool:
        return self.alive and bool(self.process.ask(Ask(self.number, "server_ready")).value)


class RemoteService(_RemoteEndpoint, ServiceHandle):
    """Receives requests."""

    def run(self, call: Call) -> None:
        (request_id,) = call.ids
        assert isinstance(request_id, RequestId)  # noqa: S101  of a service
        self.asked[request_id] = partial(self._respond, request_id)
        super().run(call)

    def _respond(self, request_id: RequestId, response: Message, payload: bytes) -> None:
        del response
        self.request(Act(self.number, "send_response", request_id, payload))


class RemoteTimer(_RemotePart, Timer):
    """A timer that computes its due times; its stand-in expires."""

    def join(self) -> None:
        super().join()
        self.number = self.process.new_number(lambda _: self.run())
        period_ns = min(self._period_ns, _LONGEST_NS)
        self.process.request(MakeTimer(self.number, self.node.number, period_ns, self.label))

    def set_alarm(self, due_ns: int | None) -> None:
        """Do nothing: the stand-in has the alarm."""

    def set_period_ns(self, period_ns: int) -> None:
        super().set_period_ns(period_ns)
        self.request(Act(self.number, "set_period_ns", min(period_ns, _LONGEST_NS)))

    def reset(self) -> None:
        super().reset()
        self.request(Act(self.number, "reset"))

    def cancel(self) -> None:
        super().cancel()
        self.request(Act(self.number, "cancel"))


class RemoteProcess(RemoteHost):
    """A process outside of its simulation, or network.

    `main` and the callbacks run when the gateway calls them. A simulation's time stands still meanwhile.

    Args:
        pipe: the connection to the gateway.
        main: makes the nodes.
        describe: describes an exception of `main` or a callback as the end of a sentence.
        describes_types: whether its nodes offer descriptions of their types, as live nodes do.
    """

    parts = Parts(RemotePublisher, RemoteSubscription, RemoteClient, RemoteService, RemoteTimer)

    def defer(self, subscription: SubscriptionHandle) -> None:
        """Delay calls of a subscription's handler until the next other call: it must only store the messages."""
        assert isinstance(subscription, RemoteSubscription)  # noqa: S101  made here
        subscription.request(Act(subscription.number, "defer"))
