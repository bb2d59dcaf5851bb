"""Processes of the operating system that end in every way that can be caught, and in one that cannot."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from sunset_ros.rmw.dds import CycloneDDS

if TYPE_CHECKING:
    from .conftest import Live

PROGRAM = """
import sys
import sunset_ros as ros

ros.init(args=[])
node = ros.create_node("guest", enable_rosout=False)
node.create_timer(0.01, lambda: print("up", flush=True))
{ending}
"""

SPIN = "ros.spin(node)\nprint('over', ros.ok())"
RAISE = "input()\nnode.create_timer(0.0, lambda: 1 / 0)\nros.spin(node)"
EXIT = "input()\nnode.create_timer(0.0, lambda: sys.exit(3))\nros.spin(node)"
FALL_OFF_THE_END = "ros.spin_once(node); input()"
SLEEP = "import time; print('up', flush=True); time.sleep(60)"


LONG_LEASE = (
    "<CycloneDDS><Domain><Discovery><LeaseDuration>600s</LeaseDuration></Discovery></Domain></CycloneDDS>"
)
"""With it, who does not say goodbye is missed after ten minutes."""
LIMIT_NS = 60 * 10**9


def is_alone(process: CycloneDDS) -> bool:
    return process.nodes() == [] and process.endpoints() == []


@contextmanager
def guest(live: "Live", ending: str, **variables: str) -> Iterator[subprocess.Popen[str]]:
    """Run a program that has a node, until the context is left."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(live.domain_id), **variables}
    program = PROGRAM.format(ending=ending)
    with subprocess.Popen(
        [sys.executable, "-c", program],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("ending", "number", "code", "said"),
    [
        (SPIN, signal.SIGINT, 0, "over False"),
        (SPIN, signal.SIGTERM, 0, "over False"),
        (RAISE, None, 1, "ZeroDivisionError"),
        (EXIT, None, 3, ""),
        (FALL_OFF_THE_END, None, 0, ""),
    ],
)
def test_a_process_leaves_the_graph_at_once(
    live: "Live", ending: str, number: signal.Signals | None, code: int, said: str
) -> None:
    process = live.process()
    with guest(live, ending, CYCLONEDDS_URI=LONG_LEASE) as program:
        assert process.wait_for(lambda: ("guest", "/") in process.nodes(), LIMIT_NS)
        if number is not None:
            assert program.stdout is not None
            program.stdout.readline()
            program.send_signal(number)
        else:
            assert program.stdin is not None
            program.stdin.write("go on\n")
            program.stdin.flush()
        assert process.wait_for(lambda: is_alone(process), LIMIT_NS)
        out, error = program.communicate(timeout=60)
    assert program.returncode == code
    assert said in out + error


def test_a_program_that_does_not_spin_leaves_too_and_a_second_signal_ends_it(live: "Live") -> None:
    process = live.process()
    with guest(live, SLEEP, CYCLONEDDS_URI=LONG_LEASE) as program:
        assert process.wait_for(lambda: ("guest", "/") in process.nodes(), LIMIT_NS)
        assert program.stdout is not None
        program.stdout.readline()
        program.send_signal(signal.SIGTERM)
        assert process.wait_for(lambda: is_alone(process), LIMIT_NS)
        assert program.poll() is None
        program.send_signal(signal.SIGTERM)
        assert program.wait(timeout=60) == -signal.SIGTERM


@pytest.mark.thorough
def test_a_killed_process_is_missed_when_its_lease_ends(live: "Live") -> None:
    process = live.process()
    with guest(live, SPIN) as program:
        assert process.wait_for(lambda: ("guest", "/") in process.nodes(), LIMIT_NS)
        program.kill()
        assert process.wait_for(lambda: is_alone(process), LIMIT_NS)


def test_only_loopback_is_joined_for_discovery(live: "Live") -> None:
    def groups() -> set[str]:
        devices: set[str] = set()
        device = ""
        for line in Path("/proc/net/igmp").read_text().splitlines()[1:]:
            if not line.startswith("\t"):
                device = line.split()[1]
            elif line.split()[0] == "0100FFEF":  # 239.255.0.1
                devices.add(device)
        return devices

    before = groups()
    live.process()
    assert groups() - before <= {"lo"}
    assert "lo" in groups()
