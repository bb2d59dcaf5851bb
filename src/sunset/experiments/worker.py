"""A run of a campaign on behalf of another process, which may be on another computer: its record goes back as bytes.

A dask worker has many threads, and forking such a process may deadlock it. So each run is done by a *helper*: a fresh
process that has loaded only the modules of runs, and does a single run at a time.
"""

import os
import socket
import subprocess
import sys
from collections import defaultdict, deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import Pipe
from typing import Final

from sunset.errors import InvalidInputError, SunsetError
from sunset.experiments.resources import Resources, model_checksum
from sunset.experiments.run import versions
from sunset.experiments.spec import RunSpec

_PROGRAM: Final = "sunset.experiments.worker_process"
_ATTEMPTS: Final = 3
"""How often a run is begun whose helper is killed."""
_SHORT: Final = 16
"""Length of a checksum in a message, in characters."""


@dataclass(frozen=True)
class Order:
    """A run for a worker.

    Attributes:
        spec: the run.
        known: the checksum of its managing system; None for a reference row.
        facts: the expected `facts_of` its resources.
        folder: the folder that relative paths refer to.
        search: where modules are searched for, after the worker's own places.
    """

    spec: RunSpec
    known: str | None
    facts: Mapping[str, str]
    folder: str
    search: tuple[str, ...]


def facts_of(resources: Resources) -> dict[str, str]:
    """Return the facts of a run's resources that its record depends on, by name."""
    return {
        "model": model_checksum(resources.model.card),
        "flight": resources.bag_checksum,
        "device": resources.segmenter.device,
    }


def check_same(theirs: Mapping[str, str], ours: Mapping[str, str]) -> None:
    """Check that the worker and the computer that began the campaign have the same facts.

    Both are name → text, such as a version or a checksum.
    """
    for name, expected in ours.items():
        if (actual := theirs.get(name, "")) != expected:
            raise InvalidInputError(
                f"its {name} is {actual[:_SHORT] or 'none'}, that of the computer which began the campaign is "
                f"{expected[:_SHORT] or 'none'}; let both have the same."
            )


def labelled_versions() -> dict[str, str]:
    """Return the `versions` of this computer, each under a name for messages."""
    return {f"version of {name}": version for name, version in versions().items()}


@contextmanager
def on_worker(where: str) -> Iterator[None]:
    """Prefix errors that are raised in the context with the worker's name."""
    try:
        yield
    except SunsetError as error:
        raise type(error)(f"The worker at {where} cannot do a run: {error}") from error


def do_run(expected: Mapping[str, str], order: bytes) -> dict[str, bytes]:
    """Do a run, and return its record: file name → content.

    Args:
        expected: the versions that a worker must have, as of `labelled_versions`. They are compared before the order is
            opened, which another version might misunderstand.
        order: an `Order`, pickled.
    """
    with on_worker(socket.gethostname()):
        check_same(labelled_versions(), expected)
        for _ in range(_ATTEMPTS):
            helper = _free_helper()
            try:
                answer = helper.ask(order)
            except (EOFError, OSError):
                helper.close()
                continue
            _helpers[os.getpid()].append(helper)
            if isinstance(answer, Exception):
                raise answer
            return answer
        raise SunsetError(
            f"the process that did it was killed {_ATTEMPTS} times, for instance for want of memory; what was "
            "finished is kept: run the same command again, with fewer workers if memory was short."
        )


class _Helper:
    """A process that does runs for this process."""

    def __init__(self) -> None:
        self._pipe, theirs = Pipe()
        with theirs:
            # -P: modules are not searched for in the worker's current folder
            self._process = subprocess.Popen(  # noqa: S603  the command is ours
                [sys.executable, "-P", "-m", _PROGRAM, str(theirs.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno()],
                start_new_session=True,
            )

    def ask(self, order: bytes) -> dict[str, bytes] | Exception:
        """Return the files of a record, or an exception; raise EOFError or OSError if the helper has ended."""
        self._pipe.send_bytes(order)
        answer: dict[str, bytes] | Exception = self._pipe.recv()
        return answer

    def close(self) -> None:
        """End it."""
        self._pipe.close()
        self._process.kill()
        self._process.wait()


_helpers: Final[defaultdict[int, deque[_Helper]]] = defaultdict(deque)
"""The idle helpers of each process, by its number: a forked process has its own."""


def _free_helper() -> _Helper:
    try:
        return _helpers[os.getpid()].pop()
    except IndexError:
        return _Helper()
