from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.rmw.core.port import EndpointKind
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.sim import Simulation


def test_the_graph_tells_what_a_node_consists_of() -> None:
    sim = Simulation()
    node = sim.create_process("process").create_node("node", "/")
    node.create_publisher(String, "/out", QoSProfile())
    node.create_subscription(String, "/in", QoSProfile(), lambda _: None, label="in")
    found = [(info.kind, info.node_name, info.name, info.type_name) for info in sim.endpoints()]
    assert found == [
        (EndpointKind.PUBLISHER, "node", "/out", "std_msgs/msg/String"),
        (EndpointKind.SUBSCRIPTION, "node", "/in", "std_msgs/msg/String"),
    ]


def test_nodes_are_listed_by_name_however_they_came() -> None:
    sim = Simulation()
    process = sim.create_process("several")
    for name, namespace in (("z", "/"), ("b", "/uav"), ("a", "/uav"), ("y", "/")):
        process.create_node(name, namespace)
    assert list(process.nodes()) == [("a", "/uav"), ("b", "/uav"), ("y", "/"), ("z", "/")]
    assert sim.node_names() == ["/uav/a", "/uav/b", "/y", "/z"]
