"""A file system of its own for a process, with chosen paths, which are read-only.

Landlock keeps a process from opening files, but neither from testing by `stat` whether a path exists and when it
changed, nor from changing permissions and times. Root may have such a file system, and other users where the system
grants them a namespace of users.
"""

import ctypes
import os
import struct
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import cache
from itertools import pairwise
from pathlib import Path
from tempfile import mkdtemp
from typing import Final

from sunset.processes.confinement.privileges import checked, libc

_SIZE: Final = 256 << 20
"""Bytes of all files together that a process makes."""
_FILES: Final = 1 << 16

_NEW_MOUNTS, _NEW_USERS = 0x00020000, 0x10000000
_NO_SETUID, _NO_DEVICES, _BIND, _RECURSIVE, _PRIVATE = 2, 4, 4096, 16384, 1 << 18
_DETACH: Final = 2
_SET_ATTRIBUTES, _AT_RECURSIVE, _READ_ONLY = 442, 0x8000, 1
_PIVOT_ROOT: Final = {"x86_64": 155, "aarch64": 41}


def can_enclose(paths: Iterable[Path]) -> bool:
    """Return whether processes can have a file system of their own with these paths; a fork of this one tries it."""
    if sys.platform != "linux" or os.uname().machine not in _PIVOT_ROOT:
        return False
    folder = Path(mkdtemp(prefix="sunset-")).resolve()
    seen = [path for path in paths if _ways(path)]  # computed once for all copies
    pid = os.fork()
    if pid == 0:
        code = 1
        try:
            enclose(seen, folder)
            code = 0
        finally:
            os._exit(code)
    _, status = os.waitpid(pid, 0)
    folder.rmdir()
    return status == 0


def enclose(paths: Iterable[Path], folder: Path) -> None:
    """Give this process a file system with these files and folders, read-only, and an empty folder in memory.

    A user other than root gets all capabilities, but in this process only.

    Args:
        paths: absolute; they and the links on the way to them keep their places.
        folder: becomes the empty folder and the working directory.

    Raises:
        OSError: the system refuses.
    """
    _unshare_mounts()
    _mount("tmpfs", folder, "tmpfs", _NO_SETUID | _NO_DEVICES, f"size={_SIZE},nr_inodes={_FILES},mode=755")
    _within(folder, folder).mkdir(parents=True)
    _show_all([way for path in paths for way in _ways(path)], folder)
    os.chdir(folder)
    checked(libc().syscall(ctypes.c_long(_PIVOT_ROOT[os.uname().machine]), b".", b"."))
    checked(libc().umount2(b".", _DETACH))
    os.chdir(folder)


def _unshare_mounts() -> None:
    user, group = os.geteuid(), os.getegid()
    checked(libc().unshare(_NEW_MOUNTS | (0 if user == 0 else _NEW_USERS)))
    if user != 0:
        for name, text in (
            ("setgroups", "deny"),
            ("uid_map", f"{user} {user} 1"),
            ("gid_map", f"{group} {group} 1"),
        ):
            Path("/proc/self", name).write_text(text, encoding="ascii")
    _mount("none", Path("/"), "", _RECURSIVE | _PRIVATE)


def _show_all(ways: Sequence[tuple[Path, str | None]], root: Path) -> None:
    """Let files, folders and links be in a new root at their places."""
    shown: set[Path] = set()
    for place in sorted({place for place, target in ways if target == ""}):
        if shown.isdisjoint([place, *place.parents]):
            _show(place, _within(root, place))
            shown.add(place)
    for place, target in ways:
        if target and shown.isdisjoint(place.parents):
            _within(root, place.parent).mkdir(parents=True, exist_ok=True)
            with suppress(FileExistsError):
                _within(root, place).symlink_to(target)
        elif target is None and shown.isdisjoint([place, *place.parents]):
            _within(root, place).mkdir(parents=True, exist_ok=True)


@cache
def _ways(path: Path) -> tuple[tuple[Path, str | None], ...]:
    """Return the links on the way to a path with their targets, and the place at its end with an empty text.

    Folders that the way leaves again by ".." have None. A missing path has no way.
    """
    if not path.exists():
        return ()
    for place in [*reversed(path.parents), path]:
        if place.is_symlink():
            target = str(place.readlink())
            further = _ways(place.parent / target / path.relative_to(place))
            return (*_left(place), (_normal(place), target), *further)
    return (*_left(path), (_normal(path), ""))


def _left(path: Path) -> list[tuple[Path, None]]:
    steps = pairwise([*reversed(path.parents), path])
    return [(_normal(place), None) for place, after in steps if after.name == ".."]


def _normal(path: Path) -> Path:
    """Return a path without links and detours."""
    return Path(os.path.normpath(path))


def _within(root: Path, path: Path) -> Path:
    return root / path.relative_to("/")


def _show(path: Path, place: Path) -> None:
    """Mount a file or folder at another place, read-only."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        with suppress(FileExistsError):
            place.mkdir()
    else:
        place.touch()
    _mount(str(path), place, "", _BIND | _RECURSIVE)
    attributes = struct.pack("=4Q", _READ_ONLY, 0, 0, 0)
    words = ctypes.c_long(_SET_ATTRIBUTES), -1, os.fsencode(place), _AT_RECURSIVE
    checked(libc().syscall(*words, attributes, ctypes.c_size_t(len(attributes))))


def _mount(source: str, place: Path, kind: str, flags: int, options: str = "") -> None:
    words = (source.encode(), os.fsencode(place), kind.encode() or None)
    checked(libc().mount(*words, ctypes.c_ulong(flags), options.encode() or None))
