"""The base of nodes that conduct a flight: they start it, and inject the scenario's faults."""

from collections.abc import Callable

from sunset_ros.client import Client
from sunset_ros.context import Context
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.node import Node
from sunset_ros.task import Future


class Conductor(Node):
    """Asks the bag player to start and the scenario executor to inject, when a subclass says so."""

    def __init__(self, name: str, *, context: Context | None = None) -> None:
        super().__init__(name, context=context)
        self._player = self.create_client(Trigger, "/bag_player/start")
        self._injector = self.create_client(Trigger, "/scenario_executor/inject")

    def start_flight(self, done: Callable[[bool, str], None]) -> None:
        """Start the flight; `done` gets whether it has begun, and the bag player's message."""
        self._ask(self._player, done)

    def inject(self, done: Callable[[bool, str], None]) -> None:
        """Inject the faults; `done` gets whether all are injected, and the scenario executor's message."""
        self._ask(self._injector, done)

    @staticmethod
    def _ask(client: Client[Trigger.Request, Trigger.Response], done: Callable[[bool, str], None]) -> None:
        def answered(future: Future[Trigger.Response]) -> None:
            response = future.result()
            if response is None:
                done(False, "no reply")
            else:
                done(response.success, response.message)

        client.call_async(Trigger.Request()).add_done_callback(answered)
