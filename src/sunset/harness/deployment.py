"""The parameters of a domain's nodes, for any program that starts them.

A managing system may end a node through its lifecycle, and start it again from a launch file of its own. So that the
new node is like the old node, a running system keeps a ROS parameter file, whose place depends on the domain only.
"""

import fcntl
import os
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO

import yaml

from sunset.errors import MiddlewareError, OutputError
from sunset.system import Value


def _file(domain_id: int) -> Path:
    base = os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()
    return Path(base) / f"sunset-{os.getuid()}" / f"domain-{domain_id}.yaml"


def _is_private(folder: Path) -> bool:
    """Return whether a folder is this user's, and no other user can write to it."""
    state = folder.lstat()
    return stat.S_ISDIR(state.st_mode) and state.st_uid == os.getuid() and not state.st_mode & 0o022


def deployed_scenario(domain_id: int) -> Path:
    """Return the file with the scenario of a domain while a system runs there."""
    return _file(domain_id).with_suffix(".scenario.yaml")


@contextmanager
def deployment(
    domain_id: int, parameters: Mapping[str, Mapping[str, Value]], scenario: str
) -> Iterator[None]:
    """Give nodes of a domain their parameters while the context lasts and this process lives.

    Args:
        domain_id: the domain.
        parameters: pattern of full node names, such as `/managed_subsystem/camera` or `/**` → name → value.
        scenario: as YAML, for `deployed_scenario`.

    Raises:
        MiddlewareError: another system runs in the domain.
        OutputError: the file cannot be written, or its folder is another user's.
    """
    content = {node: {"ros__parameters": dict(values)} for node, values in parameters.items()}
    with _locked(domain_id) as file:
        try:
            deployed_scenario(domain_id).write_text(scenario, encoding="utf-8")
            file.truncate(0)
            yaml.safe_dump(content, file, sort_keys=False)
            file.flush()
            yield
        finally:
            deployed_scenario(domain_id).unlink(missing_ok=True)
            _file(domain_id).unlink(missing_ok=True)


def _locked(domain_id: int) -> IO[str]:
    """Open a domain's file, and lock it; the lock shows other processes that its writer lives."""
    path = _file(domain_id)
    try:
        path.parent.mkdir(mode=0o700, exist_ok=True)
        if not _is_private(path.parent):
            raise OutputError(
                f"The folder {path.parent} must be yours, and nobody else may write there: remove it, or set "
                "XDG_RUNTIME_DIR."
            )
        file = path.open("a", encoding="utf-8")
    except OSError as error:
        raise OutputError(f"The parameters {path} cannot be written: {error.strerror}.") from error
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        file.close()
        raise MiddlewareError(
            f"Another system of yours runs in domain {domain_id}: end it, or choose another domain."
        ) from error
    return file


def deployed_parameters(domain_id: int) -> Path | None:
    """Return the file with the parameters of a domain's nodes; None if no system runs there."""
    path = _file(domain_id)
    try:
        if not _is_private(path.parent):
            return None
        with path.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:  # its writer holds the lock
        return path
    except OSError:
        return None
    return None
