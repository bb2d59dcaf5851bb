"""Campaigns on an executor, whose workers may be on other computers and share no files with this computer.

A worker may have many threads, and forking such a process may deadlock it. So each run is done by a *helper*, a fresh
process that does a single run at a time. Its record goes back as bytes.
"""

import os
import pickle
import socket
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Executor, Future, as_completed
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Final

from sunset.errors import InvalidInputError, MissingExtraError, SunsetError
from sunset.experiments.manager import manager_checksum
from sunset.experiments.resources import Resources, flight_plan, model_checksum, prepare
from sunset.experiments.run import record_run, versions
from sunset.experiments.settings import Settings
from sunset.experiments.spec import RunSpec
from sunset.processes.calls import UnexpectedError
from sunset.recording import RecordWriter
from sunset.system import extended_system
from sunset_ros.texts import shorten

_PATIENCE_S: Final = 10
"""How long a scheduler may take to answer."""
_LONGEST: Final = 300
"""Longest failure text of an executor, in characters."""
_SHORT: Final = 16
"""Length of a checksum in a message, in characters."""
_Order = tuple[RunSpec, str | None, Mapping[str, str], str, Sequence[str]]
"""A run, the checksum of its managing system, the `facts_of` its resources, the folder of relative paths, and where
modules are searched for, after the worker's own places."""
_KEPT: Final = "what was finished is kept: run the same command again"


@contextmanager
def connected_scheduler(address: str) -> Iterator[Executor]:
    """Give an executor on the workers of a dask scheduler, such as `tcp://10.0.0.1:8786`."""
    try:
        from distributed import Client  # noqa: PLC0415  an optional extra
    except ImportError as error:
        raise MissingExtraError(
            "A scheduler needs dask.distributed, not installed: pip install 'sunset-exemplar[cluster]'."
        ) from error
    host, _, port = address.removeprefix("tcp://").rpartition(":")
    try:
        with socket.create_connection((host.strip("[]"), int(port)), _PATIENCE_S):
            pass  # dask's client would wait for ever
        client = Client(address, timeout=_PATIENCE_S, set_as_default=False)
    except (OSError, OverflowError, ValueError) as error:
        raise InvalidInputError(
            f"No scheduler answers at {address}: {str(error).rstrip('.')}; start one with 'dask scheduler', and "
            "workers with 'dask worker tcp://HOST:PORT'."
        ) from error
    with client:
        yield client.get_executor(pure=False)


def run_on_workers(
    executor: Executor,
    todo: Sequence[tuple[RunSpec, Path, str | None]],
    prepared: Iterable[tuple[RunSpec, Resources]],
) -> Iterator[int]:
    """Do runs on an executor's workers and write their records; yield how many are finished, first 0.

    Args:
        executor: it may do them in any order, and repeat those that it has lost.
        todo: each run, its folder, and the checksum of its managing system.
        prepared: a run on each flight, and its resources.
    """
    yield 0
    facts = {(run.flight, flight_plan(run)): facts_of(resources) for run, resources in prepared}
    expected, here, search = labelled_versions(), str(Path.cwd()), tuple(filter(None, sys.path))
    folders: dict[Future[dict[str, bytes]], Path] = {}
    try:
        with _translated():
            for spec, folder, known in todo:
                order = pickle.dumps((spec, known, facts[spec.flight, flight_plan(spec)], here, search))
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
    """Do a run on a worker, and return its record: file name → content.

    Args:
        expected: the `labelled_versions` that a worker must have; another version might misunderstand the order.
        order: an `_Order`, pickled.
    """
    try:
        _check_same(labelled_versions(), expected)
        answer = _ask_helper(order)
        if isinstance(answer, Exception):
            raise answer
    except SunsetError as error:
        raise type(error)(f"The worker at {socket.gethostname()} cannot do a run: {error}") from error
    return answer


_idle: Final[list["subprocess.Popen[bytes]"]] = []
"""The helpers of this process that do nothing now; they end with it."""


def _ask_helper(order: bytes) -> dict[str, bytes] | Exception:
    try:
        helper = _idle.pop()
    except IndexError:
        helper = subprocess.Popen(  # noqa: S603  the command is ours
            [sys.executable, "-P", "-c", f"import {__name__} as c; c.serve()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )
    assert helper.stdin is not None and helper.stdout is not None  # noqa: S101, PT018  they are pipes
    try:
        helper.stdin.write(order)
        helper.stdin.flush()
        answer: dict[str, bytes] | Exception = pickle.load(helper.stdout)  # noqa: S301  it is ours
    except (EOFError, OSError, pickle.UnpicklingError) as error:
        helper.kill()
        helper.wait()
        raise SunsetError(
            f"the process that did it was killed, for instance for want of memory; {_KEPT}, with fewer workers if "
            "memory was short."
        ) from error
    _idle.append(helper)
    return answer


def serve() -> None:
    """Do the runs whose orders come through stdin; what a run prints goes to stderr."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with suppress(EOFError, BrokenPipeError), tempfile.TemporaryDirectory(prefix="sunset-worker-") as folder:
        while True:
            order = pickle.load(sys.stdin.buffer)  # noqa: S301  the sender may run anything here
            with tempfile.TemporaryDirectory(dir=folder) as place:
                try:
                    answer: dict[str, bytes] | Exception = _do(order, Path(place, "record"))
                except SunsetError as error:
                    answer = error
                except Exception:  # noqa: BLE001  the sender raises it
                    answer = UnexpectedError(traceback.format_exc())
            pickle.dump(answer, answers)
            answers.flush()


def _do(order: _Order, folder: Path) -> dict[str, bytes]:
    """Do a run, if model, flight and managing system are as expected; return the files of its record."""
    spec, known, facts, here, search = order
    if Path(here).is_dir():
        os.chdir(here)
    sys.path += [place for place in search if place not in sys.path]
    with extended_system(()):
        spec.load_extensions()
        resources = prepare(spec)
        _check_same(facts_of(resources), facts)
        if known is not None:
            _check_manager(spec.manager, spec.settings, known, here)
        record_run(spec, resources, folder, known)
    return {file.name: file.read_bytes() for file in folder.iterdir()}


@cache
def _check_manager(manager: str, settings: Settings, known: str, _: str) -> None:
    """Check, once per folder, that a managing system has not changed since the campaign was begun."""
    name = f"managing system {manager}"
    _check_same({name: manager_checksum(manager, settings)}, {name: known})
