"""Nodes, as in `rclpy.node`."""

import sys
from collections.abc import Callable, Iterator, Sequence
from typing import TypeAlias, TypedDict, TypeVar

from sunset_ros._node_graph import NodeGraph
from sunset_ros._node_parameters import Changes, NodeParameters
from sunset_ros._parameter_services import parameter_services
from sunset_ros.arguments import Arguments, find_overrides
from sunset_ros.callback_groups import CallbackGroup
from sunset_ros.client import AnyClient, Client
from sunset_ros.clock import Clock, ROSClock, TimeSource
from sunset_ros.context import Context, get_default_context
from sunset_ros.exceptions import NodeNameNonExistentError
from sunset_ros.interfaces import Message
from sunset_ros.interfaces import Service as ServiceType
from sunset_ros.interfaces.rcl_interfaces.msg import Log, ParameterEvent
from sunset_ros.logging import Logger, LoggingSeverity
from sunset_ros.names import rename_node, resolve_name
from sunset_ros.parameter import Parameter
from sunset_ros.publisher import AnyPublisher, Publisher
from sunset_ros.qos import (
    qos_profile_parameter_events,
    qos_profile_parameters,
    qos_profile_rosout_default,
    qos_profile_services_default,
    to_profile,
)
from sunset_ros.rmw.core.port import EndpointKind
from sunset_ros.rmw.core.qos import QoSProfile, incompatibility
from sunset_ros.service import Service
from sunset_ros.subscription import AnySubscription, Subscription
from sunset_ros.task import callback_name, driven
from sunset_ros.timer import Timer

__all__ = ["Node", "NodeNameNonExistentError"]

MessageT = TypeVar("MessageT", bound=Message)
Part: TypeAlias = AnyPublisher | AnySubscription | AnyClient | Service | Timer


class NodeOptions(TypedDict, total=False):
    """The keyword arguments of `Node`, which subclasses pass on."""

    context: Context | None
    cli_args: Sequence[str] | None
    namespace: str | None
    use_global_arguments: bool
    enable_rosout: bool
    start_parameter_services: bool
    parameter_overrides: list[Parameter] | None
    allow_undeclared_parameters: bool
    automatically_declare_parameters_from_overrides: bool


class Node(NodeParameters, NodeGraph):
    """A participant of the graph.

    Methods that take a name of a topic or service raise `InvalidTopicNameException` or `InvalidServiceNameException`
    if it breaks the rules.

    Args:
        node_name: its name; the command line may replace it (`-r __node:=`).
        context: its context, an attribute too; the default context if None.
        cli_args: arguments for this node alone, as after `ros2 run`.
        namespace: where its relative names are; the command line may replace it (`-r __ns:=`).
        use_global_arguments: whether the context's arguments hold for it.
        enable_rosout: whether its logs go to /rosout.
        start_parameter_services: whether others can see and set its parameters.
        parameter_overrides: values that win over defaults and the command line.
        allow_undeclared_parameters: whether parameters may be set that were not declared.
        automatically_declare_parameters_from_overrides: whether all overrides are declared at once.

    Raises:
        NotInitializedException: the context is not initialised.
        NameValidationException: name or namespace break the rules.
        UnknownROSArgsError: an argument is unknown or malformed.
        ParameterError: a parameter file or an override cannot be used.
    """

    def __init__(
        self,
        node_name: str,
        *,
        context: Context | None = None,
        cli_args: Sequence[str] | None = None,
        namespace: str | None = None,
        use_global_arguments: bool = True,
        enable_rosout: bool = True,
        start_parameter_services: bool = True,
        parameter_overrides: list[Parameter] | None = None,
        allow_undeclared_parameters: bool = False,
        automatically_declare_parameters_from_overrides: bool = False,
    ) -> None:
        self.context = context or get_default_context()
        self._middleware = self.context.middleware
        arguments = [Arguments.parse(cli_args or ())]
        arguments += [self.context.arguments] if use_global_arguments else []
        self._rules = [rule for each in arguments for rule in each.remaps]
        name, namespace = rename_node(node_name, namespace or "/", self._rules)
        self.handle = self._middleware.create_node(name, namespace)
        self._parts: dict[Part, None] = {}  # by age
        self.default_callback_group = CallbackGroup()  # of callbacks without a group
        self._clock = ROSClock(context=self.context)
        self._logger = self._make_logger(enable_rosout)
        self._time_source = TimeSource(self.handle, self._clock, self._logger)
        self.handle.warn = self._on_problem
        self._parameter_event_publisher = self.create_publisher(
            ParameterEvent, "/parameter_events", qos_profile_parameter_events
        )
        full_name = self.get_fully_qualified_name()
        overrides = [*find_overrides(arguments, full_name), *(parameter_overrides or ())]
        NodeParameters.__init__(
            self, full_name, overrides, allow_undeclared_parameters, self._on_parameters_changed
        )
        self.declare_parameter("use_sim_time", False)
        if automatically_declare_parameters_from_overrides:
            self._declare_overrides()
        for srv_type, service, callback in parameter_services(self) if start_parameter_services else ():
            self.create_service(srv_type, f"~/{service}", callback, qos_profile=qos_profile_parameters)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.get_fully_qualified_name()}>"

    # Its names

    @property
    def publishers(self) -> Iterator[AnyPublisher]:
        """Its publishers."""
        return (part for part in self._parts if isinstance(part, Publisher))

    @property
    def subscriptions(self) -> Iterator[AnySubscription]:
        """Its subscriptions."""
        return (part for part in self._parts if isinstance(part, Subscription))

    @property
    def clients(self) -> Iterator[AnyClient]:
        """Its clients."""
        return (part for part in self._parts if isinstance(part, Client))

    @property
    def services(self) -> Iterator[Service]:
        """Its services."""
        return (part for part in self._parts if isinstance(part, Service))

    @property
    def timers(self) -> Iterator[Timer]:
        """Its timers."""
        return (part for part in self._parts if isinstance(part, Timer))

    def get_name(self) -> str:
        """Return its name, without namespace."""
        return self.handle.name

    def get_namespace(self) -> str:
        """Return its namespace; the root is `/`."""
        return self.handle.namespace

    def get_fully_qualified_name(self) -> str:
        """Return its namespace and name, such as `/managed_subsystem/camera`."""
        return self.handle.fully_qualified_name

    def get_clock(self) -> Clock:
        """Return its clock, which follows /clock if the parameter `use_sim_time` is true."""
        return self._clock

    def get_logger(self) -> Logger:
        """Return its logger."""
        return self._logger

    def resolve_topic_name(self, topic: str, *, only_expand: bool = False) -> str:
        """Return the fully qualified name of a topic, remapped unless `only_expand`."""
        rules = () if only_expand else self._rules
        return resolve_name(topic, self.get_name(), self.get_namespace(), rules)

    def resolve_service_name(self, service: str, *, only_expand: bool = False) -> str:
        """Return the fully qualified name of a service, remapped unless `only_expand`."""
        rules = () if only_expand else self._rules
        return resolve_name(service, self.get_name(), self.get_namespace(), rules, is_service=True)

    # Its parts

    def create_publisher(
        self,
        msg_type: type[MessageT],
        topic: str,
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,  # noqa: ARG002  as in rclpy
        publisher_class: type[AnyPublisher] = Publisher,
    ) -> Publisher[MessageT]:
        """Make a publisher on a topic; a whole number as QoS keeps the last so many messages."""
        name, qos = self.resolve_topic_name(topic), to_profile(qos_profile)
        self._warn_of_mismatch(name, EndpointKind.PUBLISHER, qos)
        handle = self.handle.create_publisher(msg_type, name, qos)
        publisher: Publisher[MessageT] = publisher_class(handle, msg_type, name, qos)
        self._parts[publisher] = None
        return publisher

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: QoSProfile | int,
        *,
        callback_group: CallbackGroup | None = None,  # noqa: ARG002  as in rclpy
    ) -> Subscription[MessageT]:
        """Call `callback(message)` for the messages on a topic; at most the QoS depth of them wait."""
        name, qos = self.resolve_topic_name(topic), to_profile(qos_profile)
        self._warn_of_mismatch(name, EndpointKind.SUBSCRIPTION, qos)
        label = f"{callback_name(callback)} (subscription of {name})"
        handle = self.handle.create_subscription(msg_type, name, qos, driven(callback), label=label)
        subscription = Subscription(handle, msg_type, name, qos, callback)
        self._parts[subscription] = None
        return subscription

    def create_client(
        self,
        srv_type: type[ServiceType],
        srv_name: str,
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,  # noqa: ARG002  as in rclpy
    ) -> AnyClient:
        """Make a client of a service."""
        name = self.resolve_service_name(srv_name)
        client: AnyClient = Client(self.handle, srv_type, name, qos_profile)
        self._parts[client] = None
        return client

    def create_service(
        self,
        srv_type: type[ServiceType],
        srv_name: str,
        callback: Callable[..., object],
        *,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,  # noqa: ARG002  as in rclpy
        service_class: type[Service] = Service,
    ) -> Service:
        """Answer requests with the result of `callback(request, response)`, which may be a coroutine function."""
        name = self.resolve_service_name(srv_name)
        label = f"{callback_name(callback)} (service {name})"
        service = service_class(self.handle, srv_type, name, callback, qos_profile, label=label)
        self._parts[service] = None
        return service

    def create_timer(
        self,
        timer_period_sec: float,
        callback: Callable[[], object],
        callback_group: CallbackGroup | None = None,  # noqa: ARG002  as in rclpy
        clock: Clock | None = None,
        autostart: bool = True,
    ) -> Timer:
        """Call `callback()` periodically, first after a period, by a clock or the node's own.

        Raise a `MiddlewareError` if the period is negative.
        """
        period_ns = round(timer_period_sec * 1e9)
        timer = Timer(
            self.handle, clock or self._clock, callback, period_ns, f"{callback_name(callback)} (timer)"
        )
        if not autostart:
            timer.cancel()
        self._parts[timer] = None
        return timer

    def destroy_publisher(self, part: Part) -> bool:
        """Take a part off the graph; return whether it was this node's."""
        if part not in self._parts:
            return False
        del self._parts[part]
        part.destroy()
        return True

    destroy_subscription = destroy_client = destroy_service = destroy_timer = destroy_publisher

    def destroy_node(self) -> None:
        """Leave the graph with everything that the node consists of."""
        self._log_sink.leave()
        for timer in list(self.timers):
            self.destroy_timer(timer)
        self.handle.destroy()
        self._parts.clear()

    # How it is made

    def _make_logger(self, enable_rosout: bool) -> Logger:
        rosout = None
        arguments = self.context.arguments
        if enable_rosout and arguments.log_to_rosout:
            rosout = self.create_publisher(Log, "/rosout", qos_profile_rosout_default)
        self._log_sink = sink = _LogSink(self.context, self._clock, rosout)
        name = self.get_fully_qualified_name().lstrip("/").replace("/", ".")
        return Logger(name, sink, arguments.log_level or LoggingSeverity.INFO)

    def _on_problem(self, problem: str) -> None:
        self._logger.warning(problem)

    def _warn_of_mismatch(self, topic: str, kind: EndpointKind, qos: QoSProfile) -> None:
        for other in self._middleware.endpoints(topic):
            if other.kind is kind:
                continue
            offered, requested = (qos, other.qos) if kind is EndpointKind.PUBLISHER else (other.qos, qos)
            policy = incompatibility(offered, requested)
            if policy is not None:
                mine = f"the {kind.value} of this node"
                theirs = f"the {other.kind.value} of {other.node_name}"
                self._logger.warning(
                    f"On {topic}, {mine} and {theirs} do not match: incompatible {policy}."  # noqa: G004  as in ROS
                )

    def _on_parameters_changed(self, changes: Changes) -> None:
        for parameter in [*changes.new, *changes.changed]:
            if parameter.name == "use_sim_time":
                self._time_source.use_sim_time(parameter.value is True)
        self._announce(changes, self._parameter_event_publisher)

    def _announce(self, changes: Changes, publisher: Publisher[ParameterEvent]) -> None:
        """Publish changes of parameters where the publisher has subscribers."""
        if publisher.handle.wanted:
            kinds = (changes.new, changes.changed, changes.deleted)
            new, changed, deleted = ([parameter.to_parameter_msg() for parameter in kind] for kind in kinds)
            publisher.publish(
                ParameterEvent(
                    stamp=self._clock.now().to_msg(),
                    node=self.get_fully_qualified_name(),
                    new_parameters=new,
                    changed_parameters=changed,
                    deleted_parameters=deleted,
                )
            )


class _LogSink:
    """Sends a node's log messages to /rosout, and to stderr if the context says so."""

    def __init__(self, context: Context, clock: Clock, rosout: Publisher[Log] | None) -> None:
        self._context = context
        self._clock = clock
        self._rosout = rosout
        self._written: set[tuple[int, str, str]] = set()

    def now_ns(self) -> int:
        """Return the time by which messages are throttled, which no node can set."""
        return self._context.middleware.steady_ns()

    def leave(self) -> None:
        """Send to /rosout no more: the node has left the graph."""
        self._rosout = None

    def write(self, message: Log) -> None:
        """Send a message; once the context is shut down, to stderr only."""
        if self._rosout is not None and self._context.ok():
            message.stamp = self._clock.now().to_msg()
            self._rosout.publish(message)
        line = (message.level, message.name, message.msg)
        if self._context.arguments.log_to_stderr and line not in self._written:
            if self._context.log_once:
                self._written.add(line)
            severity, seconds = LoggingSeverity(message.level).name, self._clock.now_ns() / 1e9
            sys.stderr.write(f"[{severity}] [{seconds:.9f}] [{message.name}]: {message.msg}\n")
