"""The C library, for system calls that Python lacks."""

import ctypes
import errno
import os
from functools import cache


@cache
def libc() -> ctypes.CDLL:
    """Return the C library of this process."""
    return ctypes.CDLL(None, use_errno=True)


def checked(result: int) -> int:
    """Return the result of a function of `libc`.

    Raises:
        OSError: the result is negative, since the system refuses.
    """
    if result < 0:
        problem = ctypes.get_errno() or errno.EPERM
        raise OSError(problem, os.strerror(problem))
    return result
