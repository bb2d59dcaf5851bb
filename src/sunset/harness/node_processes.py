"""The processes of a live system's nodes: their starts, their ends, and the lines that they print."""

import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import IO, Final

from sunset.harness.node_process import MANAGER_FAILED, NodeSpec, node_server
from sunset.processes.process import Process
from sunset.processes.server import ForkServer

_GRACE_S: Final = 3.0
"""How long nodes may take to leave the graph when they are ended."""
_TURN_S: Final = 0.1
"""Longest wait for a process before the next is ended: ending all at once would take the processor from others."""
_LOOK_S: Final = 0.1
_LAST_LINES: Final = 20
_SIGNALS: Final = {number.value: number.name for number in signal.Signals}  # real-time signals lack names


class NodeProcesses:
    """Runs nodes, each in a process that is forked from a server; a `ProcessHost`.

    All of them end with this process, however it ends. Processes that a node has started end with the node.

    Args:
        specs: process → the node that it runs.
        environment: variables for all of them, besides this process's own.
        on_line: called, on other threads, with a node and a line that it printed.
    """

    def __init__(
        self,
        specs: Mapping[str, NodeSpec],
        environment: Mapping[str, str],
        on_line: Callable[[str, str], object],
    ) -> None:
        self._specs = dict(specs)
        self._environment = dict(environment)
        self._on_line = on_line
        self._server: ForkServer = node_server()
        self._running: dict[str, Process] = {}
        self._stopped: frozenset[str] = frozenset()
        self._next_look_s = 0.0
        self._ended: dict[str, int | None] = {}
        self._lines: dict[str, deque[str]] = {}
        self._readers: dict[str, threading.Thread] = {}
        self._handlers: list[Callable[[str], None]] = []

    def start(self, node: str) -> None:
        """Start a new process for `node`.

        Raises:
            SunsetError: no process can be started.
        """
        if not self._server.is_running:  # it was killed
            self._server = node_server()
        task = {"spec": asdict(self._specs[node]), "environment": self._environment}
        process = self._server.start(task)
        self._ended.pop(node, None)
        self._running[node] = process
        lines: deque[str] = deque(maxlen=_LAST_LINES)
        self._lines[node] = lines
        reader = threading.Thread(target=self._read, args=(node, process.take_output(), lines), daemon=True)
        self._readers[node] = reader
        reader.start()

    def _read(self, node: str, output: IO[str], lines: deque[str]) -> None:
        with output:
            for line in output:
                lines.append(line.rstrip())
                # a node must not wait because of an error of its reader
                with suppress(Exception, SystemExit):
                    self._on_line(node, line.rstrip())

    @property
    def nodes(self) -> tuple[str, ...]:
        """All nodes, whether they run or not."""
        return tuple(self._specs)

    def is_running(self, node: str) -> bool:
        """Return whether the process of `node` exists."""
        return node in self._running

    def pid(self, node: str) -> int | None:
        """Return the process id of `node`; None without a process."""
        process = self._running.get(node)
        return None if process is None else process.pid

    def is_stopped(self, node: str) -> bool:
        """Return whether a signal had stopped the process of `node` when `poll` looked, ten times a second."""
        return node in self._stopped

    def kill(self, node: str) -> None:
        """End the process of `node` at once."""
        self._running[node].kill()

    def on_exit(self, handler: Callable[[str], None]) -> None:
        """Call `handler(node)`, during `poll`, whenever a process has ended."""
        self._handlers.append(handler)

    def poll(self) -> None:
        """Note the processes that have ended, and ten times a second those that are stopped."""
        for node, process in list(self._running.items()):
            if process.ended:
                self._note_end(node)
                for handler in self._handlers:
                    handler(node)
        now = time.monotonic()
        if now >= self._next_look_s:
            self._next_look_s = now + _LOOK_S
            self._stopped = frozenset(
                node for node, process in self._running.items() if _is_stopped(process.pid)
            )

    def end_of(self, node: str) -> str:
        """Return how the last process of `node` ended, in words; empty while it runs."""
        if node not in self._ended:
            return ""
        code = self._ended[node]
        last_line = self._last_line(node)
        if code == 0:
            return "ended in order"  # its output does not say why
        if code is None:
            return "ended, it is not known how"
        if code < 0:
            return f"ended by signal {-code} ({_SIGNALS.get(-code) or signal.strsignal(-code)})"
        return f"ended with exit code {code}" + (f": {last_line}" if last_line else "")

    def manager_failure(self, node: str) -> str:
        """Return how the confined managing system of `node` failed, in a sentence; empty if it did not."""
        return self._last_line(node) if self._ended.get(node) == MANAGER_FAILED else ""

    def _last_line(self, node: str) -> str:
        """Return the last line that an ended process printed."""
        reader = self._readers.pop(node, None)
        if reader is not None:
            reader.join(timeout=1.0)  # another process may hold the pipe for ever, so this waits only once
        return self._lines[node][-1] if self._lines[node] else ""

    def has_failed(self, node: str) -> bool:
        """Return whether the last process of `node` was seen to end, and not in order."""
        return self._ended.get(node) not in {0, None}

    def close(self) -> None:
        """End all processes, the newest first, and wait until they are gone."""
        limit_s = time.monotonic() + _GRACE_S
        for process in reversed(self._running.values()):
            process.send_signal(signal.SIGTERM)
            process.send_signal(signal.SIGCONT)
            process.join(min(limit_s, time.monotonic() + _TURN_S))
        for process in self._running.values():
            process.join(limit_s)
        for node in list(self._running):
            self._note_end(node)
        self._server.close()

    def _note_end(self, node: str) -> None:
        process = self._running.pop(node)
        process.close()
        self._ended[node] = process.returncode


def _is_stopped(pid: int) -> bool:
    """Return whether a signal has stopped a process, where there is `/proc`."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] == "T"
