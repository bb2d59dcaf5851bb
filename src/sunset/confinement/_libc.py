"""The C library: calls of the system that Python has no function for."""

import ctypes
import errno
import os
from functools import cache


@cache
def libc() -> ctypes.CDLL:
    """Return the C library of this process."""
    return ctypes.CDLL(None, use_errno=True)


def checked(result: int) -> int:
    """Return what a function of `libc` has returned.

    Raises:
        OSError: it is negative: the system refuses.
    """
    if result < 0:
        problem = ctypes.get_errno() or errno.EPERM
        raise OSError(problem, os.strerror(problem))
    return result
