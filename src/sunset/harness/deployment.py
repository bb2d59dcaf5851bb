"""The parameters that nodes of a domain get, whichever program starts them.

The launcher of a running system is not the only one that may start a node: a managing system may end one through
its lifecycle and start it anew from a launch file of its own. So that the new one is like the old one, the system
keeps a ROS parameter file in a place that depends on the domain only, for as long as it runs.
"""

import os
import stat
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import yaml

from sunset.errors import MiddlewareError, OutputError
from sunset.system import Value


def _is_ours(folder: Path) -> bool:
    """Return whether a folder in a place that everybody can write to is this user's, and no other user's."""
    state = folder.lstat()
    return stat.S_ISDIR(state.st_mode) and state.st_uid == os.getuid() and not state.st_mode & 0o022


def _file(domain_id: int) -> Path:
    base = os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()
    return Path(base) / f"sunset-{os.getuid()}" / f"domain-{domain_id}.yaml"


def deployed_scenario(domain_id: int) -> Path:
    """Return the file with the scenario of a domain while a system runs there."""
    return _file(domain_id).with_suffix(".scenario.yaml")


@contextmanager
def deployment(
    domain_id: int, parameters: Mapping[str, Mapping[str, Value]], scenario: str
) -> Iterator[None]:
    """Give nodes of a domain their parameters while the context lasts, and no longer if this process is killed.

    Args:
        domain_id: the domain.
        parameters: pattern of full node names, such as `/managed_subsystem/camera` or `/**` → name → value.
        scenario: as YAML, for `deployed_scenario`.

    Raises:
        MiddlewareError: another system runs in the domain.
        OutputError: the file cannot be written, or its folder is another user's.
    """
    import fcntl  # noqa: PLC0415  not on every system

    path = _file(domain_id)
    content = {node: {"ros__parameters": dict(values)} for node, values in parameters.items()}
    try:
        path.parent.mkdir(mode=0o700, exist_ok=True)
        if not _is_ours(path.parent):
            raise OutputError(
                f"The folder {path.parent} must be yours, and nobody else may write there: remove it, or set "
                "XDG_RUNTIME_DIR."
            )
        file = path.open("a", encoding="utf-8")
    except OSError as error:
        raise OutputError(f"The parameters {path} cannot be written: {error.strerror}.") from error
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise MiddlewareError(
                f"Another system of yours runs in domain {domain_id}: end it, or choose another domain."
            ) from error
        try:
            deployed_scenario(domain_id).write_text(scenario, encoding="utf-8")
            file.truncate(0)
            yaml.safe_dump(content, file, sort_keys=False)
            file.flush()
            yield
        finally:
            deployed_scenario(domain_id).unlink(missing_ok=True)
            path.unlink(missing_ok=True)


def deployed_parameters(domain_id: int) -> Path | None:
    """Return the file with the parameters of a domain's nodes; None if no system runs there."""
    import fcntl  # noqa: PLC0415  not on every system

    path = _file(domain_id)
    try:
        if not _is_ours(path.parent):
            return None
        with path.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:  # its writer holds it, so that it lives
        return path
    except OSError:
        return None
    return None
