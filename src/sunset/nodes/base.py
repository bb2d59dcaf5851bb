"""The base class of the managed system's nodes, with the four kinds of adaptation."""

import math
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Final, TypeVar, cast

from sunset.errors import ParameterError
from sunset.nodes.parameters import FaultParameter, NodeParameter, bound_parameters
from sunset.system import (
    DIAGNOSTICS_TOPIC,
    FAULT_ACCESS,
    INJECTED_EVENTS_TOPIC,
    LONGEST_DELAY_S,
    NAMESPACE,
    current_system,
)
from sunset_ros._node_parameters import Changes
from sunset_ros.context import Context
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.msg import ParameterEvent, SetParametersResult
from sunset_ros.interfaces.std_msgs.msg import Header
from sunset_ros.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from sunset_ros.node import Node
from sunset_ros.parameter import Parameter
from sunset_ros.publisher import Publisher
from sunset_ros.qos import qos_profile_parameter_events
from sunset_ros.subscription import AnySubscription
from sunset_ros.task import Future
from sunset_ros.texts import suggestion

_HEARTBEAT_S: Final = 0.1

MessageT = TypeVar("MessageT", bound=Message)


@dataclass(slots=True)
class _Input:
    """A subscription of an active node; its topic is fixed or a parameter's value."""

    message_type: type[Message]
    topic: str
    parameter: str
    callback: Callable[..., None]
    depth: int
    subscription: AnySubscription | None = None


def call_later(node: Node, delay: float, function: Callable[[], None]) -> None:
    """Call a function after a delay in seconds by a node's clock, and after the present callback."""

    def fire() -> None:
        timer.cancel()
        node.destroy_timer(timer)
        function()

    timer = node.create_timer(delay, fire)


class AdaptiveNode(LifecycleNode):
    """A lifecycle node that a managing system can adapt.

    A subclass declares its parameters in its body (`NodeParameter`, `FaultParameter`, `action`), and its inputs and
    outputs in `set_up`. It gets

    - *reparametrisation*: parameters are validated, refused with a reason, and read as attributes;
    - *change of communication*: an input whose topic is a parameter (`create_switchable_subscription`);
    - *addition and removal*: inputs exist, and outputs publish, only while the node is active;
    - *redeploy*: the lifecycle's shutdown ends the node's process.

    The node configures itself, and activates itself after `lifecycle_activation_delay` seconds, the boot time of its
    hardware, before which it refuses activation; the default is in the system's description. It reports its state and
    the values given to `report` on `/diagnostics` ten times a second, until it is shut down. With `autostart` false,
    another node, such as a lifecycle manager, configures and activates it; a request to activate it waits until it has
    booted.

    Args:
        context: the context of the process; None for the default context.
        cli_args: ROS arguments, such as `["--ros-args", "-p", "seed:=1"]`.
        parameter_overrides: initial values of parameters.
    """

    node_name: ClassVar[str]
    """The node's name."""

    lifecycle_activation_delay = NodeParameter(
        0.0,
        "seconds from the start until the node activates itself; negative: it does not",
        minimum=-1.0,
        maximum=LONGEST_DELAY_S,
        read_only=True,
    )

    autostart = NodeParameter(
        True, "whether the node configures and activates itself; if not, another node does", read_only=True
    )

    fault_access = NodeParameter(
        False, "whether the experiment may change and end faults that are there; not for a managing system"
    )

    def __init__(
        self,
        *,
        context: Context | None = None,
        cli_args: list[str] | None = None,
        parameter_overrides: list[Parameter] | None = None,
    ) -> None:
        self.parameter_values: dict[str, Any] = {}
        """The present values of the bound parameters, by name."""
        super().__init__(
            self.node_name,
            context=context,
            cli_args=cli_args,
            namespace=NAMESPACE,
            parameter_overrides=parameter_overrides,
        )
        # two underscores, so that subclasses can use any name
        self.__bound = MappingProxyType(bound_parameters(type(self)))
        self.__inputs: list[_Input] = []
        self.__news: list[KeyValue] = []
        self.__flags: dict[str, bool] = {}
        self.__curing = False
        self.__injected_events = self.create_publisher(
            ParameterEvent, INJECTED_EVENTS_TOPIC, qos_profile_parameter_events
        )
        self.__declare_bound_parameters()
        self.__diagnostics = self.create_publisher(DiagnosticArray, DIAGNOSTICS_TOPIC, 10)
        self.__heartbeat = self.create_timer(_HEARTBEAT_S, self.__publish_heartbeat)
        self.__booted: Future[bool] = Future()
        if self.lifecycle_activation_delay <= 0:
            self.__booted.set_result(True)
        self.set_up()
        self.call_later(0.0, self.__start)

    def set_up(self) -> None:
        """Declare inputs and outputs, and prepare the callbacks; parameters have their values."""

    def create_active_subscription(
        self,
        message_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], None],
        *,
        depth: int = 5,
    ) -> None:
        """Subscribe to a topic while the node is active; relative names are in the managed system's namespace.

        While the node is busy, up to `depth` messages wait; the oldest are dropped first.
        """
        self.__inputs.append(_Input(message_type, topic, "", callback, depth))

    def create_switchable_subscription(
        self,
        message_type: type[MessageT],
        parameter: str,
        callback: Callable[[MessageT], None],
        *,
        depth: int = 5,
    ) -> None:
        """Subscribe, while the node is active, to the topic in a text parameter of this class.

        A new value of the parameter replaces the subscription. While the node is busy, up to `depth` messages wait;
        the oldest are dropped first.
        """
        self.__inputs.append(_Input(message_type, "", parameter, callback, depth))

    def report(self, key: str, value: float | bool) -> None:
        """Report a value with the next heartbeat only. A true flag is a warning.

        Raises:
            ValueError: it is not finite; or it is a number, and the node's description has no signal of this key.
        """
        if not math.isfinite(value):
            raise ValueError(f"{self.node_name} must report finite values, got {key} = {value!r}.")
        system = current_system()
        undeclared = f"{self.node_name}_{key}" not in system.signals and not isinstance(value, bool)
        if undeclared and self.node_name in system.nodes:
            keys = [signal.key for signal in system.signals.values() if signal.node == self.node_name]
            raise ValueError(
                f"{self.node_name} must report numbers that a signal describes, got {key!r}: {suggestion(key, keys)}"
                f"add Signal({self.node_name!r}, {key!r}) to its extension."
            )
        text = str(value).lower() if isinstance(value, bool) else repr(float(value))
        self.__news.append(KeyValue(key=key, value=text))
        if isinstance(value, bool):
            self.__flags[key] = value

    def call_later(self, delay: float, function: Callable[[], None]) -> None:
        """Call a function after a delay in seconds, and after the present callback."""
        call_later(self, delay, function)

    def _offered_parameters(self) -> list[str]:
        """Leave out parameters that a managing system must not set: the clock, read-only and fault parameters."""
        node, faults = self.get_fully_qualified_name(), current_system().fault_parameters
        return [
            name
            for name in super()._offered_parameters()
            if name != "use_sim_time"
            and (node, name) not in faults
            and not self.describe_parameter(name).read_only
        ]

    def _announce(self, changes: Changes, publisher: Publisher[ParameterEvent]) -> None:
        """Publish changes that would show an injection on a topic of the experiment instead of `/parameter_events`."""
        injected = changes.of(self.__is_injected)
        if injected:
            super()._announce(injected, self.__injected_events)
        shown = changes.of(lambda name: not self.__is_injected(name))
        if shown:
            super()._announce(shown, publisher)

    def __is_injected(self, name: str) -> bool:
        """Return whether a parameter is a fault's, or set by the experiment now."""
        key = self.get_fully_qualified_name(), name
        return key in current_system().fault_parameters or bool(self.parameter_values.get(FAULT_ACCESS))

    def write_parameter(self, name: str, value: bool | float | str) -> None:
        """Set a parameter of this node from within, which can also end a fault.

        Raises:
            ParameterError: the value is refused.
        """
        self.__curing = True
        try:
            (result,) = self.set_parameters([Parameter(name, value=value)])
        finally:
            self.__curing = False
        if not result.successful:
            raise ParameterError(f"{self.node_name} refused {name} = {value!r}: {result.reason}")

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the faults that a restart cures, and subscribe; refused while the hardware boots."""
        if not self.__booted.done():
            reason = f"{self.node_name} cannot be activated yet: it is still booting."
            self.get_logger().warning(reason, throttle_duration_sec=1.0)
            return TransitionCallbackReturn.FAILURE
        for name, parameter in self.__bound.items():
            is_cured = isinstance(parameter, FaultParameter) and parameter.cured_by_restart
            if is_cured and self.parameter_values[name] != parameter.default:
                self.write_parameter(name, parameter.default)
        for entry in self.__inputs:
            self.__open(entry)
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Unsubscribe."""
        for entry in self.__inputs:
            self.__close(entry)
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """End the process, once the answer to this transition has left."""
        self.__heartbeat.cancel()
        for entry in self.__inputs:
            self.__close(entry)
        self.call_later(0.0, self.context.try_shutdown)
        return super().on_shutdown(state)

    def __start(self) -> None:
        """Configure, and activate after the delay, which includes the time of configuring."""
        if self.lifecycle_activation_delay >= 0:
            self.call_later(self.lifecycle_activation_delay, self.__finish_booting)
        if self.autostart:
            self.trigger_configure()

    def __finish_booting(self) -> None:
        self.__booted.set_result(True)
        if self.autostart and self.__state_label() == "inactive":
            self.trigger_activate()

    def _change_state(
        self, request: ChangeState.Request, response: ChangeState.Response
    ) -> ChangeState.Response | Awaitable[ChangeState.Response]:
        """Let another node's request for activation wait until the hardware has booted."""
        change = super()._change_state
        asked = self._state_machine.find(request.transition.label, request.transition.id)

        async def change_when_booted() -> ChangeState.Response:
            await self.__booted
            return cast("ChangeState.Response", change(request, response))

        waits = not self.autostart and asked is not None and asked.label == "activate"
        return change_when_booted() if waits else change(request, response)

    def __state_label(self) -> str:
        label: str = self._state_machine.current_state[1]
        return label

    def __publish_heartbeat(self) -> None:
        state = self.__state_label()
        status = DiagnosticStatus(
            level=self.__level(state),
            name=f"{self.node_name}: heartbeat",
            message=state,
            hardware_id=self.node_name,
            values=self.__news,
        )
        self.__news = []
        stamp = self.get_clock().now().to_msg()
        self.__diagnostics.publish(DiagnosticArray(header=Header(stamp=stamp), status=[status]))

    def __level(self, state: str) -> bytes:
        """Return a level for diagnostic tools, by the lifecycle state and the reported flags alone."""
        if state in {"finalized", "errorprocessing"}:
            return DiagnosticStatus.ERROR
        is_started = state == "active" or (state == "inactive" and self.lifecycle_activation_delay < 0)
        return DiagnosticStatus.WARN if any(self.__flags.values()) or not is_started else DiagnosticStatus.OK

    def __open(self, entry: _Input) -> None:
        self.__close(entry)  # an activation that failed may have left it open
        topic = self.parameter_values[entry.parameter] if entry.parameter else entry.topic
        entry.subscription = self.create_subscription(entry.message_type, topic, entry.callback, entry.depth)

    def __close(self, entry: _Input) -> None:
        if entry.subscription is not None:
            self.destroy_subscription(entry.subscription)
            entry.subscription = None

    def __declare_bound_parameters(self) -> None:
        self.parameter_values.update({name: bound.default for name, bound in self.__bound.items()})
        described = current_system().nodes.get(self.node_name)
        if described is not None:
            self.parameter_values["lifecycle_activation_delay"] = described.activation_delay_s
        for name, bound in self.__bound.items():
            value = self.declare_parameter(name, self.parameter_values[name], bound.descriptor()).value
            refusal = bound.refusal(self, value)
            if refusal:
                raise ParameterError(refusal)
            self.parameter_values[name] = value
        self.add_on_set_parameters_callback(self.__check_parameters)
        self.add_post_set_parameters_callback(self.__take_parameters)

    def __check_parameters(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            bound = self.__bound.get(parameter.name)
            refusal = bound.refusal(self, parameter.value) if bound and not self.__curing else ""
            if refusal:
                return SetParametersResult(successful=False, reason=refusal)
        return SetParametersResult(successful=True)

    def __take_parameters(self, parameters: Sequence[Parameter]) -> None:
        ours = [parameter for parameter in parameters if parameter.name in self.__bound]
        for parameter in ours:
            changed = self.parameter_values[parameter.name] != parameter.value
            self.parameter_values[parameter.name] = parameter.value
            if changed:
                for entry in self.__inputs:
                    if entry.parameter == parameter.name and entry.subscription is not None:
                        self.__open(entry)
        for parameter in ours:  # afterwards, since actions set parameters again
            self.__bound[parameter.name].after_set(self, parameter.value)
