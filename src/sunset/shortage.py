"""What a computer can run out of, told from what is wrong with a user's files."""

import errno
from typing import Final

__all__ = ["shortage"]

_MEMORY: Final = "there is not enough memory; close other programs, or allow more of it ('ulimit -v')"
_PROCESSES: Final = (
    "no thread or process can be started; close other programs, or allow more ('ulimit -u', 'ulimit -v')"
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


def shortage(error: BaseException) -> str:
    """Return what the computer lacked and what helps, where an error or one that led to it says so; else nothing.

    >>> shortage(OSError(errno.ENOSPC, "No space left on device"))
    'no space left on device; free some space, or name a folder for temporary files in TMPDIR'
    >>> shortage(ValueError("a file is damaged"))
    ''
    """
    cause: BaseException | None = error
    while cause is not None:
        text = str(cause)
        if isinstance(cause, MemoryError) or any(words in text for words in _NO_MEMORY):
            return _MEMORY
        if isinstance(cause, BlockingIOError) or _NO_THREAD in text:
            return _PROCESSES
        if isinstance(cause, OSError) and cause.errno in _REMEDIES:
            reason = cause.strerror or text
            return f"{reason[:1].lower()}{reason[1:]}; {_REMEDIES[cause.errno]}"
        cause = cause.__cause__ or cause.__context__
    return ""
