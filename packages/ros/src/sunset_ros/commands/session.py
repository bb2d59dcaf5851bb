"""A process on the graph for one command: it waits for nodes and calls services."""

import argparse
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from typing import Any, Final, TypeVar

from sunset_ros._node_graph import names_and_types
from sunset_ros.context import Context
from sunset_ros.executors import SingleThreadedExecutor
from sunset_ros.interfaces import Message, Service
from sunset_ros.interruption import held_signals
from sunset_ros.names import validate_topic_name
from sunset_ros.node import Node
from sunset_ros.qos import QoSProfile, qos_profile_services_default
from sunset_ros.rmw.backends import live_middleware
from sunset_ros.rmw.core.node import Middleware
from sunset_ros.rmw.core.port import EndpointInfo, EndpointKind, qualified_name

_QUIET_S: Final = 0.5
"""The graph is complete when nothing new has been seen for so long."""

_LOOK_S: Final = 0.05
_STEP_S: Final = 0.1
"""How long may pass until a signal is handled."""

_ANSWER_S: Final = 10.0
"""How long a service may take to answer."""

T = TypeVar("T")


class NotThereError(Exception):
    """A name that is not on the graph, or a request that was refused; the text is one sentence."""


class Session:
    """A process on the graph, for one command; others have `timeout_s` to be found.

    `check_signals` raises what a signal that has come asks for; it is called wherever this waits.
    """

    def __init__(self, middleware: Middleware, timeout_s: float, check_signals: Callable[[], None]) -> None:
        self._middleware = middleware
        self._timeout_s = timeout_s
        self._check_signals = check_signals
        self._context = Context()
        self._context.init([], middleware=middleware)
        self._executor = SingleThreadedExecutor(context=self._context)

    @cached_property
    def node(self) -> Node:
        """A node to ask and listen with, which others take for a hidden one."""
        name = f"_sunset_ros_{os.getpid()}"
        node = Node(name, context=self._context, enable_rosout=False, start_parameter_services=False)
        self._executor.add_node(node)
        return node

    @property
    def now_s(self) -> float:
        """A clock that never jumps, in seconds."""
        return self._middleware.steady_ns() / 1e9

    def spin_once(self, timeout_s: float = _STEP_S) -> None:
        """Run a callback that comes within this time, and within a step that is short enough to react to signals."""
        self._check_signals()
        self._executor.spin_once(min(timeout_s, _STEP_S))

    # What is there

    def nodes(self) -> list[str]:
        """Return the full names of all nodes."""
        return [qualified_name(namespace, name) for name, namespace in self._middleware.nodes()]

    def endpoints(self, name: str | None = None, kinds: Sequence[EndpointKind] = ()) -> list[EndpointInfo]:
        """Return all endpoints, or those of one topic or service, or only of some kinds."""
        found = self._middleware.endpoints(name)
        return [info for info in found if not kinds or info.kind in kinds]

    def names_and_types(self, *kinds: EndpointKind, node: str = "") -> dict[str, list[str]]:
        """Return name → types of all endpoints of some kinds, or those of one node, sorted."""
        return names_and_types(
            info
            for info in self.endpoints(kinds=kinds)
            if not node or qualified_name(info.node_namespace, info.node_name) == node
        )

    # Waiting

    def look_around(self) -> None:
        """Wait until nothing new is found for a while, at most for the session's timeout."""
        end_s = self.now_s + self._timeout_s
        known: object = None
        quiet_since_s = self.now_s
        while (now_s := self.now_s) < min(end_s, quiet_since_s + _QUIET_S):
            seen = (self.nodes(), self.endpoints())
            if seen != known:
                known, quiet_since_s = seen, now_s
            threading.Event().wait(_LOOK_S)
            self._check_signals()

    def find(self, look: Callable[[], T], complaint: str) -> T:
        """Wait until `look()` is true, and return it; raise a `NotThereError` after the session's timeout."""
        found = look()

        def seen() -> bool:
            nonlocal found
            self._check_signals()
            found = look()
            return bool(found)

        if not self._middleware.wait_for(seen, round(self._timeout_s * 1e9)):
            raise NotThereError(complaint)
        return found

    def find_node(self, name: str) -> str:
        """Return the full name of a node once it is there; see `find`."""
        full = absolute(name)
        self.find(lambda: full in self.nodes(), f"Unable to find node {full!r}.")
        return full

    # Asking

    def ask(
        self,
        service_type: type[Service],
        name: str,
        request: Message,
        qos: QoSProfile = qos_profile_services_default,
    ) -> Any:
        """Return the response of a service; raise a `NotThereError` if it is not there or does not answer."""
        client = self.node.create_client(service_type, name, qos_profile=qos)
        try:
            kind = service_type.__ros_name__
            self.find(client.service_is_ready, f"The service {name} of type {kind} is not available.")
            future = client.call_async(request)
            end_s = self.now_s + _ANSWER_S
            while not future.done():
                if self.now_s >= end_s:
                    raise NotThereError(f"The service {name} did not answer within {_ANSWER_S:g} s.")
                self.spin_once()
            return future.result()
        finally:
            self.node.destroy_client(client)


@contextmanager
def session(arguments: argparse.Namespace) -> Iterator[Session]:
    """Join the graph as the options say; leave it at the end, on Ctrl-C and SIGTERM too."""
    with (
        held_signals() as check,
        live_middleware().join(domain_id=arguments.domain_id, network=arguments.network) as middleware,
    ):
        yield Session(middleware, arguments.timeout, check)


def absolute(name: str) -> str:
    """Return the full form of a valid name; a name without a leading slash is in the root namespace.

    >>> absolute("managed_subsystem/camera")
    '/managed_subsystem/camera'
    """
    full = name if name.startswith("/") else f"/{name}"
    validate_topic_name(full)
    return full


def hidden(name: str) -> bool:
    """Return whether a name is one that lists leave out: a part of it starts with an underscore.

    >>> hidden("/_ros2cli_1"), hidden("/uav/camera")
    (True, False)
    """
    return "/_" in name
