"""Campaigns on an executor, whose workers may be on other computers and share no files with this computer."""

import logging
import pickle
import re
import socket
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import CancelledError, Executor, Future, as_completed
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Final

from sunset.errors import InvalidInputError, MissingExtraError, SunsetError
from sunset.experiments.spec import RunSpec
from sunset.experiments.worker import Order, check_same, do_run, labelled_versions, on_worker
from sunset.recording import RecordWriter
from sunset_ros.texts import shorten, shown

if TYPE_CHECKING:
    from distributed import Client, Worker

_ADDRESS: Final = re.compile(r"tcp://(?P<host>[^:/\[\]\s]+|\[[^\[\]\s]+\]):(?P<port>[0-9]{1,5})")
_PATIENCE_S: Final = 10
"""How long a scheduler may take to answer."""
_GREETING: Final = b"pickle-protocol"
"""Part of the first bytes that a scheduler sends."""
_LONGEST_GREETING: Final = 1 << 16
_LONGEST: Final = 300
"""Longest failure text of an executor, in characters."""
_log: Final = logging.getLogger(__name__)
_KEPT: Final = "what was finished is kept: run the same command again"


def check_executor(executor: object) -> None:
    """Check that an object is an executor."""
    if not isinstance(executor, Executor):
        hint = ": it gives one by get_executor()" if hasattr(executor, "get_executor") else ""
        raise InvalidInputError(
            f"The executor must be a concurrent.futures.Executor, got {shown(executor)}{hint}."
        )


def run_on_workers(
    executor: Executor, todo: Sequence[tuple[RunSpec, Path, str | None, Mapping[str, str]]]
) -> Iterator[int]:
    """Do runs on an executor's workers and write their records; yield how many are finished, after each.

    Args:
        executor: it may do them in any order, and repeat those that it has lost.
        todo: each run, its folder, the checksum of its managing system, and the expected `facts_of` its resources.
    """
    expected, here, search = labelled_versions(), str(Path.cwd()), tuple(filter(None, sys.path))
    folders: dict[Future[dict[str, bytes]], Path] = {}
    try:
        with _translated():
            for spec, folder, known, facts in todo:
                order = pickle.dumps(Order(spec, known, facts, here, search))
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
        raise SunsetError(f"The executor has failed, {_described(error)}; {_KEPT}.") from error


def _described(error: Exception) -> str:
    return shorten(" ".join(f"{type(error).__name__}: {error}".split()), _LONGEST).rstrip(".")


@contextmanager
def connected_scheduler(address: str) -> Iterator[Executor]:
    """Give an executor on the workers of a dask scheduler, all of which have the same versions as this computer.

    Args:
        address: the scheduler's, such as `tcp://10.0.0.1:8786`.
    """
    if find_spec("distributed") is None:
        raise MissingExtraError(
            "A scheduler needs dask.distributed, not installed: pip install 'sunset-exemplar[cluster]'."
        )
    with _client(address) as client:
        try:
            versions = client.run(labelled_versions)
        except Exception as error:
            raise SunsetError(
                f"A worker of the scheduler {address} did not report its versions, {_described(error)}: install the "
                "same SUNSET on all workers."
            ) from error
        for where, theirs in versions.items():
            with on_worker(where):
                check_same(theirs, labelled_versions())
        for where, status in client.run(_status).items():
            if status == "paused":
                _log.warning(
                    "The worker %s is paused, as dask does where memory is short: it begins no run.", where
                )
        if not versions:
            _log.warning("The scheduler %s has no workers yet: the campaign waits for them.", address)
        yield client.get_executor(pure=False)


def _status(dask_worker: "Worker") -> str:
    """Return `running` or `paused`; dask passes the worker."""
    return str(dask_worker.status.name)


def _await_greeting(host: str, port: int) -> None:
    """Check that a scheduler, which speaks first, is there: dask's client would wait for it for ever."""
    with socket.create_connection((host, port), _PATIENCE_S) as connection:
        connection.settimeout(_PATIENCE_S)
        greeting = b""
        while _GREETING not in greeting:
            part = connection.recv(_LONGEST_GREETING)
            greeting += part
            if not part or len(greeting) > _LONGEST_GREETING:
                raise ConnectionError("it is not a scheduler")


@contextmanager
def _client(address: str) -> Iterator["Client"]:
    match = _ADDRESS.fullmatch(address)
    if match is None:
        raise InvalidInputError(
            f"The scheduler's address must be tcp://HOST:PORT, as 'dask scheduler' prints it, got {shown(address)}."
        )
    from distributed import Client  # noqa: PLC0415  an optional extra

    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # an error is reported once
    try:
        _await_greeting(match["host"].strip("[]"), int(match["port"]))
        client = Client(address, timeout=_PATIENCE_S, set_as_default=False)
    except (OSError, OverflowError, ValueError) as error:
        raise InvalidInputError(
            f"No scheduler answers at {address}: {error}; start one with 'dask scheduler', and workers with 'dask "
            f"worker {address}'."
        ) from error
    with client:
        yield client
