"""The parameters of a domain's nodes, for any program that starts them.

A managing system may end a node through its lifecycle, and start it again from a launch file of its own. So that the
new node is like the old node, a running system keeps a ROS parameter file, whose place depends on the domain only.
"""

import fcntl
import os
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import yaml

from sunset.errors import OutputError
from sunset.system import Value


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
    """Give nodes of a domain, whose only system this is, their parameters while the context lasts.

    The keys of `parameters` are patterns of full node names, such as `/managed_subsystem/camera` or `/**`. The scenario
    is YAML.

    Raises:
        OutputError: the file cannot be written.
    """
    content = {node: {"ros__parameters": dict(values)} for node, values in parameters.items()}
    path = _file(domain_id)
    try:
        path.parent.mkdir(mode=0o700, exist_ok=True)
        file = path.open("w", encoding="utf-8")
    except OSError as error:
        raise OutputError(f"The parameters {path} cannot be written: {error.strerror}.") from error
    with file:
        fcntl.flock(file, fcntl.LOCK_EX)  # it shows other processes that this one lives
        try:
            deployed_scenario(domain_id).write_text(scenario, encoding="utf-8")
            yaml.safe_dump(content, file, sort_keys=False)
            file.flush()
            yield
        finally:
            deployed_scenario(domain_id).unlink(missing_ok=True)
            path.unlink(missing_ok=True)


def deployed_parameters(domain_id: int) -> Path | None:
    """Return the file with the parameters of a domain's nodes; None if no system runs there."""
    path = _file(domain_id)
    try:
        with path.open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:  # its writer holds the lock
        return path
    except OSError:
        return None
    return None
