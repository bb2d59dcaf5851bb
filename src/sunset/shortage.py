"""What a computer can run out of, told from what is wrong with a user's files."""

import errno
from typing import Final

from sunset.errors import SunsetError
from sunset.texts import sentence

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
"""What loaders and libraries say that raise no `MemoryError`."""

_LIBRARIES: Final = frozenset({"cv2", "onnxruntime"})
"""Packages whose errors are of types of their own."""

_STARTERS: Final = frozenset({"fork", "forkpty", "fork_exec", "_fork_exec", "posix_spawn"})
"""Functions that start a process; a file that another process has locked gives the same error."""


def complaint(error: Exception) -> str:
    """Return one sentence on an error that is not a mistake of the program's; of another nothing.

    >>> complaint(SunsetError("There is no seed -1"))
    'There is no seed -1.'
    >>> complaint(ValueError("a bug"))
    ''
    """
    if isinstance(error, SunsetError):
        text = str(error)
    elif lacking := shortage(error):
        text = f"The computer could not go on: {lacking}"
    elif isinstance(error, OSError):
        what = f"to use {error.filename}" if error.filename else "an operation"
        text = f"The operating system refused {what}: {error.strerror or error}"
    else:
        return ""
    return " ".join(sentence(text).split()).rstrip(".") + "."


def shortage(error: BaseException) -> str:
    """Return what the computer lacked and what helps, where an error or one that led to it says so; else nothing.

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
    """Return what an error says where that can be of a shortage; without the name of a file."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    of_library = type(error).__module__.partition(".")[0] in _LIBRARIES
    return str(error) if of_library or isinstance(error, ImportError | RuntimeError | OSError) else ""


def _starts_no_process(error: BaseException) -> bool:
    """Return whether the function that raised the error was to start a process, and may do so later."""
    trace = error.__traceback__
    if not isinstance(error, BlockingIOError) or error.errno != errno.EAGAIN or trace is None:
        return False
    while trace.tb_next is not None:
        trace = trace.tb_next
    return not _STARTERS.isdisjoint(trace.tb_frame.f_code.co_names)
