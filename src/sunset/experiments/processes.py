"""Nodes as processes of the operating system."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import IO, Final

from sunset.forks import ONE_THREAD, UNSEEN, ForkedProcess, fork_server
from sunset.harness.node_process import MANAGER_FAILED, NodeSpec

_PARTING_S: Final = 3.0
"""How long processes may take to leave the graph when all of them are ended."""
_TURN_S: Final = 0.1
"""Longest wait for one process before the next is ended: ending all at once would take the processor from others."""
_STEP_S: Final = 0.01
_LOOK_S: Final = 0.1
_LAST_WORDS: Final = 20
_SIGNALS: Final = {number.value: number.name for number in signal.Signals}  # real-time ones have no names

_PROGRAM: Final = NodeSpec.__module__
"""What runs a node as a process, and forks such processes."""

_Process = subprocess.Popen[str] | ForkedProcess


class NodeProcesses:
    """Runs nodes, one process each; a `ProcessHost`.

    Whatever ends this process ends them too: each holds the other end of a pipe. With a node ends what it has started.
    Where the system can, nodes are forked from a process that has imported already what they need, so that a new one is
    there at once.

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
        self._specs = {name: replace(spec, ends_with_stdin=True) for name, spec in specs.items()}
        self._environment = dict(environment)
        self._on_line = on_line
        self._server = fork_server(_PROGRAM)
        self._running: dict[str, _Process] = {}
        self._stopped: frozenset[str] = frozenset()
        self._next_look_s = 0.0
        self._ended: dict[str, int] = {}
        self._lines: dict[str, deque[str]] = {}
        self._readers: dict[str, threading.Thread] = {}
        self._handlers: list[Callable[[str], None]] = []

    def start(self, node: str) -> None:
        """Start a new process for `node`."""
        process = self._new_process(self._specs[node].to_json())
        self._ended.pop(node, None)
        self._running[node] = process
        lines: deque[str] = deque(maxlen=_LAST_WORDS)
        self._lines[node] = lines
        assert process.stdout is not None  # noqa: S101  a pipe was asked for
        reader = threading.Thread(target=self._read, args=(node, process.stdout, lines), daemon=True)
        self._readers[node] = reader
        reader.start()

    def _new_process(self, spec: str) -> _Process:
        if self._server is not None:
            try:
                return self._server.fork([spec], self._environment)
            except OSError:
                self._server = None  # it was killed; the nodes can do without
        return subprocess.Popen(  # noqa: S603  the command is ours
            [sys.executable, "-m", _PROGRAM, spec],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            env=ONE_THREAD | dict(os.environ) | self._environment,
            start_new_session=True,  # Ctrl-C is for this process, which ends the others in order
        )

    def _read(self, node: str, output: IO[str], lines: deque[str]) -> None:
        with output:
            for line in output:
                lines.append(line.rstrip())
                # the reader may be gone; the node must not wait for one
                with suppress(Exception, SystemExit):
                    self._on_line(node, line.rstrip())

    @property
    def nodes(self) -> tuple[str, ...]:
        """The nodes that there are."""
        return tuple(self._specs)

    def is_running(self, node: str) -> bool:
        """Return whether the process of `node` exists."""
        return node in self._running

    def pid(self, node: str) -> int | None:
        """Return the process id of `node`; None if it has no process."""
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
        """Find out which processes have ended, and now and then which are stopped."""
        now = time.monotonic()
        if now >= self._next_look_s:
            self._next_look_s = now + _LOOK_S
            self._stopped = frozenset(
                node for node, process in self._running.items() if _is_stopped(process.pid)
            )
        for node, process in list(self._running.items()):
            if process.poll() is not None:
                self._note_end(node)
                for handler in self._handlers:
                    handler(node)

    def end_of(self, node: str) -> str:
        """Return how the last process of `node` ended, in words; empty if it did not."""
        code = self._ended.get(node)
        if code is None:
            return ""
        words = self._last_words(node)
        if code == 0:
            return "ended in order"  # what it has printed is no cause
        if code == UNSEEN:
            return "ended, it is not known how"
        if code < 0:
            return f"ended by signal {-code} ({_SIGNALS.get(-code) or signal.strsignal(-code)})"
        return f"ended with exit code {code}" + (f": {words}" if words else "")

    def manager_failure(self, node: str) -> str:
        """Return how the managing system that `node` has behind walls failed, in a sentence; empty if it did not."""
        return self._last_words(node) if self._ended.get(node) == MANAGER_FAILED else ""

    def _last_words(self, node: str) -> str:
        """Return the last line that a process which has ended printed."""
        reader = self._readers.pop(node, None)
        if reader is not None:
            reader.join(timeout=1.0)  # others may hold the other end for ever, so not a second time
        return self._lines[node][-1] if self._lines[node] else ""

    def has_failed(self, node: str) -> bool:
        """Return whether the last process of `node` was seen to end, and not in order."""
        return self._ended.get(node, 0) not in {0, UNSEEN}

    def close(self) -> None:
        """End all processes, the newest first, and wait until they are gone."""
        limit = time.monotonic() + _PARTING_S
        for process in reversed(self._running.values()):
            _send(process, signal.SIGTERM)
            _send(process, signal.SIGCONT)
            _await_end([process], min(limit, time.monotonic() + _TURN_S))
        if not _await_end(self._running.values(), limit):
            for process in self._running.values():
                process.kill()
        for node in list(self._running):
            self._note_end(node)
        if self._server is not None:
            self._server.close()

    def _note_end(self, node: str) -> None:
        process = self._running.pop(node)
        assert process.stdin is not None  # noqa: S101  a pipe was asked for
        process.stdin.close()
        self._ended[node] = process.wait()
        with suppress(OSError):  # nothing is left of what it has started
            os.killpg(process.pid, signal.SIGKILL)


def _await_end(processes: Collection[_Process], limit_s: float) -> bool:
    """Wait until processes have ended, or for a time of the monotonic clock; return whether they have."""
    while any(process.poll() is None for process in processes):
        if time.monotonic() >= limit_s:
            return False
        threading.Event().wait(_STEP_S)
    return True


def _send(process: _Process, number: int) -> None:
    """Send a signal to a process and to what it has started."""
    try:
        os.killpg(process.pid, number)
    except OSError:  # it has ended, or has just begun and has no group of its own yet
        process.send_signal(number)


def _is_stopped(pid: int) -> bool:
    """Return whether a signal has stopped a process, where the system tells."""
    try:
        status = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return False
    return status.rpartition(")")[2].split()[0] == "T"
