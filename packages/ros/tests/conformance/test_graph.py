import pytest

from conformance.harness import Harness
from sunset_ros.exceptions import NodeNameNonExistentError
from sunset_ros.qos import DurabilityPolicy, ReliabilityPolicy

PARAMETER_SERVICES = {
    "describe_parameters": "rcl_interfaces/srv/DescribeParameters",
    "get_parameter_types": "rcl_interfaces/srv/GetParameterTypes",
    "get_parameters": "rcl_interfaces/srv/GetParameters",
    "list_parameters": "rcl_interfaces/srv/ListParameters",
    "set_parameters": "rcl_interfaces/srv/SetParameters",
    "set_parameters_atomically": "rcl_interfaces/srv/SetParametersAtomically",
}
LIFECYCLE_SERVICES = {
    "change_state": "lifecycle_msgs/srv/ChangeState",
    "get_available_states": "lifecycle_msgs/srv/GetAvailableStates",
    "get_available_transitions": "lifecycle_msgs/srv/GetAvailableTransitions",
    "get_state": "lifecycle_msgs/srv/GetState",
    "get_transition_graph": "lifecycle_msgs/srv/GetAvailableTransitions",
}


def test_nodes_come_and_go(harness: Harness) -> None:
    assert harness.node.get_node_names_and_namespaces() == [("tester", "/")]
    harness.start("Talker", "-r", "__ns:=/uav")
    assert harness.spin(lambda: ("talker", "/uav") in harness.node.get_node_names_and_namespaces())
    harness.kill("Talker")
    assert harness.spin(lambda: harness.node.get_node_names() == ["tester"], 20.0)
    assert harness.spin(lambda: harness.node.count_publishers("/uav/chatter") == 0, 20.0)


def nodes_that_publish(harness: Harness, topic: str) -> list[str]:
    return [info.node_name for info in harness.node.get_publishers_info_by_topic(topic)]


def test_topics_are_listed_with_their_types_and_endpoints(harness: Harness) -> None:
    harness.start("Talker")
    # endpoints are found in whatever order, and their nodes' names after them
    names = ("/chatter", "/talker/name", "/parameter_events", "/rosout")
    assert harness.spin(lambda: all("talker" in nodes_that_publish(harness, name) for name in names))
    assert harness.node.count_publishers("/chatter") == 1
    topics = dict(harness.node.get_topic_names_and_types())
    assert topics["/chatter"] == ["std_msgs/msg/String"]
    assert topics["/parameter_events"] == ["rcl_interfaces/msg/ParameterEvent"]
    assert topics["/rosout"] == ["rcl_interfaces/msg/Log"]
    (info,) = harness.node.get_publishers_info_by_topic("/talker/name")
    assert (info.node_name, info.node_namespace, info.topic_type) == ("talker", "/", "std_msgs/msg/String")
    assert info.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL
    assert info.qos_profile.reliability is ReliabilityPolicy.RELIABLE
    assert len(info.endpoint_gid) == 16
    assert harness.node.get_subscriptions_info_by_topic("/chatter") == []
    assert harness.node.count_subscribers("/chatter") == 0


def start(harness: Harness, node: str) -> None:
    """Start a node, and wait until it is known: rclpy raises when asked about one that is not."""
    harness.start(node)
    assert harness.spin(lambda: node.lower() in harness.node.get_node_names())


def test_a_node_that_is_not_there_cannot_be_asked_about(harness: Harness) -> None:
    with pytest.raises(NodeNameNonExistentError, match="no node 'nobody' in the namespace '/uav'"):
        harness.node.get_publisher_names_and_types_by_node("nobody", "/uav")


def test_a_node_offers_the_services_of_every_node(harness: Harness) -> None:
    start(harness, "Talker")
    expected = [(f"/talker/{name}", [kind]) for name, kind in sorted(PARAMETER_SERVICES.items())]
    assert harness.spin(lambda: harness.node.get_service_names_and_types_by_node("talker", "/") == expected)


def test_a_lifecycle_node_offers_the_lifecycle_services_too(harness: Harness) -> None:
    start(harness, "Managed")
    both = {**PARAMETER_SERVICES, **LIFECYCLE_SERVICES}
    expected = [(f"/managed/{name}", [both[name]]) for name in sorted(both)]
    assert harness.spin(lambda: harness.node.get_service_names_and_types_by_node("managed", "/") == expected)
    offered = harness.node.get_service_names_and_types()
    assert set(map(str, expected)) <= set(map(str, offered))
    published = dict(harness.node.get_publisher_names_and_types_by_node("managed", "/"))
    assert published["/managed/transition_event"] == ["lifecycle_msgs/msg/TransitionEvent"]


def test_clients_and_subscriptions_of_a_node_are_listed(harness: Harness) -> None:
    start(harness, "Server")
    start(harness, "Echo")
    wanted = [("/server/set", ["std_srvs/srv/SetBool"])]
    assert harness.spin(lambda: harness.node.get_client_names_and_types_by_node("server", "/") == wanted)
    wanted = [("/images_in", ["sensor_msgs/msg/Image"])]
    assert harness.spin(lambda: harness.node.get_subscriber_names_and_types_by_node("echo", "/") == wanted)
