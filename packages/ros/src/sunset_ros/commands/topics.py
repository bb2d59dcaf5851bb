"""The verb `topic`: listening."""

import argparse
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from itertools import pairwise
from statistics import fmean, pstdev
from typing import Final

from sunset_ros.commands.messages import message_to_yaml
from sunset_ros.commands.session import Session, absolute, session
from sunset_ros.errors import InterfaceError, InvalidInputError
from sunset_ros.interfaces import Message, get_message
from sunset_ros.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind

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
    """Listen to a topic, as reliably as all its publishers allow.

    Raises:
        NotThereError: nothing publishes on it.
        InvalidInputError: its type is unknown here.
    """
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
