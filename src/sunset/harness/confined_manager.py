"""A managing system behind walls, seen from the process that starts, watches and ends it."""

import atexit
import math
import os
import signal
import socket
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from types import MappingProxyType
from typing import Final

from msgspec import to_builtins

from sunset.confinement import ConfinedProcess, Confinement, View, copy_process
from sunset.errors import InvalidInputError, ManagerError, OutputError, SunsetError
from sunset.harness.manager_process import ENTRY, LoadedManager, ManagerTask, receive_loaded, run_manager
from sunset.harness.shown_files import check_shown
from sunset.isolation import Patience, ProcessDeath
from sunset.managing import (
    MANAGERS,
    ORACLE,
    PREFIX,
    KnownScenario,
    checksum,
    is_registered,
    parse_command,
)
from sunset.managing.sources import manager_code, manager_data
from sunset.rmw.remote import EndError, Pipe, PipeError, RaisedError, SilenceError
from sunset.source_files import modules_beside
from sunset.system import Value, loaded_extensions
from sunset.texts import line_text, printable, shorten

_LONGEST: Final = 2000
"""Longest failure text, in characters."""
_LOOK_S: Final = 0.5

_MOST: Final = 200
"""More installed modules than a managing system imports."""

_distributions: Final = cache(packages_distributions)


@cache
def _versions(module: str) -> tuple[tuple[str, str], ...]:
    """Return the names and versions of the distributions that provide an installed module."""
    try:  # most are called as their modules are, which is found faster
        return ((module, version(module)),)
    except (PackageNotFoundError, ValueError):
        return tuple((name, version(name)) for name in sorted(set(_distributions().get(module, ()))))


_servers: dict[int, Confinement] = {}
"""The server of each process, by its number: one that is forked has its own."""


class ManagerProcess:
    """A managing system that has been loaded in a process of its own.

    Attributes:
        manager: its name, as of `load_manager`.
        loaded: what it is.
        pipe: what it is talked to through.
        descriptors: the open files that a process needs that is forked to talk to it.
    """

    def __init__(self, manager: str, process: ConfinedProcess, *, limit_s: float, live: bool) -> None:
        self.manager = manager
        self.pipe = Pipe(process.socket, self._wait)
        self._process = process
        self._patience = Patience(limit_s, live=live)
        try:
            self.loaded: LoadedManager = receive_loaded(self.pipe, time.monotonic() + self.longest_s)
        except PipeError as error:
            raise ManagerError(self.describe(error, "cannot be loaded")) from error

    @property
    def descriptors(self) -> frozenset[int]:
        """The open files through which it is addressed."""
        return self._process.descriptors

    @property
    def pid(self) -> int:
        """The number of its process."""
        return self._process.pid

    @property
    def longest_s(self) -> float:
        """Seconds of wall time that it may take."""
        return self._patience.longest_s

    def _wait(self, timeout_s: float | None) -> bool:
        """Wait as `ConfinedProcess.wait`.

        Raises:
            SilenceError: it has taken too much time.
        """
        since_s = time.monotonic()
        end_s = math.inf if timeout_s is None else since_s + timeout_s
        while not self._process.wait(min(_LOOK_S, end_s - time.monotonic())):
            if self._process.ended:
                return False
            if late := self._patience.passed(self._process.pid, since_s):
                raise SilenceError(late)
            if time.monotonic() >= end_s:
                raise SilenceError(f"did not return within {self.longest_s:g} s")
        return True

    def checksum(self) -> str:
        """Return the SHA-256 of what stands in its files now, in hexadecimal; as `sunset.managing.checksum`.

        Raises:
            ManagerError: one of them is not there any more.
        """
        try:
            return checksum(self.manager)
        except OSError as error:
            raise ManagerError(
                f"A file of the managing system {self.manager} cannot be read any more: {error}."
            ) from error

    def imported_versions(self) -> dict[str, str]:
        """Return the versions of the installed distributions that it has imported, by name."""
        return dict(found for module in self.loaded.modules[:_MOST] for found in _versions(module))

    def describe(self, failure: PipeError, what: str) -> str:
        """Return in a sentence how it has failed, and end it.

        Args:
            failure: what came of the pipe.
            what: says of the managing system what happened, such as `cannot be loaded`.

        Raises:
            SunsetError: its process was ended, and it is not the user's, so that the computer must be the reason.
        """
        if isinstance(failure, RaisedError):
            reason = shorten(str(failure), _LONGEST)
        else:
            late = str(failure) if isinstance(failure, SilenceError) else ""
            if late and self.manager.startswith(PREFIX):
                late += "; its program must answer each line, and flush its output"
            death = self._process.death(late)
            if self.manager in MANAGERS:
                raise killed_error(death, "managing system")
            told = death.reason if isinstance(failure, EndError | SilenceError) else str(failure)
            reason = f"{shorten(told, _LONGEST)}{_place(self.manager, death)}"
        return printable(f"The managing system {self.manager} {what}: it {reason}.").replace("\n", "\\n")

    def interrupt(self) -> None:
        """Shut the socket down, so that a waiting reader returns at once; safe in a signal handler."""
        with suppress(OSError):  # it has ended
            self._process.socket.shutdown(socket.SHUT_RDWR)

    def end(self) -> None:
        """End it, after printing all its remaining output."""
        self._process.kill()


@contextmanager
def manager_process(
    manager: str,
    *,
    limit_s: float,
    variables: Sequence[str] = (),
    parameters: Mapping[str, Value] = MappingProxyType({}),
    log: bool = False,
    live: bool = False,
    describes_types: bool = False,
    scenario: KnownScenario | None = None,
) -> Iterator[ManagerProcess]:
    """Load a managing system in a process of its own, which ends with the context.

    It is forked from a clean server, and sees nothing of its user's but its files. What was passed as a class exists in
    this process only, and is run by a copy of it.

    Args:
        manager: its name, as of `load_manager`.
        limit_s: how long loading it, and each of its callbacks, may take, as of `Patience`.
        variables: names of this process's environment variables that it gets.
        parameters: of its node, by name.
        log: whether what it logs goes to stderr, too.
        live: whether it is of a live run.
        describes_types: whether its node tells others what its types are made of.
        scenario: that of the run, which only the oracle is told.

    Raises:
        ManagerError: it cannot be loaded.
        InvalidInputError: one of the variables is not set.
        SunsetError: no process can be started.
    """
    for name in variables:
        if name not in os.environ:
            raise InvalidInputError(
                f"The environment variable {shorten(repr(name))} for the managing system is not set: export it, or "
                "leave out its --manager-env."
            )
    extensions = loaded_extensions()
    command = parse_command(manager) if manager.startswith(PREFIX) else None
    task = ManagerTask(
        manager=str(command or manager),
        folder=str(Path.cwd()),
        extensions=tuple(extension.where for extension in extensions),
        environment={name: os.environ[name] for name in variables},
        parameters=dict(parameters),
        log=log,
        live=live,
        describes_types=describes_types,
        scenario=scenario if manager == ORACLE else None,
    )
    try:
        if is_registered(manager):
            process = copy_process(run_manager, task)
        else:
            sources = [Path(extension.source) for extension in extensions]
            beside = [file for source in sources for file in modules_beside(source.parent)]
            folders, modules = ((), ()) if manager in MANAGERS and not extensions else manager_code(manager)
            data = manager_data(manager)
            view = View(
                search=(*folders, *(source.parent for source in sources)),
                modules=(*modules, *sources, *beside),
                readable=(*data, *(command.places if command else ())),
            )
            places = (*view.modules, *view.readable)
            check_shown(manager, places, (*data, *(command.files if command else ())))
            process = _server().start(to_builtins(task), view)
    except OSError as error:
        raise OutputError(f"No process can be started for the managing system: {error.strerror}.") from error
    with process:
        yield ManagerProcess(manager, process, limit_s=limit_s, live=live)


def start_server() -> None:
    """Start ahead the server from which managing systems are forked, so that it imports meanwhile what they need."""
    _server()


def _server() -> Confinement:
    own = os.getpid()
    if own not in _servers or not _servers[own].is_running:
        _servers[own] = Confinement(ENTRY)
        atexit.register(_end_server, own)
    return _servers[own]


def _end_server(owner: int) -> None:
    """End the server of a process that ends; not in those that were forked from it."""
    if os.getpid() == owner and owner in _servers:
        _servers.pop(owner).close()


def killed_error(death: ProcessDeath, whose: str) -> SunsetError:
    """Return what a user is told when a process was ended that does nothing that could be the reason."""
    killed = signal.SIGKILL.name in death.reason
    cause = ": it was killed, for instance for want of memory" if killed else ""
    remedy = ", with fewer --jobs if memory was short" if killed else ""
    return SunsetError(
        f"The process of the {whose} {death.reason}{cause}; what was finished is kept: run the same command again"
        f"{remedy}."
    )


def _place(manager: str, death: ProcessDeath) -> str:
    """Return where in a managing system's own file its process ended, if that is known."""
    source = Path(manager.rpartition(":")[0])
    places = [
        line_text(source, line, function)
        for file, line, function in death.frames
        if source.suffix and Path(file) == source.resolve()
    ]
    return places[0] if places else ""
