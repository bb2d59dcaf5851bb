"""The exceptions of SUNSET.

Every error that a user can cause derives from `SunsetError`, and the command line turns it into one sentence on stderr
and exit code 2. `InvalidInputError` and its subclasses are about what a user wrote or passed.
"""
# ruff: noqa: PLC0414  the names are imported to be exported

import errno
from typing import Final

from sunset_ros.errors import MALFORMED_YAML as MALFORMED_YAML
from sunset_ros.errors import InterfaceError as InterfaceError
from sunset_ros.errors import InvalidInputError as InvalidInputError
from sunset_ros.errors import MiddlewareError as MiddlewareError
from sunset_ros.errors import MissingExtraError as MissingExtraError
from sunset_ros.errors import ParameterError as ParameterError
from sunset_ros.errors import SunsetError as SunsetError
from sunset_ros.texts import sentence

_MEMORY: Final = "there is not enough memory; close other programs, or allow more of it ('ulimit -v')"
_PROCESSES: Final = (
    "no thread or process can be started; close other programs, or allow more ('ulimit -u', 'ulimit -v'; in a "
    "container, the system call clone3)"
)
_DISK: Final = "free some space, or name a folder for temporary files in TMPDIR"
_REMEDIES: Final = {
    errno.EMFILE: "allow more of them ('ulimit -n')",
    errno.ENFILE: "close other programs",
    errno.ENOSPC: _DISK,
    errno.EDQUOT: _DISK,
}
_NO_THREAD: Final = "can't start new thread"
_NO_MEMORY: Final = (
    "failed to map segment",
    "annot allocate memory",
    "bad_alloc",
    "Insufficient memory",
    "not enough memory",
)
"""Messages of loaders and libraries that raise other errors than `MemoryError`."""

_LIBRARIES: Final = frozenset({"cv2", "onnxruntime"})
"""Packages with error types of their own."""

_STARTERS: Final = frozenset({"fork", "forkpty", "fork_exec", "_fork_exec", "posix_spawn"})
"""Functions that start a process; for a file that another process has locked, the error is the same."""


class ScenarioError(InvalidInputError):
    """A scenario or suite is unknown, malformed or out of range."""


class DataError(InvalidInputError):
    """A bag, a frame or a data set is missing, truncated or of another kind."""


class ModelError(InvalidInputError):
    """Weights or a model card are missing, corrupt or of another shape."""


class ExtensionError(InvalidInputError):
    """An extension of the managed system cannot be imported, contradicts itself or the system, or fails."""


class RecordError(InvalidInputError):
    """A record or a folder of results is missing, corrupt or of another version."""


class ManagerError(SunsetError):
    """A managing system cannot be loaded, raised an exception, or did not return."""


class OutputError(SunsetError):
    """A result cannot be written: no permission, no space, no such folder."""


def complaint(error: Exception) -> str:
    """Return a sentence on an error that is not a bug; empty for a bug.

    >>> complaint(SunsetError("The seed is negative"))
    'The seed is negative.'
    >>> complaint(ValueError("a bug"))
    ''
    """
    if isinstance(error, SunsetError):
        text = str(error)
    elif lacking := shortage(error):
        text = f"The computer could not go on: {lacking}"
    elif isinstance(error, OSError):
        operation = f"to use {error.filename}" if error.filename else "an operation"
        text = f"The operating system refused {operation}: {error.strerror or error}"
    else:
        return ""
    return " ".join(sentence(text).split()).rstrip(".") + "."


def shortage(error: BaseException) -> str:
    """Return the resource that the computer lacks and the remedy, if an error or its cause names it; else nothing.

    >>> shortage(OSError(errno.ENOSPC, "No space left on device"))
    'no space left on device; free some space, or name a folder for temporary files in TMPDIR'
    >>> shortage(ValueError("a file is damaged"))
    ''
    """
    cause: BaseException | None = error
    while cause is not None:
        text = _text(cause)
        if isinstance(cause, MemoryError) or any(words in text for words in _NO_MEMORY):
            return _MEMORY
        if _starts_no_process(cause) or _NO_THREAD in text:
            return _PROCESSES
        if isinstance(cause, OSError) and cause.errno in _REMEDIES:
            reason = cause.strerror or text
            return f"{reason[:1].lower()}{reason[1:]}; {_REMEDIES[cause.errno]}"
        cause = cause.__cause__ or cause.__context__
    return ""


def _text(error: BaseException) -> str:
    """Return the text of an error that may be a shortage, without the name of a file."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    of_library = type(error).__module__.partition(".")[0] in _LIBRARIES
    return str(error) if of_library or isinstance(error, ImportError | RuntimeError | OSError) else ""


def _starts_no_process(error: BaseException) -> bool:
    """Return whether an error came from starting a process, which may succeed later."""
    trace = error.__traceback__
    if not isinstance(error, BlockingIOError) or error.errno != errno.EAGAIN or trace is None:
        return False
    while trace.tb_next is not None:
        trace = trace.tb_next
    return not _STARTERS.isdisjoint(trace.tb_frame.f_code.co_names)
