"""How long other processes may take, however busy the computer is."""

import os
import time
from contextlib import suppress
from pathlib import Path
from typing import Final

_LOOK_S: Final = 0.5
_PATIENCE: Final = 10
"""Seconds of wall time that a second of processor time may take."""


class Patience:
    """A limit of processor time.

    Processes that sleep or wait for the network take no processor time, and may take ten times as long in wall time.
    Systems without `/proc` have only this limit.

    Args:
        limit_s: seconds of processor time.
        live: whether time is real, so that the limit is of wall time.

    Attributes:
        longest_s: seconds of wall time that the processes may take.
    """

    def __init__(self, limit_s: float, *, live: bool = False) -> None:
        self.longest_s = limit_s if live else _PATIENCE * limit_s
        self._limit_s = limit_s
        self._since_s = self._next_s = 0.0
        self._first_s: float | None = None

    def passed(self, group: int, since_s: float) -> str:
        """Return which limit was passed, as the end of a sentence; empty if none was.

        Args:
            group: the group of the processes, whose processor time is read every half second.
            since_s: when the processes last showed a sign of life, by the clock `time.monotonic`.
        """
        now_s = time.monotonic()
        if since_s != self._since_s:
            self._since_s, self._next_s, self._first_s = since_s, since_s + _LOOK_S, None
        if now_s > since_s + self.longest_s:
            return f"did not return within {self.longest_s:g} s"
        if now_s >= self._next_s:
            taken_s = _processor_time(group)
            self._next_s = now_s + _LOOK_S
            self._first_s = taken_s if self._first_s is None else self._first_s
            if taken_s - self._first_s > self._limit_s:
                return f"did not return within {self._limit_s:g} s of processor time"
        return ""


def _processor_time(group: int) -> float:
    """Return the seconds of processor time that a group of processes has taken; 0 where there is no `/proc`."""
    ticks = 0
    for file in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # the process has ended meanwhile
            fields = file.read_bytes().rpartition(b")")[2].split()
            if int(fields[2]) == group:
                ticks += sum(map(int, fields[11:15]))  # with ended children
    return ticks / os.sysconf("SC_CLK_TCK")
