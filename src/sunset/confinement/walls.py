"""The walls around a confined process: what is put up, in which order, and what a system has none of."""

import os
import resource
import site
import sys
import sysconfig
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Final, Self

from sunset.confinement.landlock import SCOPES_SINCE, landlock_version, restrict_files
from sunset.confinement.namespaces import can_enclose, enclose
from sunset.confinement.privileges import drop_root
from sunset.confinement.seccomp import can_filter_calls, filter_calls, filter_program, forgo_privileges
from sunset.source_files import has_libraries

WALLS: Final = {
    "Landlock": "the user's files can be read and written",
    "seccomp": "what it starts may outlive its run",
    "namespaces": "it may ask by stat whether a path exists, and fill the disk",
}
"""The walls that a system may lack: name → what is open without it."""

MEMORY: Final = 4 << 30
"""How much memory a process may take, in bytes: a learned managing system brings its framework."""
_FILE: Final = 256 << 20
_OPEN_FILES: Final = 256
_TASKS: Final = 256
"""How many processes and threads there may be besides those that there are."""

_PACKAGE: Final = Path(__file__).parents[1]
_HIDDEN: Final = (_PACKAGE / "wild").resolve()
"""What no confined process reads, wherever it is installed: the faults that no catalogue lists."""
_SYSTEM: Final = (
    *("/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64"),
    *(
        "/etc/alternatives",
        "/etc/ld.so.cache",
        "/etc/localtime",
        "/etc/timezone",
        "/etc/ssl",
        "/etc/pki",
        "/etc/ca-certificates",
    ),
    *(
        "/etc/resolv.conf",
        "/etc/hosts",
        "/etc/host.conf",
        "/etc/nsswitch.conf",
        "/etc/gai.conf",
        "/etc/services",
    ),
    *("/dev/zero", "/dev/random", "/dev/urandom"),
)
"""What programs need of a system; no user's own files are there."""
_PROGRAMS: Final = "/etc", "java-*"
"""Where Debian has the configuration of a language's runtime."""
_DEVICES: Final = (Path("/dev/null"), Path("/dev/full"))


@dataclass(frozen=True, kw_only=True)
class View:
    """What a confined process can see besides Python, this package, the system's programs and a folder of its own.

    All paths are absolute.
    """

    modules: tuple[Path, ...] = ()
    """Python files that can be imported, from the first folder of `search` that is above them."""
    search: tuple[Path, ...] = ()
    """Folders in which modules are looked up before all others; they cannot be listed."""
    readable: tuple[Path, ...] = ()
    """Files that can be read and executed, and folders with all that is in them."""
    network: bool = True
    """Whether it has the network."""

    def to_json(self) -> dict[str, object]:
        """Return it as what JSON can hold."""
        return {name: _plain(value) for name, value in asdict(self).items()}

    @classmethod
    def from_json(cls, fields: dict[str, list[str] | bool]) -> Self:
        """Return what `to_json` was made of."""
        made = {
            name: tuple(map(Path, value)) if isinstance(value, list) else value
            for name, value in fields.items()
        }
        return cls(**made)  # type: ignore[arg-type]  # they are of a view


def _plain(value: object) -> object:
    return [str(path) for path in value] if isinstance(value, tuple) else value


def missing_walls() -> dict[str, str]:
    """Return the walls that this system lacks: name → what is open without it."""
    present = {
        "Landlock": landlock_version() > 0,
        "seccomp": can_filter_calls(),
        "namespaces": enclosing(),
    }
    return {name: text for name, text in WALLS.items() if not present[name]}


def confinement_report() -> str:
    """Return which walls this system has, in words, and what is open for want of one."""
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
    """Restrict this process, and what it starts, to a view and a folder, for ever.

    Raises:
        OSError: the system has a wall, but refuses it.
    """
    seen = (*_needed(), *view.modules, *view.readable)
    _limit()
    if enclosing():
        enclose((*seen, *_DEVICES), folder)
    drop_root(folder)
    forgo_privileges()
    parts = [_without_hidden(place) for place in seen]
    restrict_files(
        [part for readable, _ in parts for part in readable],
        [folder],
        _DEVICES,
        listed=[part for _, listed in parts for part in listed],
    )
    filter_calls(network=view.network, signals=landlock_version() >= SCOPES_SINCE)


@cache
def enclosing() -> bool:
    """Return whether processes get a file system of their own; it forks the first time, to find out."""
    return can_enclose((*_needed(), *_DEVICES))


def prepare() -> None:
    """Find out ahead, for all processes that are forked from this one, what the walls are made of."""
    for place in _needed():
        _without_hidden(place)
    enclosing()
    filter_program(network=True, signals=landlock_version() >= SCOPES_SINCE)


@cache
def _without_hidden(place: Path) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Return what may be read at a place, and which folders may be listed only, since what is hidden is in them."""
    real = place.resolve()
    if real.is_relative_to(_HIDDEN):
        return (), ()
    if not _HIDDEN.is_relative_to(real):
        return (place,), ()
    parts = [_without_hidden(part) for part in sorted(real.iterdir()) if real in part.resolve().parents]
    readable = tuple(path for paths, _ in parts for path in paths)
    return readable, (real, *(path for _, paths in parts for path in paths))


def _limit() -> None:
    for what, most in (
        (resource.RLIMIT_DATA, MEMORY),
        (resource.RLIMIT_FSIZE, _FILE),
        (resource.RLIMIT_NOFILE, _OPEN_FILES),
        (resource.RLIMIT_CORE, 0),
    ):
        lower(what, most)
    if sys.platform == "linux":
        lower(resource.RLIMIT_NPROC, _TASKS + _tasks())
        # where memory is short, this process goes first
        Path("/proc/self/oom_score_adj").write_text("1000", encoding="ascii")


def lower(what: int, most: int) -> None:
    """Lower a limit of this process, for ever, unless it is lower."""
    _, hard = resource.getrlimit(what)
    limit = most if hard == resource.RLIM_INFINITY else min(most, hard)
    resource.setrlimit(what, (limit, limit))


def _tasks() -> int:
    """Return how many processes and threads the user may have, at most: all that there are; root will have none."""
    if os.geteuid() == 0:
        return 0
    return int(Path("/proc/loadavg").read_text(encoding="ascii").split()[3].partition("/")[2])


@cache
def _needed() -> tuple[Path, ...]:
    """Return what Python needs of the file system, and what programs do."""
    programs = Path(_PROGRAMS[0]).glob(_PROGRAMS[1])
    places = dict.fromkeys([*map(Path, _SYSTEM), *programs, _PACKAGE, *_python()])
    # a home may be closed to who runs this
    return tuple(place for place in places if os.access(place, os.F_OK))


def _python() -> Iterable[Path]:
    """Return where this interpreter is, and what is installed for it; never a folder that holds other things too."""
    prefixes = {sys.prefix, sys.base_prefix, sys.exec_prefix, sys.base_exec_prefix}
    parts = ("bin", "lib", "lib64", "share", "ssl", "pyvenv.cfg")
    places = [Path(prefix, part) for prefix in prefixes for part in parts]
    places += [Path(entry) for entry in sys.path if has_libraries(Path(entry))]
    installed = sysconfig.get_paths()
    places += [Path(installed[name]) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    places += [Path(sys.executable), Path(sys.executable).resolve()]
    places += [Path(path) for path in (*site.getsitepackages(), site.getusersitepackages())]
    return places
