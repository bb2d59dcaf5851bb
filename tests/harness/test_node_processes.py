"""Nodes as processes that a server forks."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest
from tests.live.systems import exists

from sunset.harness.node_process import NodeProcesses, NodeSpec, node_server
from sunset.system import MANAGING_SYSTEM
from sunset_ros.rmw.dds.domains import free_domain_id

PATIENCE_S = 60.0


class Nodes(NodeProcesses):
    """A camera, one whose program there is not, and one whose program is the file `program`.

    `lines` has what they print, `ended` those that ended.
    """

    def __init__(self, domain_id: int, program: Path) -> None:
        self.lines: list[str] = []
        self.ended: list[str] = []
        self.program = program
        specs = {
            "camera": NodeSpec(node="camera"),
            "rotor": NodeSpec(node=MANAGING_SYSTEM, manager="rotor.py:Mine"),
            "manager": NodeSpec(node=MANAGING_SYSTEM, manager=f"{program}:Mine"),
        }
        super().__init__(specs, {"ROS_DOMAIN_ID": str(domain_id)}, lambda _, line: self.note(line))
        self.on_exit = self.ended.append

    def note(self, line: str) -> None:
        """Note a line that a node printed."""
        self.lines.append(line)

    def polled_until(self, predicate: Callable[[], bool]) -> bool:
        """Poll until a predicate holds; return whether it does."""
        end = time.monotonic() + PATIENCE_S
        while not predicate() and time.monotonic() < end:
            self.poll()
            threading.Event().wait(0.01)
        return predicate()


@pytest.fixture
def nodes(tmp_path: Path) -> Iterator[Nodes]:
    with free_domain_id() as domain_id, closing(Nodes(domain_id, tmp_path / "mine.py")) as made:
        yield made


def test_a_node_that_cannot_start_says_why(nodes: Nodes) -> None:
    nodes.start("rotor")
    assert nodes.polled_until(lambda: not nodes.is_running("rotor"))
    assert nodes.ended == ["rotor"]
    assert nodes.end_of("rotor").startswith("ended with exit code 2: sunset: ")
    assert "rotor" in nodes.lines[-1]
    assert nodes.pid("rotor") is None


def test_whoever_kills_a_node_is_noticed(nodes: Nodes) -> None:
    nodes.start("camera")
    assert nodes.end_of("camera") == ""
    nodes.kill("camera")
    assert nodes.polled_until(lambda: not nodes.is_running("camera"))
    assert nodes.end_of("camera") == "ended by signal 9 (SIGKILL)"
    nodes.start("camera")
    assert nodes.end_of("camera") == ""


def test_what_a_node_printed_is_no_cause_of_an_end_in_order(nodes: Nodes) -> None:
    nodes.program.write_text("import os; print('All is well.', flush=True); os._exit(0)")
    nodes.start("manager")
    assert nodes.polled_until(lambda: nodes.ended == ["manager"])
    assert nodes.end_of("manager") == "ended in order"


def test_closing_ends_even_a_node_that_is_stopped(nodes: Nodes) -> None:
    nodes.start("camera")
    pid = nodes.pid("camera")
    assert pid is not None
    os.kill(pid, signal.SIGSTOP)
    nodes.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.thorough
def test_a_signal_without_a_name_can_end_a_node(nodes: Nodes) -> None:
    nodes.start("camera")
    pid = nodes.pid("camera")
    assert pid is not None
    os.kill(pid, 40)
    assert nodes.polled_until(lambda: not nodes.is_running("camera"))
    assert nodes.end_of("camera").startswith("ended by signal 40 (")


STARTS_ANOTHER = """
import os, subprocess, threading
print(subprocess.Popen(["sleep", "600"]{options}).pid, flush=True)
{then}
"""


@pytest.mark.thorough
@pytest.mark.parametrize("then", ["os._exit(0)", "threading.Event().wait()"])
def test_what_a_node_has_started_ends_with_it(nodes: Nodes, then: str) -> None:
    nodes.program.write_text(STARTS_ANOTHER.format(options="", then=then))
    nodes.start("manager")
    assert nodes.polled_until(lambda: bool(nodes.lines))
    child = int(nodes.lines[0])
    assert nodes.polled_until(lambda: "wait" in then or nodes.ended == ["manager"])
    nodes.close()
    assert nodes.polled_until(lambda: not exists(child))


@pytest.mark.thorough
def test_a_process_that_has_left_costs_time_once(nodes: Nodes) -> None:
    nodes.program.write_text(STARTS_ANOTHER.format(options=", start_new_session=True", then="os._exit(3)"))
    nodes.start("manager")
    assert nodes.polled_until(lambda: nodes.ended == ["manager"])
    try:
        assert nodes.end_of("manager").startswith("ended with exit code 3")
        assert nodes.has_failed("manager")
        before = time.monotonic()
        nodes.end_of("manager")
        assert time.monotonic() - before < 1.0  # which it took the first time
    finally:
        os.kill(int(nodes.lines[0]), signal.SIGKILL)


def test_nodes_are_started_and_seen_to_end_after_their_server_was_killed(
    nodes: Nodes, tmp_path: Path
) -> None:
    done = tmp_path / "done"
    nodes.program.write_text(
        f"import os, threading\nwhile not os.path.exists({str(done)!r}): threading.Event().wait(0.01)\nos._exit(5)"
    )
    nodes.start("manager")
    assert nodes.pid("manager")
    os.kill(node_server().pid, signal.SIGKILL)
    done.touch()
    assert nodes.polled_until(lambda: nodes.ended == ["manager"])
    assert nodes.end_of("manager") == "ended with exit code 5"
    nodes.start("manager")
    assert nodes.polled_until(lambda: nodes.ended == ["manager", "manager"])
    assert nodes.end_of("manager") == "ended with exit code 5"


@pytest.mark.thorough
def test_a_node_goes_on_when_nobody_takes_what_it_prints(
    nodes: Nodes, monkeypatch: pytest.MonkeyPatch
) -> None:
    def note(_: str) -> None:
        raise BrokenPipeError

    monkeypatch.setattr(nodes, "note", note)
    nodes.program.write_text("import os\nfor _ in range(9999): print('x' * 99)\nos._exit(0)")
    nodes.start("manager")
    assert nodes.polled_until(lambda: nodes.ended == ["manager"])
