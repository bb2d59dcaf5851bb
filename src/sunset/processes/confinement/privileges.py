"""Dropping root: the process becomes a user that owns no files; and system calls that Python lacks."""

import ctypes
import errno
import os
import struct
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Final

_FIRST_USER: Final = 61184
_USERS: Final = 4336
"""The range of users that systemd lends to services, so that no person has one of them."""

_READ_ANY_FILE: Final = 2
_OVERRIDE: Final = 1
_KEEP, _AMBIENT, _RAISE = 8, 47, 2
_NO_NEW_PRIVILEGES: Final = 38
_VERSION: Final = 0x20080522


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


def drop_root(folder: Path) -> None:
    """Drop all capabilities for ever, and make root an unprivileged user, which can still read what root can; on Linux.

    Root could signal and trace all processes, and limits on the number of its processes would not bind it. It stays
    root, without capabilities, where it may not change its user.

    Args:
        folder: the new user owns it.
    """
    if sys.platform != "linux":
        return
    library = libc()
    permitted = _permitted() if os.geteuid() == 0 else 0
    kept = next((1 << number for number in (_READ_ANY_FILE, _OVERRIDE) if permitted >> number & 1), 0)
    if os.geteuid() == 0:
        library.prctl(_KEEP, 1, 0, 0, 0)
        user = _FIRST_USER + os.getpid() % _USERS
        with suppress(OSError):  # it may not, in a container for instance
            os.chown(folder, user, user)
            os.setgroups([])
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
    _set_capabilities(kept)
    if kept:  # for the programs that it starts, too
        library.prctl(_AMBIENT, _RAISE, kept.bit_length() - 1, 0, 0)
    checked(library.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0))


def _permitted() -> int:
    data = ctypes.create_string_buffer(24)
    if libc().capget(struct.pack("=Ii", _VERSION, 0), data) != 0:
        return 0
    _, low, _, _, high, _ = struct.unpack("=6I", data.raw)
    return int(low) | int(high) << 32


def _set_capabilities(kept: int) -> None:
    header = struct.pack("=Ii", _VERSION, 0)
    low, high = kept & 0xFFFFFFFF, kept >> 32
    checked(libc().capset(header, struct.pack("=6I", low, low, low, high, high, high)))
