"""The process of a confined managing system: its task, its description, and its program."""

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
from sunset.files.sources import LIBRARIES
from sunset.managing import KnownScenario, ManagingSystem, Oracle, Program, is_registered, load_manager
from sunset.system import load_extension
from sunset.system.vocabulary import Value
from sunset.texts.sentences import described_error, line_text
from sunset_ros import Context, Parameter, SingleThreadedExecutor
from sunset_ros.rmw.core.port import CallbackError
from sunset_ros.rmw.remote import Pipe, PipeError, RemoteProcess
from sunset_ros.texts import shorten

ENTRY: Final = f"{__name__}:run_manager"
"""The function that the process calls, as in `ForkServer`."""


class ManagerSpec(msgspec.Struct, frozen=True, kw_only=True):
    """A managing system, and how it runs."""

    manager: str
    """Its name, as in `load_manager`."""
    limit_s: float
    """How long loading it, and each of its callbacks, may take, as in `Patience`."""
    variables: tuple[str, ...] = ()
    """Names of the user's environment variables that it gets."""
    parameters: dict[str, Value] = {}
    """Of its node, by name."""
    log: bool = False
    """Whether its log goes to stderr, too."""
    live: bool = False
    """Whether the run is live, so that repeated messages go there each time."""
    scenario: KnownScenario | None = None
    """The run's scenario, which only the oracle gets."""


class ManagerTask(msgspec.Struct, frozen=True, kw_only=True):
    """The task of a managing system's process."""

    spec: ManagerSpec
    folder: str
    """The folder of relative paths in its name."""
    extensions: tuple[str, ...]
    environment: dict[str, str]
    """Its environment variables; messages do not contain their values."""


class LoadedManager(msgspec.Struct, frozen=True):
    """The description of a loaded managing system, or the reason why it, or an extension, cannot be loaded."""

    node_name: str = ""
    modules: tuple[str, ...] = ()
    """The installed modules that it has imported, by the first parts of their names."""
    refusal: str = ""
    is_extension: bool = False


_SECRET: Final = 4
"""A shorter value cannot be a key, and might be a part of other words."""

_encode = msgspec.msgpack.encode
_decode = msgspec.msgpack.Decoder(LoadedManager).decode


def receive_loaded(pipe: Pipe, end_s: float) -> LoadedManager:
    """Return the description of the managing system at the other end of a pipe.

    Raises:
        ManagerError: it cannot be loaded.
        ExtensionError: an extension cannot be loaded in its process.
        PipeError: the process sends nothing, or an invalid message.
    """
    try:
        message = _decode(pipe.receive(end_s))
    except msgspec.DecodeError as error:
        raise PipeError(f"sent what is not of the protocol: {error}") from error
    if message.refusal and message.is_extension:
        raise ExtensionError(
            f"{shorten(message.refusal)} That is so in the process of the managing system, which sees the Python files "
            "beside the extension, no other file and no variable of the environment: write into the file what it needs."
        )
    if message.refusal:
        raise ManagerError(shorten(message.refusal))
    return message


def run_manager(connection: socket.socket, task: object) -> None:
    """Load a managing system, and run it for the process at the other end of a connection until that is closed."""
    order = msgspec.convert(task, ManagerTask)
    pipe, spec = Pipe(connection), order.spec
    os.environ.update(order.environment)
    try:
        manager_class, loaded = _load(order)
    except (ManagerError, ExtensionError) as error:
        reason = _without_values(str(error), order)
        pipe.send(_encode(LoadedManager(refusal=reason, is_extension=isinstance(error, ExtensionError))))
        return
    pipe.send(_encode(loaded))

    def construct(process: RemoteProcess) -> None:
        context = Context()
        context.init([], middleware=process, log_to_stderr=spec.log, log_once=not spec.live)
        overrides = [Parameter(name, value=value) for name, value in spec.parameters.items()]
        make = partial(Oracle, scenario=spec.scenario) if manager_class is Oracle else manager_class
        manager = make(context=context, parameter_overrides=overrides)
        process.defer(manager.symptoms_subscription.handle)
        SingleThreadedExecutor(context=context).add_node(manager)

    def describe(error: BaseException) -> str:
        return _without_values(_description(manager_class, error), order)

    RemoteProcess(pipe, construct, describe).serve()


def _load(order: ManagerTask) -> tuple[type[ManagingSystem], LoadedManager]:
    name = order.spec.manager
    known = frozenset(() if is_registered(name) else sys.modules)
    for extension in order.extensions:
        load_extension(extension)
    manager_class = load_manager(name, Path(order.folder))
    return manager_class, LoadedManager(manager_class.node_name, _installed(sys.modules.keys() - known))


def _without_values(text: str, task: ManagerTask) -> str:
    """Return a text with the name of each environment variable in place of its value, which may be a key.

    The value is also replaced without the spaces around it, and as Python and JSON write it in quotes.
    """
    for name, value in task.environment.items():
        bare = value.strip()
        for form in (value, bare, repr(value)[1:-1], repr(bare)[1:-1], json.dumps(bare)[1:-1]):
            if len(form) >= _SECRET:
                text = text.replace(form, f"${name}")
    return text


def _installed(names: Iterable[str]) -> tuple[str, ...]:
    """Return the first parts of the names of loaded modules that were installed."""
    files = {name: Path(vars(sys.modules[name]).get("__file__") or "") for name in names}
    installed = {name for name, file in files.items() if not LIBRARIES.isdisjoint(file.parts)}
    return tuple(sorted({name.partition(".")[0] for name in installed}))


def _description(manager: type[ManagingSystem], error: BaseException) -> str:
    """Return the error of a managing system with its place, or of its program, as the end of a sentence."""
    cause = error.origin if isinstance(error, CallbackError) else error
    if issubclass(manager, Program) and isinstance(cause, ManagerError):
        return str(cause).removeprefix("Its program ").removesuffix(".")
    return f"raised {described_error(cause)}{_place(manager, cause)}"


def _place(manager: type[ManagingSystem], error: BaseException) -> str:
    """Return the last line of the managing system's file that ran: ` (mine.py, line 7, in adapt)`."""
    try:
        source = inspect.getsourcefile(manager)
    except (OSError, TypeError):  # a class of a notebook
        source = inspect.getfile(manager.adapt)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename == source]
    if source is None or not frames:
        return ""
    return line_text(source, frames[-1].lineno or 0, frames[-1].name)
