"""The processes of the conformance suite that live outside of the test, each an operating system process of its own."""

import multiprocessing
import socket
import threading
from collections.abc import Sequence

from conformance.nodes import NODES
from sunset_ros import Context, SingleThreadedExecutor
from sunset_ros.rmw.dds import CycloneDDS
from sunset_ros.rmw.remote import Gateway, Pipe, RemoteProcess

PROCESSES = multiprocessing.get_context("forkserver")
PROCESSES.set_forkserver_preload([__name__, "pytest"])


_ENVIRONMENT = {
    "CYCLONEDDS_URI": "<Discovery><LeaseDuration>4s</LeaseDuration></Discovery>"  # until the dead are missed
}


def join_domain(domain_id: int, arguments: Sequence[str] = ()) -> Context:
    """Return a context of this process on DDS, whatever the environment says."""
    context = Context()
    context.init(list(arguments), middleware=CycloneDDS(domain_id=domain_id, environment=_ENVIRONMENT))
    return context


def run_node(domain_id: int, node: str, arguments: Sequence[str]) -> None:
    """Run a node until it shuts its context down."""
    context = join_domain(domain_id, ["--ros-args", *arguments])
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(NODES[node](context))
    executor.spin()


def run_remote_node(door: socket.socket, node: str, arguments: Sequence[str]) -> None:
    """Run a node of the network that is at the other end of a socket."""

    def make(process: RemoteProcess) -> None:
        context = Context()
        context.init(["--ros-args", *arguments], middleware=process)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(NODES[node](context))

    RemoteProcess(Pipe(door), make).serve()


def run_hosted_node(domain_id: int, node: str, arguments: Sequence[str]) -> None:
    """Be on DDS for a node at the other end of a socket, until it shuts its context down."""
    process = join_domain(domain_id).middleware
    ours, theirs = socket.socketpair()
    threading.Thread(target=run_remote_node, args=(theirs, node, arguments), daemon=True).start()
    gateway = Gateway(process, Pipe(ours), limit_s=30.0, end=process.shutdown)
    gateway.start()
    while process.alive:
        process.spin_once(None)
    assert gateway.failure is None
