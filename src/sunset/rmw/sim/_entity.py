"""What the nodes of the simulated world consist of."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING

from sunset.errors import MiddlewareError
from sunset.rmw.sim._compute import OTHER_CALLBACK_NS

if TYPE_CHECKING:
    from sunset.rmw.sim._process import SimNode

__all__ = ["Entity"]


class Entity(ABC):
    """A part of a node; most have callbacks.

    Attributes:
        node: its node.
        process: its node's process.
        label: names its callback in errors.
        alive: False once destroyed.
        draw_cost: draws the duration of a callback in ns; None for the usual one.
    """

    __slots__ = ("alive", "draw_cost", "label", "node", "process")

    def __init__(self, node: "SimNode", label: str, draw_cost: Callable[[], int] | None = None) -> None:
        node.check_alive()
        self.node = node
        self.process = node.process
        self.label = label
        self.alive = True
        self.draw_cost = draw_cost
        node.entities[self] = None

    @abstractmethod
    def ready(self) -> bool:
        """Whether there is something to do."""

    @abstractmethod
    def run(self) -> None:
        """Do one piece of it: call the handler once."""

    @abstractmethod
    def destroy(self) -> None:
        """Leave the world for good."""

    def cost_ns(self) -> int:
        """How long the next callback takes."""
        return OTHER_CALLBACK_NS if self.draw_cost is None else self.draw_cost()

    def retire(self) -> bool:
        """Mark as destroyed, and return whether that is news."""
        was_alive, self.alive = self.alive, False
        self.node.entities.pop(self, None)
        return was_alive

    def check_alive(self, action: str) -> None:
        """Refuse to do something with what is destroyed.

        Raises:
            MiddlewareError: it is destroyed, or its process has ended.
        """
        if not self.alive:
            raise MiddlewareError(
                f"Node {self.node.fully_qualified_name} cannot {action}: it was destroyed, or its process has ended."
            )
