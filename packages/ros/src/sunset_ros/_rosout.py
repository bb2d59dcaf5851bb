"""Where the log messages of a node go."""

import sys

from sunset_ros.clock import Clock
from sunset_ros.context import Context
from sunset_ros.interfaces.rcl_interfaces.msg import Log
from sunset_ros.logging import LoggingSeverity
from sunset_ros.publisher import Publisher


class NodeLogSink:
    """Sends log messages to /rosout, and to stderr if the context says so."""

    def __init__(self, context: Context, clock: Clock, rosout: Publisher[Log] | None) -> None:
        self._context = context
        self._clock = clock
        self._rosout = rosout
        self._written: set[tuple[int, str, str]] = set()

    def now_ns(self) -> int:
        """Return the time by which messages are throttled, which no node can set."""
        return self._context.middleware.steady_ns()

    def leave(self) -> None:
        """Send to /rosout no more: the node has left the graph."""
        self._rosout = None

    def write(self, message: Log) -> None:
        """Send a message; once the context is shut down, to stderr only."""
        if self._rosout is not None and self._context.ok():
            message.stamp = self._clock.now().to_msg()
            self._rosout.publish(message)
        line = (message.level, message.name, message.msg)
        if self._context.arguments.log_to_stderr and line not in self._written:
            if self._context.log_once:
                self._written.add(line)
            severity, seconds = LoggingSeverity(message.level).name, self._clock.now_ns() / 1e9
            sys.stderr.write(f"[{severity}] [{seconds:.9f}] [{message.name}]: {message.msg}\n")
