"""Forking this process without losing signals, output or locks."""

import ctypes
import os
import signal
import sys
import threading
import warnings
from contextlib import suppress
from typing import Final

from sunset_ros.interruption import ENDING, noted_signals

ONE_THREAD: Final = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
"""A node computes little but inference, which has one thread anyway; idle threads cost time to start."""

FORKING: Final = threading.RLock()
"""Held during a fork, and by threads that use libraries with locks, which a copy of the process would find locked."""

_DEATH_SIGNAL: Final = 1
_SUBREAPER: Final = 36
"""PR_SET_PDEATHSIG and PR_SET_CHILD_SUBREAPER of Linux's prctl(2)."""


def signal_after_parent(number: int) -> None:
    """Let the system send this process a signal when its parent ends, even if this process is stopped; on Linux."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_DEATH_SIGNAL, number)


def adopt_orphans() -> None:
    """Become the parent of descendants whose parents end, so that this process can wait for them; on Linux."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_SUBREAPER, 1, 0, 0, 0)


def fill_standard_streams() -> None:
    """Open closed standard streams, so that other files do not take their descriptors."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:  # noqa: PLR2004  stderr's
        os.set_inheritable(descriptor, True)
    os.close(descriptor)


def fork(child: list[int]) -> int:
    """Fork this process; handlers of signals that come meanwhile run afterwards, and only here.

    Python would lose an exception that a handler raises during a fork. A handler may also raise before the caller has
    the new process's number, so that number is appended to `child`. In the new process, signals that ask it to end stay
    blocked.
    """
    _flush_streams()
    pid = None
    with FORKING:
        held = signal.pthread_sigmask(signal.SIG_BLOCK, ENDING)
        try:
            # another thread may receive a signal, whose handler then runs in this thread
            with noted_signals() as came, warnings.catch_warnings():
                # Python 3.12 warns of other threads, which the new process does not need
                warnings.simplefilter("ignore", DeprecationWarning)
                pid = os.fork()
                child += [pid] if pid else []
            for number in came if pid else ():
                signal.raise_signal(number)
        finally:
            if pid != 0:
                signal.pthread_sigmask(signal.SIG_SETMASK, held)
    return pid


def _flush_streams() -> None:
    """Write buffered output, which the new process would write again."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError, ValueError):  # it is None or an object of the user's, or closed
            stream.flush()
