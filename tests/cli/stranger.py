"""A node that is not SUNSET's, as a process: it publishes a type that SUNSET does not know, and a notice."""

import sys
from typing import Self

from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.interfaces.std_srvs.srv import SetBool
from sunset_ros.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sunset_ros.rmw.dds import CycloneDDS


class Odd(String):
    """A message that only this process knows."""

    __slots__ = ()
    __ros_name__ = "odd_msgs/msg/Odd"

    def copy(self) -> Self:
        raise NotImplementedError


def answer(request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
    response.success = request.data
    response.message = "granted" if request.data else "denied"
    return response


if __name__ == "__main__":
    context = Context()
    # a distribution that announces no hashes of types, of which this one has none
    context.init([], middleware=CycloneDDS(domain_id=int(sys.argv[1]), distro="humble", environment={}))
    node = Node("stranger", context=context, start_parameter_services=False, enable_rosout=False)
    node.create_publisher(Odd, "/odd", 10)
    kept = QoSProfile(
        depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.BEST_EFFORT
    )
    notice = node.create_publisher(String, "/notice", kept)
    node.create_timer(0.1, lambda: notice.publish(String(data="wet paint")))
    node.create_publisher(String, "/_hidden", 10)
    node.create_publisher(String, "/silent", 10)
    node.create_service(SetBool, "/grant", answer)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    executor.spin()
