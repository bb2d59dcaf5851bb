"""Nodes that every middleware must be able to run, each in a process of its own.

They share nothing with the tests but the network.
"""

from collections.abc import Callable

from sunset_ros.context import Context
from sunset_ros.interfaces.diagnostic_msgs.msg import KeyValue
from sunset_ros.interfaces.rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import Header, String
from sunset_ros.interfaces.std_srvs.srv import SetBool, Trigger
from sunset_ros.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from sunset_ros.node import Node
from sunset_ros.parameter import Parameter
from sunset_ros.qos import DurabilityPolicy, QoSProfile

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Talker(Node):
    """Publishes a counter ten times a second, and once, for late comers, its name."""

    def __init__(self, context: Context) -> None:
        super().__init__("talker", context=context)
        self._count = 0
        self._publisher = self.create_publisher(String, "chatter", 10)
        self.create_publisher(String, "~/name", LATCHED).publish(String(data=self.get_fully_qualified_name()))
        self.create_timer(0.1, self.tick)

    def tick(self) -> None:
        self._count += 1
        self._publisher.publish(String(data=str(self._count)))
        self.get_logger().info(f"said {self._count}")


class Echo(Node):
    """Publishes on `images_out` what comes on `images_in`."""

    def __init__(self, context: Context) -> None:
        super().__init__("echo", context=context)
        self._publisher = self.create_publisher(Image, "images_out", 10)
        self.create_subscription(Image, "images_in", self.on_image, 10)

    def on_image(self, image: Image) -> None:
        image.header.frame_id += "/echo"
        self._publisher.publish(image)


class Server(Node):
    """Offers `~/set`, and `~/ask`, which asks `~/set` itself through two clients before it answers."""

    def __init__(self, context: Context) -> None:
        super().__init__("server", context=context)
        self.create_service(SetBool, "~/set", self.set)
        self.create_service(Trigger, "~/ask", self.ask)
        self.create_service(Trigger, "~/leave", self.leave)
        self._clients = [self.create_client(SetBool, "~/set") for _ in range(2)]

    def set(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = request.data
        response.message = f"set to {request.data}"
        return response

    async def ask(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        answers = [
            await client.call_async(SetBool.Request(data=data))
            for client, data in zip(self._clients, (True, False), strict=True)
        ]
        response.success = all(answer.message for answer in answers)
        response.message = f"asked: {', '.join(answer.message for answer in answers)}"
        return response

    def leave(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self.context.shutdown()
        response.success = True
        return response


class Parametrised(Node):
    """Has parameters of all kinds."""

    def __init__(self, context: Context) -> None:
        super().__init__("parametrised", context=context)
        self.declare_parameter("flag", False)
        self.declare_parameter("topic", "rgb_camera")
        self.declare_parameter("numbers", [1, 2, 3])
        self.declare_parameter("weights", [0.5, 1.5])
        self.declare_parameter("names", ["a", "b"])
        shift = ParameterDescriptor(
            description="Shift in pixels", integer_range=[IntegerRange(from_value=0, to_value=100, step=10)]
        )
        self.declare_parameter("image.shift", 0, shift)
        strength = [FloatingPointRange(from_value=0.0, to_value=1.9)]
        self.declare_parameter("image.strength", 0.0, ParameterDescriptor(floating_point_range=strength))
        self.declare_parameter("fixed", 1, ParameterDescriptor(read_only=True))
        self.declare_parameter("anything", None, ParameterDescriptor(dynamic_typing=True))
        self.declare_parameter("unset", Parameter.Type.STRING)
        self.add_on_set_parameters_callback(self.check)
        self.add_post_set_parameters_callback(self.report)
        self._reports = self.create_publisher(KeyValue, "~/reports", 100)

    def check(self, parameters: list[Parameter]) -> SetParametersResult:
        if any(parameter.value == "forbidden" for parameter in parameters):
            return SetParametersResult(successful=False, reason="It is forbidden.")
        return SetParametersResult(successful=True)

    def report(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            self._reports.publish(KeyValue(key=parameter.name, value=str(parameter.value)))


class Managed(LifecycleNode):
    """Publishes while it is active; its parameters say how its transitions end."""

    def __init__(self, context: Context) -> None:
        super().__init__("managed", context=context)
        self.declare_parameter("activate", "success")
        self.declare_parameter("error", "success")
        self._work = self.create_lifecycle_publisher(String, "~/work", 10)
        self.create_timer(0.1, lambda: self._work.publish(String(data="work")))

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        outcome = self._outcome("activate")
        return super().on_activate(state) if outcome is TransitionCallbackReturn.SUCCESS else outcome

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        super().on_error(state)
        return self._outcome("error")

    def _outcome(self, parameter: str) -> TransitionCallbackReturn:
        return TransitionCallbackReturn[str(self.get_parameter(parameter).value).upper()]


class Clocked(Node):
    """Publishes its time whenever its timer of one second of it expires."""

    def __init__(self, context: Context) -> None:
        super().__init__("clocked", context=context)
        self._times = self.create_publisher(Header, "~/times", 10)
        self.create_timer(1.0, self.tick)

    def tick(self) -> None:
        self._times.publish(Header(stamp=self.get_clock().now().to_msg()))


NODES: dict[str, Callable[[Context], Node]] = {
    node.__name__: node for node in (Clocked, Echo, Managed, Parametrised, Server, Talker)
}
"""By class name, so that a process of its own can be told which one to run."""
