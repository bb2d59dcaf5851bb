"""The process of a managing system behind walls: its task, its description of itself, and what it runs."""

import inspect
import json
import os
import socket
import sys
import traceback
from collections.abc import Iterable
from functools import partial
from pathlib import Path
from typing import Final

import msgspec

from sunset.errors import ExtensionError, ManagerError
from sunset.managing import (
    KnownScenario,
    ManagingSystem,
    Oracle,
    Program,
    is_registered,
    load_manager,
)
from sunset.rmw.core.port import CallbackError
from sunset.rmw.remote import Pipe, PipeError, RemoteProcess
from sunset.ros import Context, Parameter, SingleThreadedExecutor
from sunset.source_files import LIBRARIES
from sunset.system import load_extension
from sunset.system.vocabulary import Value
from sunset.texts import described_error, line_text, shorten

ENTRY: Final = f"{__name__}:run_manager"
"""What the process calls, as `Confinement` takes it."""


class ManagerTask(msgspec.Struct, frozen=True, kw_only=True):
    """What the process is told.

    Attributes:
        manager: the managing system's name, as of `load_manager`.
        folder: where a path in it begins that is not absolute.
        extensions: what the managed system is extended by.
        environment: variables of the user's environment that it gets; messages do not contain their values.
        parameters: of its node, by name.
        log: whether what it logs goes to stderr, too.
        live: whether that is a live run, in which a message that repeats goes there each time.
        describes_types: whether its node tells others what its types are made of.
        scenario: that of the run, if it is the oracle; None for any other.
    """

    manager: str
    folder: str
    extensions: tuple[str, ...] = ()
    environment: dict[str, str] = {}
    parameters: dict[str, Value] = {}
    log: bool = False
    live: bool = False
    describes_types: bool = False
    scenario: KnownScenario | None = None


class LoadedManager(msgspec.Struct, frozen=True, tag="loaded"):
    """What a managing system that could be loaded is.

    Attributes:
        node_name: its node's.
        modules: the installed modules that it has imported, by the first parts of their names.
    """

    node_name: str
    modules: tuple[str, ...] = ()


class RefusedManager(msgspec.Struct, frozen=True, tag="refused"):
    """Why a managing system cannot be loaded.

    Attributes:
        reason: in a sentence.
        extension: whether an extension of the managed system cannot be loaded in its process.
    """

    reason: str
    extension: bool = False


_SECRET: Final = 4
"""A shorter value cannot be a key, and might be a part of other words."""

_encode = msgspec.msgpack.encode
_decode = msgspec.msgpack.Decoder(LoadedManager | RefusedManager).decode


def receive_loaded(pipe: Pipe, end_s: float) -> LoadedManager:
    """Return what the process at the other end of a pipe says of its managing system.

    Raises:
        ManagerError: it cannot be loaded.
        ExtensionError: an extension cannot be loaded in its process.
        PipeError: the process says nothing, or what is not of the protocol.
    """
    try:
        told: LoadedManager | RefusedManager = _decode(pipe.receive(end_s))
    except msgspec.DecodeError as error:
        raise PipeError(f"sent what is not of the protocol: {error}") from error
    if isinstance(told, RefusedManager) and told.extension:
        raise ExtensionError(
            f"{shorten(told.reason)} That is so in the process of the managing system, which sees the Python files "
            "beside the extension, no other file and no variable of the environment: write into the file what it needs."
        )
    if isinstance(told, RefusedManager):
        raise ManagerError(shorten(told.reason))
    return told


def run_manager(connection: socket.socket, task: object) -> None:
    """Load a managing system, and run it for the process at the other end of a connection, until that is closed."""
    told = msgspec.convert(task, ManagerTask)
    pipe = Pipe(connection)
    os.environ.update(told.environment)
    known = frozenset(() if is_registered(told.manager) else sys.modules)
    try:
        for extension in told.extensions:
            load_extension(extension)
        made = load_manager(told.manager, Path(told.folder))
        loaded = LoadedManager(made.node_name, _installed(sys.modules.keys() - known))
    except (ManagerError, ExtensionError) as error:
        pipe.send(
            _encode(RefusedManager(_without_values(str(error), told), isinstance(error, ExtensionError)))
        )
        return
    pipe.send(_encode(loaded))

    def make(process: RemoteProcess) -> None:
        context = Context()
        context.init([], middleware=process, log_to_stderr=told.log, log_once=not told.live)
        overrides = [Parameter(name, value=value) for name, value in told.parameters.items()]
        construct = partial(Oracle, scenario=told.scenario) if made is Oracle else made
        manager = construct(context=context, parameter_overrides=overrides)
        process.defer(manager.symptoms_subscription.handle)
        SingleThreadedExecutor(context=context).add_node(manager)

    def say(error: BaseException) -> str:
        return _without_values(_said_of(made, error), told)

    RemoteProcess(pipe, make, say, describes_types=told.describes_types).serve()


def _without_values(text: str, task: ManagerTask) -> str:
    """Return a text with the name of each given variable in place of its value, which may be a key.

    A value is also found without the spaces around it, and as Python and JSON write it in quotes.
    """
    for name, value in task.environment.items():
        bare = value.strip()
        for form in (value, bare, repr(value)[1:-1], repr(bare)[1:-1], json.dumps(bare)[1:-1]):
            if len(form) >= _SECRET:
                text = text.replace(form, f"${name}")
    return text


def _installed(names: Iterable[str]) -> tuple[str, ...]:
    """Return the first parts of the names of loaded modules that were installed."""
    files = {name: vars(sys.modules[name]).get("__file__") or "" for name in names}
    return tuple(
        sorted(
            {
                name.partition(".")[0]
                for name, file in files.items()
                if not LIBRARIES.isdisjoint(Path(file).parts)
            }
        )
    )


def _said_of(made: type[ManagingSystem], error: BaseException) -> str:
    """Return what a managing system has raised and where, or what its program did, as the end of a sentence."""
    cause = error.origin if isinstance(error, CallbackError) else error
    if issubclass(made, Program) and isinstance(cause, ManagerError):
        return str(cause).removeprefix("Its program ").removesuffix(".")
    return f"raised {described_error(cause)}{_place(made, cause)}"


def _place(manager: type[ManagingSystem], error: BaseException) -> str:
    """Return which line of the managing system's file was the last to run: ` (mine.py, line 7, in adapt)`."""
    try:
        source = inspect.getsourcefile(manager)
    except (OSError, TypeError):  # a class of a notebook
        source = inspect.getfile(manager.adapt)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == source]
    if source is None or not frames:
        return ""
    return line_text(source, frames[-1].lineno or 0, frames[-1].name)
