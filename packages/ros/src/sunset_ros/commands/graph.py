"""The verbs that list and describe parts of the graph, and listen to topics."""

import argparse
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from itertools import pairwise
from statistics import fmean, pstdev
from typing import Final

from sunset_ros._node_graph import TOPIC_KINDS
from sunset_ros.commands.messages import message_to_yaml
from sunset_ros.commands.session import NotThereError, Session, absolute, hidden, session
from sunset_ros.errors import InterfaceError, InvalidInputError
from sunset_ros.interfaces import Message, get_message
from sunset_ros.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
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
    _print_list(arguments, *TOPIC_KINDS)


def service_list(arguments: argparse.Namespace) -> None:
    """Print the names of all services."""
    _print_list(arguments, EndpointKind.SERVICE)


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


def _print_list(arguments: argparse.Namespace, *kinds: EndpointKind) -> None:
    with session(arguments) as graph:
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


_REPORT_S: Final = 1.0
_WINDOW: Final = 10_000
"""Messages over which the rate is averaged."""


def topic_echo(arguments: argparse.Namespace) -> None:
    """Print the messages on a topic until Ctrl-C, or one."""
    with suppress(KeyboardInterrupt), session(arguments) as graph:
        messages: list[Message] = []
        _subscribe(graph, arguments.topic, messages.append)
        while True:
            graph.spin_once()
            while messages:  # printed here, since what a callback raises is taken for a fault of the node
                text = message_to_yaml(messages.pop(0), arrays=not arguments.no_arr)
                print(f"{text}---", flush=True)
                if arguments.once:
                    return


def topic_hz(arguments: argparse.Namespace) -> None:
    """Print every second how often messages come on a topic, until Ctrl-C."""
    with suppress(KeyboardInterrupt), session(arguments) as graph:
        times: deque[float] = deque(maxlen=_WINDOW + 1)
        _subscribe(graph, arguments.topic, lambda _: times.append(graph.now_s))
        printed = None
        due_s = graph.now_s + _REPORT_S
        while True:
            graph.spin_once(max(0.0, due_s - graph.now_s))
            if graph.now_s < due_s:
                continue
            due_s += _REPORT_S
            if len(times) > 1 and times[-1] != printed:
                printed = times[-1]
                print(rate_text(times), flush=True)


def rate_text(times: Iterable[float]) -> str:
    r"""Return how often messages came, as `ros2 topic hz` says it, from at least two increasing times in seconds.

    >>> rate_text([1.0, 1.1, 1.2])
    'average rate: 10.000\n\tmin: 0.100s max: 0.100s std dev: 0.00000s window: 3'
    """
    moments = list(times)
    gaps = [after - before for before, after in pairwise(moments)]
    return (
        f"average rate: {1 / fmean(gaps):.3f}\n"
        f"\tmin: {min(gaps):.3f}s max: {max(gaps):.3f}s std dev: {pstdev(gaps):.5f}s window: {len(moments)}"
    )


def _subscribe(graph: Session, name: str, callback: Callable[[Message], object]) -> None:
    """Listen to a topic, as reliably as all its publishers allow."""
    topic = absolute(name)
    publishers = graph.find(
        lambda: graph.endpoints(topic, [EndpointKind.PUBLISHER]),
        f"Topic {topic!r} does not appear to be published; 'topic list' shows the others.",
    )
    type_name = publishers[0].type_name
    try:
        kind = get_message(type_name)
    except InterfaceError as error:
        raise InvalidInputError(
            f"Messages on {topic} are {type_name}, a type that no installed package defines: they cannot be read."
        ) from error
    graph.node.create_subscription(kind, topic, callback, _matching(publishers))


def _matching(publishers: list[EndpointInfo]) -> QoSProfile:
    offered = [info.qos for info in publishers]
    reliable = all(qos.reliability is ReliabilityPolicy.RELIABLE for qos in offered)
    kept = all(qos.durability is DurabilityPolicy.TRANSIENT_LOCAL for qos in offered)
    return QoSProfile(
        depth=100,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if kept else DurabilityPolicy.VOLATILE,
    )
