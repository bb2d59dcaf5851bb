"""A managing system in a confined process, seen from the process that starts, watches and ends it."""

import math
import os
import socket
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, packages_distributions, version
from pathlib import Path
from typing import Final

from msgspec import to_builtins
from msgspec.structs import replace

from sunset.data import cache_folder
from sunset.errors import InvalidInputError, ManagerError, OutputError, ScenarioError
from sunset.files.sources import modules_beside
from sunset.harness.manager_process import (
    ENTRY,
    LoadedManager,
    ManagerSpec,
    ManagerTask,
    receive_loaded,
    run_manager,
)
from sunset.managing import MANAGERS, ORACLE, PREFIX, checksum, is_registered, parse_command
from sunset.managing.program import Command
from sunset.managing.sources import manager_code, manager_data
from sunset.processes.calls import Patience
from sunset.processes.confinement.walls import View
from sunset.processes.process import Process, ProcessDeath, copy_process, killed_error
from sunset.processes.server import ForkServer, shared_server
from sunset.scenarios import load_scenario
from sunset.scenarios.splits import is_scenario_file
from sunset.system import loaded_extensions
from sunset.texts.names import PLAN_FILE, RUN_FILE
from sunset.texts.sentences import line_text
from sunset_ros import Context
from sunset_ros.rmw.remote import EndError, Gateway, Pipe, PipeError, RaisedError, SilenceError
from sunset_ros.texts import printable, shorten

_LONGEST: Final = 2000
"""Longest failure text, in characters."""
_LOOK_S: Final = 0.5

_BAGS: Final = frozenset({".mcap", ".db3", ".bag"})
"""Suffixes of bags, which hold flights with their labels, or runs."""
_SYSTEM: Final = (Path("/proc"), Path("/sys"))
"""Folders that describe processes: the experiment's command line names scenario and seed."""

_distributions: Final = cache(packages_distributions)


@cache
def _versions(module: str) -> tuple[tuple[str, str], ...]:
    """Return the names and versions of the distributions that provide an installed module."""
    try:  # most are called as their modules are, which is found faster
        return ((module, version(module)),)
    except (PackageNotFoundError, ValueError):
        return tuple((name, version(name)) for name in sorted(set(_distributions().get(module, ()))))


class ManagerProcess:
    """A managing system that has been loaded in a process of its own."""

    def __init__(self, spec: ManagerSpec, process: Process) -> None:
        self.manager = spec.manager
        self.pipe = Pipe(process.socket, self._wait)
        self.process = process
        self._patience = Patience(spec.limit_s, live=spec.live)
        self.longest_s = self._patience.longest_s
        """Seconds of wall time that loading it, and each of its callbacks, may take."""
        try:
            self.loaded: LoadedManager = receive_loaded(self.pipe, time.monotonic() + self.longest_s)
        except PipeError as error:
            raise ManagerError(self.describe(error, "cannot be loaded")) from error

    def _wait(self, timeout_s: float | None) -> bool:
        """Wait as `Process.wait`; raise a `SilenceError` after too much time."""
        since_s = time.monotonic()
        end_s = math.inf if timeout_s is None else since_s + timeout_s
        while not self.process.wait(min(_LOOK_S, end_s - time.monotonic())):
            if self.process.ended:
                return False
            if late := self._patience.passed(self.process.pid, since_s):
                raise SilenceError(late)
            if time.monotonic() >= end_s:
                raise SilenceError(f"did not return within {self.longest_s:g} s")
        return True

    def checksum(self) -> str:
        """Return the SHA-256 of the present content of its files, in hexadecimal; as `sunset.managing.checksum`.

        Raises:
            ManagerError: a file cannot be read any more.
        """
        try:
            return checksum(self.manager)
        except OSError as error:
            raise ManagerError(
                f"A file of the managing system {self.manager} cannot be read any more: {error}."
            ) from error

    def imported_versions(self) -> dict[str, str]:
        """Return the versions of the installed distributions that it has imported, by name."""
        return dict(pair for module in self.loaded.modules for pair in _versions(module))

    def describe(self, failure: PipeError, consequence: str) -> str:
        """Return in a sentence how it has failed, with the consequence, such as `cannot be loaded`, and end it.

        Raises:
            SunsetError: the process of one of SUNSET's managing systems has ended, so the computer must be the reason.
        """
        if isinstance(failure, RaisedError):
            reason = shorten(str(failure), _LONGEST)
        else:
            late = str(failure) if isinstance(failure, SilenceError) else ""
            if late and self.manager.startswith(PREFIX):
                late += "; its program must answer each line, and flush its output"
            death = self.process.death(late)
            if self.manager in MANAGERS:
                raise killed_error(death, "managing system")
            text = death.reason if isinstance(failure, EndError | SilenceError) else str(failure)
            reason = f"{shorten(text, _LONGEST)}{_place(self.manager, death)}"
        return printable(f"The managing system {self.manager} {consequence}: it {reason}.").replace(
            "\n", "\\n"
        )

    def interrupt(self) -> None:
        """Shut the socket down, so that a waiting reader returns at once; safe in a signal handler."""
        with suppress(OSError):  # it has ended
            self.process.socket.shutdown(socket.SHUT_RDWR)


@contextmanager
def manager_process(spec: ManagerSpec) -> Iterator[ManagerProcess]:
    """Load a managing system in a process of its own, which ends with the context.

    The process is forked from a clean server, and sees of its user's files only those of the managing system. A class
    that was passed in Python exists only in this process, and runs in a copy of it.

    Raises:
        ManagerError: it cannot be loaded.
        InvalidInputError: one of the variables is not set.
        SunsetError: no process can be started.
    """
    for name in spec.variables:
        if name not in os.environ:
            raise InvalidInputError(
                f"The environment variable {shorten(repr(name))} for the managing system is not set: export it, or "
                "leave out its --manager-env."
            )
    try:
        process = _start(spec)
    except OSError as error:
        raise OutputError(f"No process can be started for the managing system: {error.strerror}.") from error
    with process:
        yield ManagerProcess(spec, process)


def run_confined(spec: ManagerSpec, context: Context, *, occasion: str) -> str:
    """Join a live network for a confined managing system, until it leaves or fails, or the context is shut down.

    This process waits while the managing system runs a callback; its QoS keeps messages meanwhile.

    Returns:
        How it has failed in the run `occasion`, in a sentence; empty if it has not.

    Raises:
        ManagerError: it cannot be loaded.
        SunsetError: no process can be started for it.
    """
    middleware = context.middleware
    failures: list[str] = []
    moment = "could not be constructed"
    with manager_process(spec) as process:
        is_wanted = context.ok()

        def leave() -> None:
            nonlocal is_wanted
            is_wanted = False
            process.interrupt()

        def note(failure: PipeError) -> None:
            if is_wanted:  # else it was interrupted
                failures.append(process.describe(failure, moment))

        context.on_shutdown(leave)
        gateway = Gateway(
            middleware, process.pipe, limit_s=process.longest_s, end=middleware.shutdown, on_failure=note
        )
        if is_wanted:
            gateway.start()
        moment = f"failed in {occasion}"
        while middleware.alive:
            middleware.spin_once(None)
        process.process.kill()
    return "".join(failures)


def _start(spec: ManagerSpec) -> Process:
    """Start the process of a managing system."""
    name = str(_command(spec.manager) or spec.manager)
    task = ManagerTask(
        spec=replace(spec, manager=name, scenario=spec.scenario if name == ORACLE else None),
        folder=str(Path.cwd()),
        extensions=tuple(extension.where for extension in loaded_extensions()),
        environment={name: os.environ[name] for name in spec.variables},
    )
    if is_registered(spec.manager):
        return copy_process(run_manager, task)
    return start_server().start(to_builtins(task), _view(spec.manager))


def _view(manager: str) -> View:
    """Return the paths that the process of a managing system sees; no flights, records or scenarios."""
    extensions, command = loaded_extensions(), _command(manager)
    sources = [Path(extension.source) for extension in extensions]
    beside = [file for source in sources for file in modules_beside(source.parent)]
    folders, modules = ((), ()) if manager in MANAGERS and not extensions else manager_code(manager)
    data = manager_data(manager)
    view = View(
        search=(*folders, *(source.parent for source in sources)),
        modules=(*modules, *sources, *beside),
        readable=(*data, *(command.places if command else ())),
    )
    _check_shown(manager, (*view.modules, *view.readable), (*data, *(command.files if command else ())))
    return view


def _check_shown(manager: str, places: Iterable[Path], files: Iterable[Path]) -> None:
    """Refuse a managing system that would see how its decisions are measured.

    Its process may read `places`, besides installed packages; `files` are the data files among them and in its folders.
    """
    cache = cache_folder().resolve()

    def of_place(place: Path) -> str:
        if cache.is_relative_to(place) or place.is_relative_to(cache):
            return f"and {cache} is where SUNSET keeps flights and their labels"
        if any(place.is_relative_to(folder) for folder in _SYSTEM):
            return "which tells of the computer and its processes"
        return ""

    def of_file(file: Path) -> str:
        if file.suffix in _BAGS:
            return "which is a bag"
        if file.name in {RUN_FILE, PLAN_FILE}:
            return "which is of the record of a run"
        return "which is a scenario" if _is_scenario(file) else ""

    for judge, paths in ((of_place, places), (of_file, files)):
        for path in paths:
            if reason := judge(path.resolve()):
                raise ManagerError(
                    f"The managing system {manager} names {path}, {reason}: keep its files in a folder of their own."
                )


def _is_scenario(file: Path) -> bool:
    with suppress(ScenarioError):
        return is_scenario_file(file) and bool(load_scenario(file))
    return False


def _command(manager: str) -> Command | None:
    return parse_command(manager) if manager.startswith(PREFIX) else None


def start_server() -> ForkServer:
    """Return the server that managing systems are forked from, and start it unless it runs."""
    return shared_server(ENTRY, "sunset.processes.confinement.walls:prepare")


def _place(manager: str, death: ProcessDeath) -> str:
    """Return the line of a managing system's file at which its process ended; empty if that is not known."""
    source = Path(manager.rpartition(":")[0])
    places = [
        line_text(source, line, function)
        for file, line, function in death.frames
        if source.suffix and Path(file) == source.resolve()
    ]
    return places[0] if places else ""
