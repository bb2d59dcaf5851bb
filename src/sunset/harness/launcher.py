"""The launcher: ends the processes of managed nodes and starts others when a managing system asks for it."""

from collections.abc import Callable, Sequence
from typing import Protocol

from sunset.system import NAMESPACE
from sunset.system_interfaces.srv import Redeploy
from sunset.texts.names import base_name
from sunset_ros.client import AnyClient
from sunset_ros.context import Context
from sunset_ros.interfaces.lifecycle_msgs.msg import Transition
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.node import Node
from sunset_ros.texts import shorten, suggestion
from sunset_ros.timer import Timer

_GRACE_S = 1.0
"""How long a node may take to shut down through its lifecycle before its process is killed."""


class ProcessHost(Protocol):
    """Starts and ends the processes of nodes, which are simulated or of the operating system."""

    on_exit: Callable[[str], object]
    """Called with the node whenever a process has ended."""

    def start(self, node: str) -> None:
        """Start a new process for `node`, a short name such as `camera`; it must not be running."""

    def is_running(self, node: str) -> bool:
        """Return whether the process of `node` exists."""

    def kill(self, node: str) -> None:
        """End the process of `node` at once."""


class Launcher(Node):
    """Serves `/launcher/redeploy`: lifecycle shutdown, end of the process, a new process.

    A node whose process has ended stays dead until a managing system redeploys it. The new node waits its
    `lifecycle_activation_delay` before it is active (paper, section 3.4), from the moment at which it knows the time.
    Live, the end of the old process and the start of the new process take a fraction of a second more; simulated, they
    take no time.
    """

    def __init__(self, host: ProcessHost, nodes: Sequence[str], *, context: Context | None = None) -> None:
        super().__init__("launcher", context=context)
        self._host = host
        self._nodes = tuple(nodes)
        self._redeploying: dict[str, Timer] = {}
        self._shutdown_clients: dict[str, AnyClient] = {
            node: self.create_client(ChangeState, f"{NAMESPACE}/{node}/change_state") for node in nodes
        }
        host.on_exit = self._on_exit
        self.create_service(Redeploy, "~/redeploy", self._redeploy)

    def _redeploy(self, request: Redeploy.Request, response: Redeploy.Response) -> Redeploy.Response:
        node = base_name(request.node)
        if node not in self._nodes:
            response.message = (
                f"No node of the managed system is named {shorten(repr(request.node))}: "
                f"{suggestion(node, self._nodes)}name one of {', '.join(self._nodes)}."
            )
            return response
        response.success = node not in self._redeploying
        if not response.success:
            response.message = f"{node} is being redeployed already."
        elif not self._host.is_running(node):
            self._host.start(node)
            response.message = f"{node} was not running and is started."
        else:
            # the end of the process cancels the timer
            self._redeploying[node] = self.create_timer(_GRACE_S, lambda: self._host.kill(node))
            shutdown = ChangeState.Request(transition=Transition(label="shutdown"))
            self._shutdown_clients[node].call_async(shutdown)
            response.message = f"{node} is shut down and started again."
        return response

    def _on_exit(self, node: str) -> None:
        if node in self._redeploying:
            self.destroy_timer(self._redeploying.pop(node))
            self._host.start(node)
