"""What a test of conformance needs from a middleware: processes, and time that passes."""

import socket
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from multiprocessing.process import BaseProcess
from typing import Any, ClassVar

from conformance.nodes import NODES
from conformance.processes import PROCESSES, join_domain, run_hosted_node, run_node, run_remote_node
from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.client import Client
from sunset_ros.interfaces import Message
from sunset_ros.rmw.dds.domains import free_domain_id
from sunset_ros.rmw.remote import Gateway, Pipe
from sunset_ros.rmw.sim import SimProcess, Simulation


class Harness(ABC):
    """Runs nodes in processes of their own, and one, the tester, in the test's."""

    def __init__(self) -> None:
        self.node = Node("tester", context=self.make_context("tester"))
        self.executor = SingleThreadedExecutor(context=self.node.context)
        self.executor.add_node(self.node)

    @abstractmethod
    def make_context(self, name: str, arguments: Sequence[str] = ()) -> Context:
        """Return the context of a new process on the network whose nodes live in the test."""

    @abstractmethod
    def start(self, node: str, *arguments: str) -> None:
        """Start a process that runs the node class of `nodes.py` with this name and these ROS arguments."""

    @abstractmethod
    def kill(self, node: str) -> None:
        """End the process of a node at once."""

    @abstractmethod
    def is_running(self, node: str) -> bool:
        """Return whether the process of a node exists."""

    @abstractmethod
    def spin(self, until: Callable[[], bool], timeout_s: float = 10.0) -> bool:
        """Run the tester's callbacks until a predicate holds; return whether it does."""

    def close(self) -> None:
        """End all processes."""
        self.node.context.try_shutdown()

    def pause(self, seconds: float) -> None:
        """Run the tester's callbacks for some time."""
        self.spin(lambda: False, seconds)

    def call(self, client: Client[Any, Any], request: Message) -> Any:
        """Ask a service as soon as it is there, and return its response."""
        assert self.spin(client.service_is_ready), f"{client.service_name} did not appear"
        future = client.call_async(request)
        assert self.spin(future.done), f"{client.service_name} did not answer"
        return future.result()

    def collect(self, kind: type[Message], topic: str, qos: Any = 100) -> list[Any]:
        """Return a list that fills with the messages on a topic."""
        messages: list[Any] = []
        self.node.create_subscription(kind, topic, messages.append, qos)
        return messages


class SimHarness(Harness):
    """All processes in one simulation."""

    def __init__(self) -> None:
        self.simulation = Simulation(seed=1)
        self._processes: dict[str, SimProcess] = {}
        super().__init__()
        self._processes["tester"].run()

    def make_context(self, name: str, arguments: Sequence[str] = ()) -> Context:
        context = Context()
        self._processes[name] = self.simulation.create_process(name)
        context.init(list(arguments), middleware=self._processes[name])
        return context

    def start(self, node: str, *arguments: str) -> None:
        context = self.make_context(node, ["--ros-args", *arguments])
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(NODES[node](context))
        self._processes[node].run()

    def kill(self, node: str) -> None:
        self.simulation.kill(self._processes[node])

    def is_running(self, node: str) -> bool:
        return self._processes[node].alive

    def spin(self, until: Callable[[], bool], timeout_s: float = 10.0) -> bool:
        limit_ns = self.simulation.now + round(timeout_s * 1e9)
        return self.simulation.run_while(lambda: not until(), limit_ns)


class RemoteHarness(SimHarness):
    """One simulation, in which started nodes are operating system processes of their own."""

    def __init__(self) -> None:
        self._gateways: list[Gateway] = []
        self._pipes: list[Pipe] = []
        self._remote: list[BaseProcess] = []
        super().__init__()

    def start(self, node: str, *arguments: str) -> None:
        ours, theirs = socket.socketpair()
        with theirs:
            process = PROCESSES.Process(target=run_remote_node, args=(theirs, node, arguments))
            process.start()
        self._remote.append(process)
        self._processes[node] = self.simulation.create_process(node)
        simulated = self._processes[node]
        self._pipes.append(Pipe(ours))
        self._gateways.append(Gateway(simulated, self._pipes[-1], limit_s=30.0, end=simulated.end))
        self._gateways[-1].start()
        if simulated.alive:
            simulated.run()

    def close(self) -> None:
        super().close()
        for pipe in self._pipes:
            pipe.close()
        for process in self._remote:
            process.join()
        assert [gateway.failure for gateway in self._gateways] == [None] * len(self._gateways)


class CycloneHarness(Harness):
    """Operating system processes in a domain of DDS that nobody else uses."""

    run: ClassVar = staticmethod(run_node)

    def __init__(self) -> None:
        self._held = ExitStack()
        self.domain_id = self._held.enter_context(free_domain_id())
        self._processes: dict[str, BaseProcess] = {}
        super().__init__()

    def make_context(self, name: str, arguments: Sequence[str] = ()) -> Context:
        return join_domain(self.domain_id, arguments)

    def start(self, node: str, *arguments: str) -> None:
        process = PROCESSES.Process(target=self.run, args=(self.domain_id, node, arguments))
        process.start()
        self._processes[node] = process

    def kill(self, node: str) -> None:
        self._processes[node].kill()

    def is_running(self, node: str) -> bool:
        return self._processes[node].is_alive()

    def spin(self, until: Callable[[], bool], timeout_s: float = 10.0) -> bool:
        middleware = self.node.context.middleware
        end_ns = middleware.steady_ns() + round(timeout_s * 1e9)
        while not until():
            if middleware.steady_ns() >= end_ns:
                return False
            self.executor.spin_once(timeout_sec=min(0.01, timeout_s))
        return True

    def close(self) -> None:
        super().close()
        for process in self._processes.values():
            process.kill()
            process.join()
        self._held.close()


class HostedHarness(CycloneHarness):
    """The same, with started nodes at the other ends of pipes."""

    run: ClassVar = staticmethod(run_hosted_node)
