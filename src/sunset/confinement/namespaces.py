"""A file system of its own for a process, which cannot see other paths, not even by `stat`.

Landlock keeps a process from opening files, but not from asking with `stat` whether there is one and when it was
changed. Root may have such a file system, and other users where the system lets them have a namespace of users.
"""

import ctypes
import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from itertools import pairwise
from pathlib import Path
from tempfile import mkdtemp
from typing import Final

from sunset.confinement._libc import checked, libc

SIZE: Final = 256 << 20
"""How much the files that a process makes may take, all of them together, in bytes."""
_FILES: Final = 1 << 16

_NEW_MOUNTS, _NEW_USERS = 0x00020000, 0x10000000
_NO_SETUID, _NO_DEVICES, _BIND, _RECURSIVE, _PRIVATE = 2, 4, 4096, 16384, 1 << 18
_DETACH: Final = 2
_PIVOT_ROOT: Final = {"x86_64": 155, "aarch64": 41}


def can_enclose(paths: Iterable[Path]) -> bool:
    """Return whether this process's forks can have a file system of their own, with these; it forks to find out."""
    if sys.platform != "linux" or os.uname().machine not in _PIVOT_ROOT:
        return False
    folder = Path(mkdtemp(prefix="sunset-")).resolve()
    seen = [path for path in paths if _ways(path)]  # found once for all forks
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
    """Give this process a file system with these files and folders, and an empty folder in memory, and nothing else.

    Of a user other than root it makes one who has all capabilities, but in this process only.

    Args:
        paths: absolute; they are at the same places as before, and so are the links on the way to them.
        folder: becomes the empty one and the working directory.

    Raises:
        OSError: the system refuses.
    """
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
    _mount("tmpfs", folder, "tmpfs", _NO_SETUID | _NO_DEVICES, f"size={SIZE},nr_inodes={_FILES},mode=755")
    _within(folder, folder).mkdir(parents=True)
    shown: set[Path] = set()
    ways = [way for path in paths for way in _ways(path)]
    for place in sorted({place for place, target in ways if target == ""}):
        if shown.isdisjoint([place, *place.parents]):
            _show(place, _within(folder, place))
            shown.add(place)
    for place, target in ways:
        if target and shown.isdisjoint(place.parents):
            _within(folder, place.parent).mkdir(parents=True, exist_ok=True)
            with suppress(FileExistsError):
                _within(folder, place).symlink_to(target)
        elif target is None and shown.isdisjoint([place, *place.parents]):
            _within(folder, place).mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
    checked(libc().syscall(ctypes.c_long(_PIVOT_ROOT[os.uname().machine]), b".", b"."))
    checked(libc().umount2(b".", _DETACH))
    os.chdir(folder)


@cache
def _ways(path: Path) -> tuple[tuple[Path, str | None], ...]:
    """Return the links on the way to what a path names, with what is in them, and it itself, with an empty text.

    Folders that the way leaves again, by "..", have None. It is nothing if the path is not there.
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
    """Return a path, on which there are no links, without its detours."""
    return Path(os.path.normpath(path))


def _within(root: Path, path: Path) -> Path:
    return root / path.relative_to("/")


def _show(path: Path, place: Path) -> None:
    """Let a file or folder be at another place, too."""
    place.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        with suppress(FileExistsError):
            place.mkdir()
    else:
        place.touch()
    _mount(str(path), place, "", _BIND | _RECURSIVE)


def _mount(source: str, place: Path, kind: str, flags: int, options: str = "") -> None:
    words = (source.encode(), os.fsencode(place), kind.encode() or None)
    checked(libc().mount(*words, ctypes.c_ulong(flags), options.encode() or None))
