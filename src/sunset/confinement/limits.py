"""Limits of a process's memory, files and children."""

import os
import resource
import sys
from pathlib import Path
from typing import Final

MEMORY: Final = 4 << 30
"""Bytes of memory that a process may take: a learned managing system brings its framework."""
_FILE: Final = 256 << 20
_OPEN_FILES: Final = 256
_TASKS: Final = 256
"""Processes and threads that there may be besides the present ones."""


def limit_resources() -> None:
    """Limit the resources of this process and of its children."""
    _lower(resource.RLIMIT_DATA, MEMORY)
    _lower(resource.RLIMIT_FSIZE, _FILE)
    _lower(resource.RLIMIT_NOFILE, _OPEN_FILES)
    _lower(resource.RLIMIT_CORE, 0)
    if sys.platform == "linux":
        _lower(resource.RLIMIT_NPROC, _TASKS + _tasks())
        # where memory is short, this process goes first
        Path("/proc/self/oom_score_adj").write_text("1000", encoding="ascii")


def limit_memory() -> None:
    """Let this process take 4 GiB of memory beyond the memory that it has, on Linux, and leave no core dump."""
    _lower(resource.RLIMIT_CORE, 0)
    size = Path("/proc/self/statm")
    if size.exists():
        taken = int(size.read_text(encoding="ascii").split()[5]) * resource.getpagesize()
        _lower(resource.RLIMIT_DATA, taken + MEMORY)


def _lower(kind: int, limit: int) -> None:
    _, hard = resource.getrlimit(kind)
    limit = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(kind, (limit, limit))


def _tasks() -> int:
    """Return an upper bound of the user's present processes and threads; root becomes a user without any."""
    if os.geteuid() == 0:
        return 0
    return int(Path("/proc/loadavg").read_text(encoding="ascii").split()[3].partition("/")[2])
