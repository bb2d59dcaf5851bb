"""A live system sends nothing beyond this computer, and two of them do not disturb each other."""

import socket
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

import pytest
from tests.live.systems import MANAGED, PATIENCE_S, children, eventually, flying, going_up

from sunset.recording import read_messages, read_timeline

pytestmark = [pytest.mark.xdist_group("live"), pytest.mark.thorough]

LOOPBACK, ANY = "127.0.0.1", "0.0.0.0"  # noqa: S104  what a process must not send from
MULTICAST = "239.255.0.1"


def address(number: str) -> str:
    """Return an address as the kernel's tables have it."""
    return socket.inet_ntoa(int(number, 16).to_bytes(4, "little"))


def sockets(pid: int) -> Iterator[tuple[str, str, int]]:
    """Yield protocol, local address and port of every socket of a process that speaks the Internet's protocols."""
    own = set()
    for file in Path(f"/proc/{pid}/fd").iterdir():
        try:
            own.add(str(file.readlink()))
        except FileNotFoundError:
            continue  # closed meanwhile
    for protocol in ("udp", "udp6", "udplite", "udplite6", "tcp", "tcp6", "raw", "raw6", "icmp", "icmp6"):
        table = Path(f"/proc/{pid}/net/{protocol}")
        for line in table.read_text(encoding="utf-8").splitlines()[1:] if table.exists() else ():
            words = line.split()
            if f"socket:[{words[9]}]" in own:
                local, port = words[1].split(":")
                yield protocol, local if len(local) > 8 else address(local), int(port, 16)


def memberships() -> set[tuple[str, str]]:
    """Return (device, multicast group) of everything on this computer that has joined one."""
    found = set()
    device = ""
    for line in Path("/proc/net/igmp").read_text(encoding="utf-8").splitlines()[1:]:
        words = line.split()
        if line[0].isdigit():
            device = words[1]
        else:
            found.add((device, address(words[0])))
    return found


def test_no_process_has_a_socket_that_reaches_beyond_loopback() -> None:
    before = memberships()
    with going_up("--scenario", "gpu_failure", "--manager", "baseline") as (up, tool):
        assert up.tells("The faults are injected")
        domain_id = tool.node.context.middleware.domain_id  # type: ignore[attr-defined]
        listening = range(7400 + 250 * domain_id, 7400 + 250 * domain_id + 76)
        for node, pid in {**up.pids, "launcher": up.process.pid}.items():
            found = list(sockets(pid))
            others = [one for one in found if one[:2] != ("udp", LOOPBACK)]
            assert len(others) < len(found), (node, found)
            assert {one[:2] for one in others} == {("udp", ANY)}, (node, found)
            assert all(port in listening for *_, port in others), (node, found)
        joined = memberships() - before
    assert joined <= {("lo", MULTICAST)}


def test_what_is_sent_from_loopback_stays_there() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.bind((LOOPBACK, 0))
        sender.setblocking(False)
        for beyond in ("198.51.100.1", "255.255.255.255"):
            with pytest.raises(OSError, match=r"argument|unreachable|denied"):
                sender.sendto(b"", (beyond, 9))


class Flight(NamedTuple):
    """A run that is over: its domain of DDS, and when it was seen in it first and last."""

    domain_id: int
    began: float
    ended: float


def fly(scenario: str, manager: str, out: Path) -> Flight:
    """Fly a short live run, and see in which domain its monitor is."""
    with flying(scenario, manager, 4.0, out, speed=0.5) as process:  # two systems at once
        monitor = children(process.pid)["monitor"]
        ports: set[int] = set()

        def listens() -> bool:
            ports.update(port for _, local, port in sockets(monitor) if local == ANY)
            return bool(ports)

        assert eventually(listens)
        began = time.monotonic()
        _, complaint = process.communicate(timeout=2 * PATIENCE_S)
        assert process.returncode == 0, complaint
        return Flight((min(ports) - 7400) // 250, began, time.monotonic())


def test_two_runs_side_by_side_know_nothing_of_each_other(tmp_path: Path) -> None:
    broken, whole = tmp_path / "broken", tmp_path / "whole"
    with ThreadPoolExecutor(2) as pool:
        flights = pool.map(fly, ("gpu_failure", "nofault"), ("baseline", "none"), (broken, whole))
        first, second = flights
    assert first.domain_id != second.domain_id
    assert max(first.began, second.began) < min(first.ended, second.ended)
    redeployed = {command.node for command in read_timeline(broken).commands}
    assert redeployed == {"/managed_subsystem/segmentation"}
    assert [one.fault for one in read_timeline(broken).injections] == ["gpu_failure"]
    assert (read_timeline(whole).commands, read_timeline(whole).injections) == ((), ())
    for record in (broken, whole):
        played = [one.message.header.stamp for one in read_messages(record, ["/gt_segmentation"])]  # type: ignore[attr-defined]
        assert len({(stamp.sec, stamp.nanosec) for stamp in played}) == len(played)
        assert 40 <= len(played) <= 50  # one flight's, of 1 s and 4 s at 10 Hz
        beats = read_messages(record, ["/diagnostics"])
        for node in MANAGED:
            times = [one.time_ns for one in beats if one.message.status[0].hardware_id == node]  # type: ignore[attr-defined]
            assert len(times) <= 1.1 * (times[-1] - times[0]) / 1e8 + 2  # one node's, at 10 Hz
