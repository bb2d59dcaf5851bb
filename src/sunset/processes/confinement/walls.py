"""The walls around a confined process: their order, and the walls that a system lacks."""

import os
import resource
import site
import sys
import sysconfig
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Final

from sunset.files.sources import PACKAGES, has_libraries
from sunset.processes.confinement.landlock import SCOPES_SINCE, landlock_version, restrict_files
from sunset.processes.confinement.namespaces import can_enclose, enclose
from sunset.processes.confinement.privileges import drop_root
from sunset.processes.confinement.seccomp import can_filter_calls, filter_calls, filter_program

WALLS: Final = {
    "Landlock": "the user's files can be read and written",
    "seccomp": "what it starts may outlive its run",
    "namespaces": "it may ask by stat whether a path exists, and fill the disk",
}
"""The walls that a system may lack: name → the consequence."""

MEMORY: Final = 4 << 30
"""Bytes of memory that a process may take: a learned managing system brings its framework."""
_FILE: Final = 256 << 20
_OPEN_FILES: Final = 256
_TASKS: Final = 256
"""Processes and threads that there may be besides the present ones."""

_HIDDEN: Final = (PACKAGES["sunset"] / "wild").resolve()
"""Faults that no catalogue lists, which no confined process can read."""
_SYSTEM: Final = (
    *("/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64"),
    *("/etc/alternatives", "/etc/ld.so.cache", "/etc/localtime", "/etc/timezone"),
    *("/etc/ssl", "/etc/pki", "/etc/ca-certificates", "/etc/services"),
    *("/etc/resolv.conf", "/etc/hosts", "/etc/host.conf", "/etc/nsswitch.conf", "/etc/gai.conf"),
    *("/dev/zero", "/dev/random", "/dev/urandom"),
)
"""Paths that programs need, without files of users."""
_DEVICES: Final = (Path("/dev/null"), Path("/dev/full"))


@dataclass(frozen=True, kw_only=True)
class View:
    """Absolute paths that a confined process sees besides Python, this package, system programs and its own folder."""

    modules: tuple[Path, ...] = ()
    """Python files that can be imported, from the first folder of `search` that is above them."""
    search: tuple[Path, ...] = ()
    """Folders in which modules are looked up before all others; they cannot be listed."""
    readable: tuple[Path, ...] = ()
    """Files that can be read and executed, and folders with all files in them."""


def missing_walls() -> dict[str, str]:
    """Return the walls that this system lacks: name → the consequence."""
    present = {
        "Landlock": landlock_version() > 0,
        "seccomp": can_filter_calls(),
        "namespaces": enclosing(),
    }
    return {name: text for name, text in WALLS.items() if not present[name]}


def confinement_report() -> str:
    """Return the walls that this system has, and the consequences of the missing walls, in words."""
    missing = {name: f"no {name}: {text}" for name, text in missing_walls().items()}
    walls = [
        missing.get("Landlock", f"Landlock {landlock_version()}"),
        missing.get("seccomp", "seccomp"),
        "limits of memory, files and processes",
        missing.get("namespaces", "namespaces"),
    ]
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        walls.append("not root")
    return ", ".join(walls)


def put_up(view: View, folder: Path) -> None:
    """Restrict this process and its children to a view and a folder, for ever.

    Raises:
        OSError: the system refuses a wall that it has.
    """
    seen = (*_needed(), *view.modules, *view.readable)
    _limit_resources()
    if enclosing():
        enclose((*seen, *_DEVICES), folder)
    drop_root(folder)
    parts = [_without_hidden(place) for place in seen]
    restrict_files(
        [part for readable, _ in parts for part in readable],
        [folder],
        _DEVICES,
        listed=[part for _, listed in parts for part in listed],
    )
    filter_calls(signals=landlock_version() >= SCOPES_SINCE)


@cache
def enclosing() -> bool:
    """Return whether processes get a file system of their own; the first call forks to try it."""
    return can_enclose((*_needed(), *_DEVICES))


def prepare() -> None:
    """Compute the parts of the walls once for all processes that will be forked from this one."""
    for place in _needed():
        _without_hidden(place)
    enclosing()
    if can_filter_calls():
        filter_program(signals=landlock_version() >= SCOPES_SINCE)


@cache
def _without_hidden(place: Path) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Return the paths at a place that may be read, and the folders above `_HIDDEN`, which may only be listed."""
    real = place.resolve()
    if real.is_relative_to(_HIDDEN):
        return (), ()
    if not _HIDDEN.is_relative_to(real):
        return (place,), ()
    parts = [_without_hidden(part) for part in sorted(real.iterdir()) if real in part.resolve().parents]
    readable = tuple(path for paths, _ in parts for path in paths)
    return readable, (real, *(path for _, paths in parts for path in paths))


def limit_memory() -> None:
    """Let this process take 4 GiB of memory beyond the memory that it has, on Linux, and leave no core dump."""
    _lower(resource.RLIMIT_CORE, 0)
    size = Path("/proc/self/statm")
    if size.exists():
        taken = int(size.read_text(encoding="ascii").split()[5]) * resource.getpagesize()
        _lower(resource.RLIMIT_DATA, taken + MEMORY)


def _limit_resources() -> None:
    _lower(resource.RLIMIT_DATA, MEMORY)
    _lower(resource.RLIMIT_FSIZE, _FILE)
    _lower(resource.RLIMIT_NOFILE, _OPEN_FILES)
    _lower(resource.RLIMIT_CORE, 0)
    if sys.platform == "linux":
        _lower(resource.RLIMIT_NPROC, _TASKS + _tasks())
        # where memory is short, this process goes first
        Path("/proc/self/oom_score_adj").write_text("1000", encoding="ascii")


def _lower(kind: int, limit: int) -> None:
    _, hard = resource.getrlimit(kind)
    limit = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(kind, (limit, limit))


def _tasks() -> int:
    """Return an upper bound of the user's present processes and threads; root becomes a user without any."""
    if os.geteuid() == 0:
        return 0
    return int(Path("/proc/loadavg").read_text(encoding="ascii").split()[3].partition("/")[2])


@cache
def _needed() -> tuple[Path, ...]:
    programs = Path("/etc").glob("java-*")  # Debian's configuration of Java
    places = dict.fromkeys([*map(Path, _SYSTEM), *programs, *PACKAGES.values(), *_python()])
    # this user may not be allowed into the home of the interpreter's owner
    return tuple(place for place in places if os.access(place, os.F_OK))


def _python() -> Iterable[Path]:
    """Return the paths of this interpreter and its packages, without folders that may hold users' files."""
    prefixes = {sys.prefix, sys.base_prefix, sys.exec_prefix, sys.base_exec_prefix}
    parts = ("bin", "lib", "lib64", "share", "ssl", "pyvenv.cfg")
    places = [Path(prefix, part) for prefix in prefixes for part in parts]
    places += [Path(entry) for entry in sys.path if has_libraries(Path(entry))]
    installed = sysconfig.get_paths()
    places += [Path(installed[name]) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    places += [Path(sys.executable), Path(sys.executable).resolve()]
    places += [Path(path) for path in (*site.getsitepackages(), site.getusersitepackages())]
    return places
