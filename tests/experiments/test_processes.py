"""Nodes as processes: forked where that can be done, started anew where not."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from sunset.experiments.processes import NodeProcesses
from sunset.rmw.domains import free_domain_id

PATIENCE_S = 60.0


class Nodes(NodeProcesses):
    """A camera, and a node that there is not; `lines` has what they print, `ended` those that ended."""

    def __init__(self, domain_id: int) -> None:
        self.lines: list[str] = []
        self.ended: list[str] = []
        variables = {"ROS_DOMAIN_ID": str(domain_id)}
        super().__init__(
            {"camera": ["camera"], "rotor": ["rotor"]}, variables, lambda _, line: self.lines.append(line)
        )
        self.on_exit(self.ended.append)

    def polled_until(self, predicate: Callable[[], bool]) -> bool:
        """Poll until a predicate holds; return whether it does."""
        end = time.monotonic() + PATIENCE_S
        while not predicate() and time.monotonic() < end:
            self.poll()
            threading.Event().wait(0.01)
        return predicate()


@pytest.fixture(params=["forked", "started"])
def nodes(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Iterator[Nodes]:
    if request.param == "started":
        monkeypatch.setattr("sunset.experiments.processes.can_fork", lambda: False)
    with free_domain_id() as domain_id, Nodes(domain_id) as made:
        yield made


def test_a_node_that_cannot_start_says_why(nodes: Nodes) -> None:
    nodes.start("rotor")
    assert nodes.polled_until(lambda: not nodes.is_running("rotor"))
    assert nodes.ended == ["rotor"]
    assert nodes.end_of("rotor").startswith("ended with exit code 2: sunset node: ")
    assert "rotor" in nodes.lines[-1]
    assert nodes.pid("rotor") is None


def test_whoever_stops_or_kills_a_node_is_noticed(nodes: Nodes) -> None:
    nodes.start("camera")
    pid = nodes.pid("camera")
    assert pid is not None
    assert nodes.end_of("camera") == ""
    os.kill(pid, signal.SIGSTOP)
    assert nodes.polled_until(lambda: nodes.is_stopped("camera"))
    nodes.kill("camera")
    assert nodes.polled_until(lambda: not nodes.is_running("camera"))
    assert nodes.end_of("camera") == "ended by signal 9 (SIGKILL)"
    nodes.start("camera")
    assert nodes.polled_until(lambda: not nodes.is_stopped("camera"))
    assert nodes.end_of("camera") == ""


def test_closing_ends_even_a_node_that_is_stopped(nodes: Nodes) -> None:
    nodes.start("camera")
    pid = nodes.pid("camera")
    assert pid is not None
    os.kill(pid, signal.SIGSTOP)
    nodes.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
