"""Campaigns on an executor, whose workers may be on other computers and share no files with this computer.

A worker may have many threads, and forking such a process may deadlock it. So each run is done by a *helper*: a fresh
process that has loaded only the modules of runs, and does a single run at a time. Its record goes back as bytes.
"""

import os
import pickle
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Executor, Future, as_completed
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Final

from sunset.errors import InvalidInputError, SunsetError
from sunset.experiments.campaign import flight_key
from sunset.experiments.manager import manager_checksum
from sunset.experiments.resources import Resources, model_checksum, prepare
from sunset.experiments.run import record_run, versions
from sunset.experiments.settings import Settings
from sunset.experiments.spec import RunSpec
from sunset.processes.calls import UnexpectedError
from sunset.recording import RecordWriter
from sunset.system import extended_system
from sunset_ros.texts import shorten

_LONGEST: Final = 300
"""Longest failure text of an executor, in characters."""
_SHORT: Final = 16
"""Length of a checksum in a message, in characters."""
_KEPT: Final = "what was finished is kept: run the same command again"


@dataclass(frozen=True)
class Order:
    """A run for a worker."""

    spec: RunSpec
    known: str | None
    """The checksum of its managing system; None for a reference row."""
    facts: Mapping[str, str]
    """The expected `facts_of` its resources."""
    folder: str
    """The folder that relative paths refer to."""
    search: tuple[str, ...]
    """Where modules are searched for, after the worker's own places."""


def run_on_workers(
    executor: Executor,
    todo: Sequence[tuple[RunSpec, Path, str | None]],
    prepared: Iterable[tuple[RunSpec, Resources]],
) -> Iterator[int]:
    """Do runs on an executor's workers and write their records; yield how many are finished, after each.

    Args:
        executor: it may do them in any order, and repeat those that it has lost.
        todo: each run, its folder, and the checksum of its managing system.
        prepared: a run on each flight, and its resources.
    """
    facts = {flight_key(run): facts_of(resources) for run, resources in prepared}
    expected, here, search = labelled_versions(), str(Path.cwd()), tuple(filter(None, sys.path))
    folders: dict[Future[dict[str, bytes]], Path] = {}
    try:
        with _translated():
            for spec, folder, known in todo:
                order = pickle.dumps(Order(spec, known, facts[flight_key(spec)], here, search))
                folders[executor.submit(do_run, expected, order)] = folder
        for count, future in enumerate(as_completed(folders), 1):
            with _translated():
                files = future.result()
            with RecordWriter(folders.pop(future)) as writer:
                writer.adopt(files)
            yield count
    finally:
        for future in folders:
            future.cancel()


@contextmanager
def _translated() -> Iterator[None]:
    """Translate any exception of an executor into a `SunsetError`."""
    try:
        yield
    except SunsetError:
        raise
    except CancelledError as error:
        raise SunsetError(f"The executor or its scheduler is gone; {_KEPT}.") from error
    except Exception as error:
        text = shorten(" ".join(f"{type(error).__name__}: {error}".split()), _LONGEST).rstrip(".")
        raise SunsetError(f"The executor has failed, {text}; {_KEPT}.") from error


def facts_of(resources: Resources) -> dict[str, str]:
    """Return the facts of a run's resources that its record depends on, by name."""
    return {
        "model": model_checksum(resources.model.card),
        "flight": resources.bag_checksum,
        "device": resources.segmenter.device,
    }


def labelled_versions() -> dict[str, str]:
    """Return the `versions` of this computer, each under a name for messages."""
    return {f"version of {name}": version for name, version in versions().items()}


def _check_same(theirs: Mapping[str, str], ours: Mapping[str, str]) -> None:
    """Check that the worker and the computer that began the campaign have the same facts."""
    for name, expected in ours.items():
        if (actual := theirs.get(name, "")) != expected:
            raise InvalidInputError(
                f"its {name} is {actual[:_SHORT] or 'none'}, that of the computer which began the campaign is "
                f"{expected[:_SHORT] or 'none'}; let both have the same."
            )


def do_run(expected: Mapping[str, str], order: bytes) -> dict[str, bytes]:
    """Do a run, and return its record: file name → content.

    Args:
        expected: the versions that a worker must have, as of `labelled_versions`. They are compared before the order is
            opened, which another version might misunderstand.
        order: an `Order`, pickled.
    """
    try:
        _check_same(labelled_versions(), expected)
        answer = _ask_helper(order)
        if isinstance(answer, Exception):
            raise answer
    except SunsetError as error:
        raise type(error)(f"The worker at {socket.gethostname()} cannot do a run: {error}") from error
    return answer


_Helper = tuple[Connection, "subprocess.Popen[bytes]"]

_idle: Final[list[_Helper]] = []
"""The helpers of this process that do nothing now; they end with it."""


def _new_helper() -> _Helper:
    pipe, theirs = Pipe()
    with theirs:
        # -P: modules are not searched for in the worker's current folder
        process = subprocess.Popen(  # noqa: S603  the command is ours
            [sys.executable, "-P", "-c", f"import {__name__} as c; c.serve({theirs.fileno()})"],
            stdin=subprocess.DEVNULL,
            pass_fds=[theirs.fileno()],
            start_new_session=True,
        )
    return pipe, process


def _ask_helper(order: bytes) -> dict[str, bytes] | Exception:
    try:
        pipe, process = _idle.pop()
    except IndexError:
        pipe, process = _new_helper()
    try:
        pipe.send_bytes(order)
        answer: dict[str, bytes] | Exception = pipe.recv()
    except (EOFError, OSError) as error:
        pipe.close()
        process.kill()
        process.wait()
        raise SunsetError(
            f"the process that did it was killed, for instance for want of memory; {_KEPT}, with fewer workers if "
            "memory was short."
        ) from error
    _idle.append((pipe, process))
    return answer


def serve(descriptor: int) -> None:
    """Serve runs in a helper until its pipe closes."""
    os.dup2(2, 1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with (
        Connection(descriptor) as pipe,
        tempfile.TemporaryDirectory(prefix="sunset-worker-") as folder,
        suppress(EOFError, OSError),
    ):
        while True:
            pipe.send(_answer(pipe.recv_bytes(), Path(folder, "record")))


def _answer(order: bytes, folder: Path) -> dict[str, bytes] | Exception:
    try:
        return _do(pickle.loads(order), folder)  # noqa: S301  the sender may run anything here
    except SunsetError as error:
        return error
    except Exception:  # noqa: BLE001  the sender raises it
        return UnexpectedError(traceback.format_exc())
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _do(order: Order, folder: Path) -> dict[str, bytes]:
    """Do a run, if model, flight and managing system are as expected; return the files of its record."""
    spec = order.spec
    if Path(order.folder).is_dir():
        os.chdir(order.folder)
    sys.path += [place for place in order.search if place not in sys.path]
    with extended_system(()):
        spec.load_extensions()
        resources = prepare(spec)
        _check_same(facts_of(resources), order.facts)
        if order.known is not None:
            _check_manager(spec.manager, spec.settings, order.known, order.folder)
        record_run(spec, resources, folder, order.known)
    return {file.name: file.read_bytes() for file in folder.iterdir()}


@cache
def _check_manager(manager: str, settings: Settings, known: str, _: str) -> None:
    """Check, once per folder, that a managing system has not changed since the campaign was begun."""
    name = f"managing system {manager}"
    _check_same({name: manager_checksum(manager, settings)}, {name: known})
