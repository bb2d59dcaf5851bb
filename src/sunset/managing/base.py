"""The base class of managing systems, which see symptoms and adapt the managed system."""

from collections.abc import Callable, Mapping, Sequence
from inspect import isasyncgen, iscoroutine, isgenerator
from typing import Any, ClassVar, TypeVar, cast

from sunset.managing.messages import LONGEST_THOUGHT_S, cost_message, diagnosis_message, is_number
from sunset.managing.symptoms import DEFAULT_ENTROPY_THRESHOLD, Symptoms, make_greeting, read_parameters
from sunset.system.vocabulary import (
    BLACKBOARD_TOPIC,
    COST_TOPIC,
    DIAGNOSIS_TOPIC,
    MANAGING_SYSTEM,
    REPAIR,
    Value,
    current_system,
    full_name,
)
from sunset.system_interfaces.msg import Cost, Diagnosis, SetBlackboardGroup
from sunset.system_interfaces.srv import Redeploy
from sunset.texts.names import base_name
from sunset_ros.client import AnyClient
from sunset_ros.context import Context
from sunset_ros.exceptions import NotInitializedException
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from sunset_ros.interfaces.rcl_interfaces.srv import SetParameters
from sunset_ros.node import Node
from sunset_ros.parameter import Parameter
from sunset_ros.publisher import Publisher
from sunset_ros.subscription import Subscription
from sunset_ros.task import Future
from sunset_ros.texts import shorten, shown, suggestion
from sunset_ros.timer import Timer

_ResponseT = TypeVar("_ResponseT")


class ManagingSystem(Node):
    """A managing system: subclass it and write `adapt`.

    The monitor publishes the symptoms of the managed system on `/blackboard_group`, ten times a second. Once the
    managed system is up, `adapt` is called every 0.2 s of the experiment's time with the latest symptoms. It decides
    and calls any of

    - `set_parameter(node, name, value)`: reparametrisation,
    - `change_topic(node, parameter, topic)`: change of communication,
    - `activate(node)`, `deactivate(node)`: addition and removal of components,
    - `restart(node)`: deactivate, then activate,
    - `redeploy(node)`: end the node's process and start a new process.

    Nodes are `camera`, `depth`, `image_enhancement`, `sensor_fusion` and `segmentation`. These methods return at once;
    they return a future whose result says whether the managed system accepted the request. Never block on it: look at
    it in a later call of `adapt`, add a callback to it, or write `async def adapt` and `await` it.

    Example:
        A managing system that focuses the camera when its images are blurred::

            class Refocus(ManagingSystem):
                def adapt(self, symptoms):
                    if symptoms.autofocus_needed:
                        self.set_parameter("camera", "perform_autofocus", True)

    It is an ordinary node, which can use the rest of the graph too. A run is not scored if it reads the truth: the
    recorded labels, the evaluation, the injections, the fault parameters.

    Parameters:
        entropy_threshold: entropy above which the segmentation counts as unsure; in an experiment, the model's
            threshold.
        period: seconds between two calls of `adapt`; 0.2 in every experiment. Read once, at the start.
        task: `repair`; or `diagnose`, in which all adaptations are refused. Read once, at the start.
        thinking: seconds that every decision to adapt takes, as in `think`. Read once, at the start.
    """

    node_name: ClassVar[str] = MANAGING_SYSTEM
    """The node's name; a subclass may have its own."""

    def __init__(
        self,
        *,
        context: Context | None = None,
        cli_args: list[str] | None = None,
        parameter_overrides: list[Parameter] | None = None,
    ) -> None:
        try:
            super().__init__(
                self.node_name, context=context, cli_args=cli_args, parameter_overrides=parameter_overrides
            )
        except NotInitializedException as error:
            name = type(self).__name__
            raise NotInitializedException(
                f"{name}() makes a node, before which init() must be called; to run it, pass the class {name}, not an "
                "instance."
            ) from error
        # Two underscores: out of the way of a subclass's own attributes.
        period_s = self.__declare_parameters()
        self.__blackboard: dict[str, Value] = {}
        self.__callers: dict[str, AnyClient] = {}
        self.__diagnoses: Publisher[Diagnosis] | None = None
        self.__costs: Publisher[Cost] | None = None
        self.__charged = False  # whether that time was added for the present decision
        self.__thought: Timer | None = None
        self.__decided: list[Callable[[], None]] = []  # while it thinks
        self.__adapting = self.__acted = False
        self.__symptoms = self.create_subscription(
            SetBlackboardGroup, BLACKBOARD_TOPIC, self.__on_blackboard, 10
        )
        self.create_timer(period_s, self.__decide)
        self.on_start()

    def on_start(self) -> None:
        """Prepare for `adapt`; called once. Override it instead of the constructor."""

    def adapt(self, symptoms: Symptoms) -> None:
        """Decide how to react to the symptoms, and do it; override this.

        Args:
            symptoms: of the managed system now. Values that are not measured are False or NaN, never None.
        """
        raise NotImplementedError(f"{type(self).__name__} has no method adapt.")

    @property
    def symptoms_subscription(self) -> Subscription[SetBlackboardGroup]:
        """The subscription to the symptoms."""
        return self.__symptoms

    @property
    def now_s(self) -> float:
        """The experiment's time [s]; its 0 lies before the faults come."""
        return self.get_clock().now().nanoseconds / 1e9

    @property
    def greeting(self) -> dict[str, object]:
        """The first line that a program gets: nodes, signals with thresholds, adaptations, the task, the seed."""
        given = {name: parameter.value for name, parameter in self._parameter_overrides.items()}
        return make_greeting(
            cast("float", self.get_parameter("period").value),
            given | {"entropy_threshold": self.entropy_threshold},
        )

    @property
    def entropy_threshold(self) -> float:
        """The entropy above which the segmentation counts as unsure."""
        return cast("float", self.get_parameter("entropy_threshold").value)

    def set_parameter(self, node: str, name: str, value: Value | Sequence[Value]) -> Future[bool]:
        """Set a parameter of a managed node.

        Args:
            node: the node, such as `camera`.
            name: the parameter, such as `perform_autofocus`.
            value: the new value; its type must be the parameter's, so `1.0` for a float.

        Returns:
            A future: whether the node accepted it. If not, the reason is logged.
        """
        parameter = Parameter(name, value=value)
        request = SetParameters.Request(parameters=[parameter.to_parameter_msg()])

        def accepted(response: SetParameters.Response) -> bool:
            refusals = [result.reason for result in response.results if not result.successful]
            for reason in refusals:
                self.get_logger().warning(f"{node} refused {name} = {shorten(repr(value))}: {reason}")
            return not refusals

        return self.__call(SetParameters, f"{full_name(node)}/set_parameters", request, accepted)

    def change_topic(self, node: str, parameter: str, topic: str) -> Future[bool]:
        """Let a node subscribe to another topic.

        Args:
            node: the node, such as `sensor_fusion`.
            parameter: the parameter that names the topic, such as `topic_camera_input`.
            topic: the topic, such as `rgb_enhanced`.

        Returns:
            A future: whether the node accepted it.
        """
        return self.set_parameter(node, parameter, topic)

    def activate(self, node: str) -> Future[bool]:
        """Add a node to the running system, through its lifecycle.

        Returns:
            A future: whether the node is active now.
        """
        return self.__transition(node, Transition.TRANSITION_ACTIVATE, "activate")

    def deactivate(self, node: str) -> Future[bool]:
        """Remove a node from the running system, through its lifecycle; its process goes on.

        Returns:
            A future: whether the node is inactive now.
        """
        return self.__transition(node, Transition.TRANSITION_DEACTIVATE, "deactivate")

    def restart(self, node: str) -> Future[bool]:
        """Deactivate a node, then activate it.

        Returns:
            A future: whether both were accepted. The node is activated even if it was not active before.
        """
        result: Future[bool] = Future()

        def deactivated(deactivation: Future[bool]) -> None:
            outcome = deactivation.result() is True
            activation = self.__transition(node, Transition.TRANSITION_ACTIVATE, "activate", at_once=True)
            activation.add_done_callback(lambda done: result.set_result(outcome and done.result() is True))

        self.deactivate(node).add_done_callback(deactivated)
        return result

    def redeploy(self, node: str) -> Future[bool]:
        """End a node's process and start a new process, which needs the node's activation delay.

        Returns:
            A future: whether the launcher accepted it.
        """

        def accepted(response: Redeploy.Response) -> bool:
            if not response.success:
                self.get_logger().warning(f"{node} is not redeployed: {response.message}")
            return response.success

        return self.__call(Redeploy, "/launcher/redeploy", Redeploy.Request(node=base_name(node)), accepted)

    def think(self, seconds: float) -> None:
        """Delay the adaptations that follow, as if deciding on them took time; several calls add up.

        Meanwhile `adapt` is not called. Call it before the adaptations that it delays.

        Args:
            seconds: of the experiment's time, from 0 to 3600.

        Raises:
            ValueError: it is not such a number.
            RuntimeError: this call of `adapt` has requested an adaptation whose outcome it has not awaited.
        """
        if not is_number(seconds, LONGEST_THOUGHT_S):
            raise ValueError(
                f"The time to think must be a number of seconds from 0 to {LONGEST_THOUGHT_S:g}, got {shown(seconds)}."
            )
        if self.__acted:
            raise RuntimeError("think must be called before the adaptations that it delays")
        if seconds:
            self.__think(float(seconds))

    def diagnose(self, probabilities: Mapping[str, float]) -> None:
        """Publish a diagnosis on `/managing_system/diagnosis`, for the record; it changes nothing.

        Args:
            probabilities: fault → the probability that it is there, from 0 to 1.

        Raises:
            ValueError: a fault's name is not a text, or a probability is not such a number.
        """
        message = diagnosis_message(probabilities)
        message.stamp = self.get_clock().now().to_msg()
        if self.__diagnoses is None:
            self.__diagnoses = self.create_publisher(Diagnosis, DIAGNOSIS_TOPIC, 10)
        self.__diagnoses.publish(message)

    def spend(self, *, model: str = "", tokens_in: int = 0, tokens_out: int = 0, price: float = 0.0) -> None:
        """Publish on `/managing_system/cost` what a decision has cost, for the record; it changes nothing.

        Args:
            model: the language model that was asked, in at most 100 characters.
            tokens_in: the length of the questions, from 0 to 1e9.
            tokens_out: the length of the answers, likewise.
            price: in a currency of your choice, from 0 to 1e6.

        Raises:
            ValueError: a value has the wrong type, or is out of range.
        """
        self.__publish_cost(cost_message(model, tokens_in, tokens_out, price))

    def __publish_cost(self, message: Cost) -> None:
        message.stamp = self.get_clock().now().to_msg()
        if self.__costs is None:
            self.__costs = self.create_publisher(Cost, COST_TOPIC, 10)
        self.__costs.publish(message)

    def __declare_parameters(self) -> float:
        """Declare the parameters; return the period [s]."""
        description = "entropy above which the segmentation counts as unsure"
        self.__declare("entropy_threshold", DEFAULT_ENTROPY_THRESHOLD, description)
        period_s = self.__declare("period", 0.2, "seconds between two decisions", (0.01, 60.0))
        self.__may_adapt = self.declare_parameter("task", REPAIR).value == REPAIR
        self.__charge_s = 0.0  # the time that each decision to adapt takes
        if "thinking" in self._parameter_overrides:
            description = "seconds that every decision to adapt takes"
            self.__charge_s = self.__declare("thinking", 0.0, description, (0.0, LONGEST_THOUGHT_S))
        return period_s

    def __declare(
        self, name: str, default: float, description: str, limits: tuple[float, float] | None = None
    ) -> float:
        """Declare a number as a parameter, which is read-only if it has limits; return its value."""
        ranges = [FloatingPointRange(from_value=limits[0], to_value=limits[1])] if limits else []
        descriptor = ParameterDescriptor(
            description=description, read_only=bool(limits), floating_point_range=ranges
        )
        return cast("float", self.declare_parameter(name, default, descriptor).value)

    def __on_blackboard(self, message: SetBlackboardGroup) -> None:
        self.__blackboard.update(read_parameters(message.bb_params))

    async def __decide(self) -> None:
        """Call `adapt`, which may be a coroutine, if the managed system is up and `think` delays nothing."""
        symptoms = Symptoms(self.__blackboard, entropy_threshold=self.entropy_threshold)
        if not symptoms.up or self.__thought is not None:
            return
        adapt: Callable[[Symptoms], object] = self.adapt
        self.__adapting, self.__acted = True, False
        try:
            outcome = adapt(symptoms)
            if isgenerator(outcome) or isasyncgen(outcome):
                raise TypeError("adapt contains yield, so that calling it does nothing")
            if iscoroutine(outcome):
                await outcome
        finally:
            self.__adapting = self.__acted = False

    def __think(self, seconds: float) -> None:
        self.__publish_cost(Cost(think_s=seconds))
        if self.__thought is not None:
            seconds += max(0, self.__thought.time_until_next_call() or 0) / 1e9
            self.destroy_timer(self.__thought)
        self.__thought = self.create_timer(seconds, self.__act)

    def __act(self) -> None:
        """Send the requests that `think` has delayed."""
        if self.__thought is not None:
            self.destroy_timer(self.__thought)
        self.__thought, self.__charged = None, False
        decided, self.__decided = self.__decided, []
        for send in decided:
            send()

    def __do(self, send: Callable[[], None]) -> None:
        """Send a request now, or after the time to think."""
        if self.__charge_s and not self.__charged:
            self.__charged = True
            self.__think(self.__charge_s)
        if self.__thought is None:
            self.__acted = self.__adapting
            send()
        else:
            self.__decided.append(send)

    def __transition(self, node: str, transition: int, label: str, *, at_once: bool = False) -> Future[bool]:
        request = ChangeState.Request(transition=Transition(id=transition, label=label))
        service = f"{full_name(node)}/change_state"

        def accepted(response: ChangeState.Response) -> bool:
            return response.success

        return self.__call(ChangeState, service, request, accepted, at_once=at_once)

    def __call(
        self,
        service: type[Any],
        name: str,
        request: object,
        outcome: Callable[[_ResponseT], bool],
        *,
        at_once: bool = False,
    ) -> Future[bool]:
        """Call a service; the future has the outcome of its response. `at_once` ignores the time to think."""
        result: Future[bool] = Future()
        if not self.__may_adapt:
            self.get_logger().warning(f"{name} is not called: the task is to diagnose, without adaptations.")
            result.set_result(False)
            return result

        def answered(done: Future[_ResponseT]) -> None:
            self.__acted = False  # a coroutine that has awaited it may think again
            result.set_result(outcome(cast("_ResponseT", done.result())))

        def send() -> None:
            if name not in self.__callers:
                self.__callers[name] = self.create_client(service, name)
            if not self.__callers[name].service_is_ready():
                node = base_name(name.rpartition("/")[0])
                nodes = current_system().nodes
                hint = "" if node in nodes else f": {suggestion(node, nodes)}name one of {', '.join(nodes)}"
                self.get_logger().warning(f"No node offers {name} now, so the request is lost{hint}.")
            self.__callers[name].call_async(request).add_done_callback(answered)

        if at_once:
            send()
        else:
            self.__do(send)
        return result
