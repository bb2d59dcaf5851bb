"""Landlock: a process and its children give up the paths that they do not need, for ever.

Linux has it from 5.13 on; `landlock(7)` lists the rights that each version of its interface can restrict. It restricts
opening, making, renaming and removing files, but not `stat`. It also denies tracing processes outside, and mounting.
"""

import ctypes
import os
import stat
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Final

from sunset.processes.confinement.privileges import checked, libc

_CREATE_RULESET: Final = 444
_ADD_RULE: Final = 445
_RESTRICT_SELF: Final = 446
_GIVE_VERSION: Final = 1
_PATH_BENEATH: Final = 1

_EXECUTE: Final = 1 << 0
_WRITE_FILE: Final = 1 << 1
_READ_FILE: Final = 1 << 2
_READ_DIR: Final = 1 << 3
_MAKE_CHAR: Final = 1 << 6
_MAKE_BLOCK: Final = 1 << 11
_TRUNCATE: Final = 1 << 14
_IOCTL_DEV: Final = 1 << 15
_OF_FILES: Final = _EXECUTE | _WRITE_FILE | _READ_FILE | _TRUNCATE | _IOCTL_DEV
"""The rights that a rule for a file can allow; the others are of folders."""
_READ: Final = _EXECUTE | _READ_FILE | _READ_DIR

_RIGHTS: Final = {1: 13, 2: 14, 3: 15, 5: 16}
"""Version → the number of rights from this version on."""
_NET_SINCE: Final = 4
SCOPES_SINCE: Final = 6
"""The first version that restricts abstract sockets and signals to other processes."""
_SCOPES: Final = 0b11


class _Ruleset(ctypes.Structure):
    _fields_ = (("files", ctypes.c_uint64), ("net", ctypes.c_uint64), ("scoped", ctypes.c_uint64))


class _PathBeneath(ctypes.Structure):
    _pack_ = 1
    _layout_ = "ms"
    _fields_ = (("allowed", ctypes.c_uint64), ("folder", ctypes.c_int32))


def landlock_version() -> int:
    """Return the version of Landlock's interface; 0 without Landlock."""
    if sys.platform != "linux":
        return 0
    with suppress(OSError):
        return _call(_CREATE_RULESET, None, 0, _GIVE_VERSION)
    return 0


def restrict_files(
    readable: Iterable[Path], writable: Iterable[Path], devices: Iterable[Path], listed: Iterable[Path] = ()
) -> None:
    """Let this thread and its children open only these files and folders, where the kernel has Landlock.

    From version 6 on, they can also neither signal other processes nor reach abstract sockets. The process must have
    called `drop_root`. Missing paths are left out.

    Args:
        readable: may be read, listed and executed.
        writable: folders in which everything is allowed except making devices.
        devices: may be read and written.
        listed: folders that may be listed, with the folders in them.
    """
    version = landlock_version()
    if not version:
        return
    handled = (1 << max(rights for since, rights in _RIGHTS.items() if since <= version)) - 1
    rights = {
        _READ: readable,
        handled & ~(_MAKE_CHAR | _MAKE_BLOCK | _IOCTL_DEV): writable,
        _READ_FILE | _WRITE_FILE | _TRUNCATE: devices,
        _READ_DIR: listed,
    }
    size = 8 if version < _NET_SINCE else 16 if version < SCOPES_SINCE else 24
    rules = _call(_CREATE_RULESET, ctypes.byref(_Ruleset(handled, 0, _SCOPES)), size, 0)
    try:
        for allowed, paths in rights.items():
            for path in paths:
                with suppress(FileNotFoundError, NotADirectoryError):
                    _allow(rules, path, allowed & handled)
        _call(_RESTRICT_SELF, rules, 0)
    finally:
        os.close(rules)


def _allow(rules: int, path: Path, allowed: int) -> None:
    beneath = os.open(path, os.O_PATH | os.O_CLOEXEC)
    try:
        if not stat.S_ISDIR(os.fstat(beneath).st_mode):
            allowed &= _OF_FILES
        rule = _PathBeneath(allowed, beneath)
        _call(_ADD_RULE, rules, _PATH_BENEATH, ctypes.byref(rule), 0)
    finally:
        os.close(beneath)


def _call(number: int, *arguments: object) -> int:
    words = [ctypes.c_long(argument) if isinstance(argument, int) else argument for argument in arguments]
    return checked(libc().syscall(ctypes.c_long(number), *words))
