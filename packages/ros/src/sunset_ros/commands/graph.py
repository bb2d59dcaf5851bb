"""The verbs that list and describe parts of the graph."""

import argparse

from sunset_ros._node_graph import TOPIC_KINDS
from sunset_ros.commands.session import NotThereError, Session, absolute, hidden, session
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind
from sunset_ros.rmw.core.qos import HistoryPolicy

_SECTIONS = {
    "Subscribers": EndpointKind.SUBSCRIPTION,
    "Publishers": EndpointKind.PUBLISHER,
    "Service Servers": EndpointKind.SERVICE,
    "Service Clients": EndpointKind.CLIENT,
}


def node_list(arguments: argparse.Namespace) -> None:
    """Print the names of all nodes."""
    with session(arguments) as graph:
        graph.look_around()
        for name in graph.nodes():
            if not hidden(name):
                print(name)


def node_info(arguments: argparse.Namespace) -> None:
    """Print what a node consists of."""
    with session(arguments) as graph:
        node = graph.find_node(arguments.node)
        graph.look_around()
        print(node)
        for title, kind in _SECTIONS.items():
            print(f"  {title}:")
            parts = graph.names_and_types(kind, node=node)
            print("\n".join(f"    {name}: {', '.join(types)}" for name, types in parts.items()))


def topic_list(arguments: argparse.Namespace) -> None:
    """Print the names of all topics."""
    with session(arguments) as graph:
        _print_list(graph, arguments, *TOPIC_KINDS)


def service_list(arguments: argparse.Namespace) -> None:
    """Print the names of all services."""
    with session(arguments) as graph:
        _print_list(graph, arguments, EndpointKind.SERVICE)


def topic_info(arguments: argparse.Namespace) -> None:
    """Print who publishes on a topic, and who subscribes to it."""
    topic = absolute(arguments.topic)
    with session(arguments) as graph:
        graph.look_around()
        infos = graph.endpoints(topic, TOPIC_KINDS)
    if not infos:
        raise NotThereError(f"Unknown topic {topic!r}.")
    end = "\n\n" if arguments.verbose else "\n"
    print(f"Type: {', '.join(sorted({info.type_name for info in infos}))}", end=end)
    for title, kind in zip(("Publisher", "Subscription"), TOPIC_KINDS, strict=True):
        chosen = [info for info in infos if info.kind is kind]
        print(f"{title} count: {len(chosen)}", end=end)
        if arguments.verbose:
            for info in chosen:
                print(_described(info), end=end)


def _print_list(graph: Session, arguments: argparse.Namespace, *kinds: EndpointKind) -> None:
    graph.look_around()
    for name, types in graph.names_and_types(*kinds).items():
        if not hidden(name):
            print(f"{name} [{', '.join(types)}]" if arguments.show_types else name)


def _described(info: EndpointInfo) -> str:
    qos = info.qos
    history = qos.history.name
    if qos.history is HistoryPolicy.KEEP_LAST:
        history += f" ({qos.depth})"
    lifespan = "Infinite" if qos.lifespan_ns is None else f"{qos.lifespan_ns} nanoseconds"
    return (
        f"Node name: {info.node_name}\n"
        f"Node namespace: {info.node_namespace}\n"
        f"Topic type: {info.type_name}\n"
        f"Endpoint type: {info.kind.name}\n"
        f"GID: {'.'.join(f'{byte:02x}' for byte in info.gid)}\n"
        "QoS profile:\n"
        f"  Reliability: {qos.reliability.name}\n"
        f"  History (Depth): {history}\n"
        f"  Durability: {qos.durability.name}\n"
        f"  Lifespan: {lifespan}"
    )
