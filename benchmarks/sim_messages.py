"""How many messages a second pass through the simulated middleware, callbacks included.

Run it with `python benchmarks/sim_messages.py`; `--profile` shows where the time goes.
"""

import argparse
import cProfile
import pstats
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from sunset_ros import Context, Node, SingleThreadedExecutor
from sunset_ros.interfaces import Message
from sunset_ros.interfaces.sensor_msgs.msg import Image
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.rmw.sim import Simulation, Tap

PIXELS = np.zeros(256 * 144 * 3, np.uint8)


class Relay(Node):
    """Sends each message on, and counts; the first one starts by itself."""

    def __init__(
        self, name: str, make: Callable[[], Message], source: str, target: str, **options: Any
    ) -> None:
        super().__init__(name, **options)
        self.count = 0
        self.make = make
        self.publisher = self.create_publisher(type(make()), target, 10)
        self.create_subscription(type(make()), source, self.on_message, 10)

    def on_message(self, message: Message) -> None:
        """Send it on."""
        self.count += 1
        self.publisher.publish(message)


class Counter(Tap):
    """Counts samples, as the observer of an experiment would."""

    def __init__(self) -> None:
        self.count = 0

    def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:  # noqa: ARG002  Tap's
        """Count it."""
        self.count += 1


def image() -> Image:
    """Return an image of the size of the flight's."""
    return Image(height=144, width=256, encoding="bgr8", step=768, data=PIXELS)


def measure(make: Callable[[], Message], messages: int, *, tapped: bool) -> float:
    """Return how many messages a second go back and forth between two processes."""
    sim = Simulation()
    if tapped:
        sim.add_tap(Counter())
    nodes = []
    for name, source, target in (("ping", "/a", "/b"), ("pong", "/b", "/a")):
        process = sim.create_process(name)
        context = Context()
        context.init([], middleware=process)
        nodes.append(Relay(name, make, source, target, context=context))
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(nodes[-1])
        process.run()
    nodes[0].publisher.publish(make())
    start = perf_counter()
    sim.run_while(lambda: nodes[0].count + nodes[1].count < messages, 10**18)
    return messages / (perf_counter() - start)


def main() -> None:
    """Print the rates."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=50_000, help="messages in each measurement")
    parser.add_argument("--profile", action="store_true", help="show where the time goes")
    arguments = parser.parse_args()
    profile = cProfile.Profile() if arguments.profile else None
    if profile is not None:
        profile.enable()
    for name, make in (("small messages", lambda: String(data="hello")), ("images of 110 kB", image)):
        for tapped in (False, True):
            best = max(measure(make, arguments.messages, tapped=tapped) for _ in range(1 if profile else 3))
            print(f"{name}{', observed' if tapped else ''}: {best:,.0f} messages/s")
    if profile is not None:
        profile.disable()
        pstats.Stats(profile).sort_stats("tottime").print_stats(15)


if __name__ == "__main__":
    main()
