"""A domain of DDS that nobody else uses, and what tests do in it."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest

from rmw.peer import Peer
from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.rmw.dds import CycloneDDS
from sunset_ros.rmw.dds.domains import free_domain_id


class Live:
    """Processes on DDS that live in the test's own, and participants that SUNSET knows nothing of."""

    def __init__(self, domain_id: int) -> None:
        self.domain_id = domain_id
        self.processes: list[CycloneDDS] = []
        self._peers: list[Peer] = []

    def process(self, **options: Any) -> CycloneDDS:
        """Start a process, whatever the environment says."""
        process = CycloneDDS(domain_id=self.domain_id, **{"environment": {}, **options})
        self.processes.append(process)
        return process

    def executor(self, *nodes: Callable[..., Node], arguments: Sequence[str] = ()) -> SingleThreadedExecutor:
        """Start a process with nodes, whose callbacks the executor runs."""
        context = Context()
        context.init(list(arguments), middleware=self.process())
        executor = SingleThreadedExecutor(context=context)
        for node in nodes:
            executor.add_node(node(context=context))
        return executor

    def node(self, name: str = "node") -> tuple[Node, SingleThreadedExecutor]:
        """Start a process with one node."""
        executor = self.executor(lambda context: Node(name, context=context))
        return executor.get_nodes()[0], executor

    def peer(self, user_data: bytes = b"") -> Peer:
        """Let a participant enter that SUNSET knows nothing of; a process of ours must have set the domain up."""
        peer = Peer(self.domain_id, user_data)
        self._peers.append(peer)
        return peer

    @staticmethod
    def spin(executor: SingleThreadedExecutor, until: Callable[[], bool], seconds: float = 10.0) -> bool:
        """Run callbacks until a predicate holds; return whether it does."""
        middleware = executor.context.middleware
        end_ns = middleware.steady_ns() + round(seconds * 1e9)
        while not until():
            if middleware.steady_ns() >= end_ns:
                return False
            executor.spin_once(timeout_sec=0.005)
        return True

    def collect(self, executor: SingleThreadedExecutor, reader: Any, count: int) -> list[bytes]:
        """Run callbacks until so many samples came to a reader, and for a while; return all that came."""
        samples: list[bytes] = []

        def enough() -> bool:
            samples.extend(Peer.take(reader))
            return len(samples) >= count

        self.spin(executor, enough)
        self.spin(executor, lambda: False, 0.1)
        enough()
        return samples

    def close(self) -> None:
        """End everything."""
        for peer in self._peers:
            peer.leave()
        for process in self.processes:
            process.shutdown()


@pytest.fixture
def live() -> Iterator[Live]:
    with free_domain_id() as domain_id:
        made = Live(domain_id)
        yield made
        made.close()
