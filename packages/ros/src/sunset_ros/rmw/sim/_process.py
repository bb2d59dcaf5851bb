"""Simulated processes: a thread of callbacks that take modelled time."""

from abc import abstractmethod
from collections import deque
from collections.abc import Callable
from functools import partial
from operator import attrgetter

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.core.node import Entity, Middleware, NodeHandle, Parts
from sunset_ros.rmw.core.port import EndpointInfo
from sunset_ros.rmw.sim._network import OTHER_CALLBACK_NS, Network, Priority


class SimEntity(Entity):
    """A part of a node that has callbacks."""

    process: "SimProcess"

    @abstractmethod
    def ready(self) -> bool:
        """Whether there is work."""

    @abstractmethod
    def run(self) -> None:
        """Call the handler once."""

    def cost_ns(self) -> int:
        """Return the duration of the next callback."""
        return OTHER_CALLBACK_NS


class _SimPosted(SimEntity):
    """A posted call."""

    def __init__(self, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        super().__init__(node, label)
        self._handler = handler

    def ready(self) -> bool:
        return self.node.alive

    def run(self) -> None:
        self._handler()


class SimProcess(Middleware):
    """One process of the simulated world; made by `Simulation.create_process`.

    Attributes:
        name: its name in errors.
        network: the network.
        is_protected: whether other processes can neither delay it nor notice its requests.
        nodes_here: its nodes, by age.
        exit_handlers: called with this process when it has ended.
    """

    def __init__(
        self,
        network: Network,
        parts: Parts,
        name: str,
        around: Callable[[Callable[[], None]], None] | None,
        *,
        is_protected: bool,
    ) -> None:
        self.parts = parts
        self.name = name
        self.network = network
        self._end_text = f"Process {name} has ended."
        self.is_protected = is_protected
        self.nodes_here: dict[NodeHandle, None] = {}
        self._around = around
        self._busy = False
        self._running = False
        self._calls = 0
        self._ready: deque[SimEntity] = deque()
        self._outbox: list[tuple[Callable[..., None], object]] = []
        self.exit_handlers: list[Callable[[SimProcess], object]] = []

    def __repr__(self) -> str:
        return f"<SimProcess {self.name} {'alive' if self._alive else 'ended'}>"

    def run(self) -> None:
        """Let the callbacks of attached nodes run from now on, whenever the simulation runs."""
        self.check_alive()
        self._running = True
        scheduler = self.network.scheduler
        scheduler.add(scheduler.now, Priority.TIMER, self._start, None)

    def notify(self, entity: SimEntity, *, first: bool = False) -> None:
        """Line up an entity with work, before all others if `first`."""
        if self._alive:
            if first:
                self._ready.appendleft(entity)
            else:
                self._ready.append(entity)
            if self._running and not self._busy:
                self._run_next()

    def _start(self, _: None) -> None:
        if self._running and self._alive and not self._busy:
            self._run_next()

    def _run_next(self) -> None:
        """Begin callbacks up to the first that takes time; the others leave no trace in the order of events."""
        scheduler = self.network.scheduler
        while self._running and not self._busy and (entity := self._next_entity()) is not None:
            cost_ns = 0 if self.is_protected else entity.cost_ns()
            self._busy = True
            if cost_ns:
                scheduler.add(scheduler.now + cost_ns, Priority.COMPLETION, self._complete, None)
                self._run(entity)
                return
            try:
                self._run(entity)
            finally:
                self._finish()

    def _next_entity(self) -> SimEntity | None:
        while self._ready:
            entity = self._ready.popleft()
            if not entity.alive or not entity.ready():
                continue
            if entity.node.attached:
                return entity
            entity.node.hold(partial(self._go_on, entity))
        return None

    def _run(self, entity: SimEntity) -> None:
        self._calls += 1
        self.network.executing = self
        try:
            if self._around is None:
                entity.call(entity.run)
            else:
                entity.call(self._around, entity.run)
        finally:
            self.network.executing = None

    def _go_on(self, entity: SimEntity) -> None:
        scheduler = self.network.scheduler
        scheduler.add(scheduler.now, Priority.DELIVERY, self.notify, entity)

    def _complete(self, _: None) -> None:
        if self._alive:
            self._finish()
            self._run_next()

    def _finish(self) -> None:
        """Send the messages of the callback, which may have ended the process."""
        self._busy = False
        outbox, self._outbox = self._outbox, []
        for leave, payload in outbox:
            leave(payload)
        if self._ending:
            self.end()

    def send(self, leave: Callable[..., None], payload: object) -> None:
        """Call `leave(payload)` when the callback that this process is busy with ends, or now if there is none."""
        if self._busy:
            self._outbox.append((leave, payload))
        else:
            leave(payload)

    def post(self, node: NodeHandle, handler: Callable[[], None], label: str) -> None:
        scheduler = self.network.scheduler
        scheduler.add(scheduler.now, Priority.TIMER, self.notify, _SimPosted(node, handler, label))

    def remove(self, node: NodeHandle) -> None:
        self.network.nodes.pop(node, None)
        self.nodes_here.pop(node, None)

    def end(self) -> None:
        """End at once, and drop all messages that wait in this process."""
        if not self._alive:
            return
        for node in list(self.nodes_here):
            node.destroy()
        self._alive = False
        self._running = False
        self._ready.clear()
        self._outbox.clear()
        for handler in self.exit_handlers:
            handler(self)

    # The port

    def now_ns(self) -> int:
        """Virtual time: nanoseconds since the simulation began; constant during a callback."""
        return self.network.scheduler.now

    steady_ns = now_ns

    def create_node(self, name: str, namespace: str) -> NodeHandle:
        node = NodeHandle(self, name, namespace)
        self.network.nodes[node] = None
        self.nodes_here[node] = None
        for tap in self.network.taps:
            tap.on_node(self.name, node.fully_qualified_name)
        return node

    def spin_once(self, timeout_ns: int | None) -> bool:
        """Let events happen until a callback of this process has run."""
        network = self.network
        if network.executing is not None:
            raise MiddlewareError(
                "Spinning inside a callback would wait for itself; use a Future's done callback."
            )
        self.check_alive()
        scheduler = network.scheduler
        limit = None if timeout_ns is None else scheduler.now + timeout_ns
        before = self._calls
        was_running, self._running = self._running, True
        try:
            scheduler.add(scheduler.now, Priority.COMPLETION, self._start, None)
            called = scheduler.run_while(
                lambda: self._alive and (self._calls == before or self._ending), limit
            )
        finally:
            self._running = was_running and self._alive
        if not called and limit is None:
            raise MiddlewareError(
                "Nothing is left to happen in the simulation, so this spin would never end."
            )
        return self._calls > before

    def wait_for(self, predicate: Callable[[], bool], timeout_ns: int | None) -> bool:
        """Let events happen until a predicate holds; from inside a callback, only evaluate it."""
        scheduler = self.network.scheduler
        if self.network.executing is not None:
            return predicate()
        limit = None if timeout_ns is None else scheduler.now + timeout_ns
        held = scheduler.run_while(lambda: not predicate(), limit)
        if not held and limit is None:
            raise MiddlewareError(
                "Nothing is left to happen in the simulation, so this wait would never end."
            )
        return held

    def shutdown(self) -> None:
        if self.network.executing is self:
            self._ending = True
        else:
            self.end()

    def nodes(self) -> list[tuple[str, str]]:
        nodes = sorted(self.network.nodes, key=attrgetter("fully_qualified_name"))
        return [(node.name, node.namespace) for node in nodes]

    def endpoints(self, name: str | None = None) -> list[EndpointInfo]:
        return self.network.endpoints(name)
