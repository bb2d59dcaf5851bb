"""Random and malformed samples, thrown at every topic and service of a process: it lives, and says so seldom."""

import os
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from conformance.nodes import Echo, Managed, Parametrised, Server, Talker
from rmw.hostile import KINDS, padded, samples, targets
from rmw.peer import LATCHED
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters
from sunset_ros.interfaces.std_srvs.srv import SetBool
from sunset_ros.seeding import generator

if TYPE_CHECKING:
    from .conftest import Live

pytestmark = pytest.mark.thorough

ROUNDS = int(os.environ.get("SUNSET_HOSTILE_ROUNDS", "100"))
"""Samples for each topic and service, of each kind."""

NODES = (Echo, Managed, Parametrised, Server, Talker)


def test_nothing_that_comes_from_the_network_ends_a_process(
    live: "Live", capfd: pytest.CaptureFixture[str]
) -> None:
    executor = live.executor(*NODES, arguments=["--ros-args", "--enable-stdout-logs", "--log-level", "warn"])
    (process,) = live.processes
    peer = live.peer()
    random = generator(1, "hostile")
    aims = {topic: what for topic, what in targets(peer).items() if "/leave" not in topic}
    assert len(aims) > 35
    memory: list[int] = []
    for topic, (type_name, kind) in aims.items():
        writer = peer.writer(topic, type_name)
        assert peer.wait(lambda writer=writer: bool(writer.get_matched_subscriptions()))  # type: ignore[misc]
        thrown = samples(kind, random, service=topic.startswith(("rq/", "rr/")))
        for sample in islice(thrown, ROUNDS * len(KINDS)):
            if peer.try_to_send(writer, sample):
                executor.spin_once(timeout_sec=0)
        assert live.spin(executor, lambda: not process.spin_once(0))
        memory.append(resident_bytes())
    discovery = peer.writer(
        "ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_", LATCHED
    )
    for _ in range(6 * ROUNDS):
        peer.try_to_send(discovery, b"\x00\x01\x00\x00" + padded(random.bytes(int(random.integers(1, 99)))))
    live.spin(executor, lambda: False, 0.2)
    assert all_answer(live, executor)
    assert memory[-1] - memory[5] < 20_000_000
    complaints = [line for line in capfd.readouterr().err.splitlines() if "dropped" in line]
    places = {line.split("]: ")[1].split(":")[0] for line in complaints}
    assert len(places) > 30
    assert len(complaints) <= 3 * len(places)
    assert sum(process.problems.values()) > len(aims) * ROUNDS


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def all_answer(live: "Live", executor: Any) -> bool:
    """Ask every node for a parameter, and the server to do its work."""
    tester, asking = live.node("tester")
    futures = []
    for node in ("echo", "managed", "parametrised", "server", "talker"):
        client = tester.create_client(GetParameters, f"/{node}/get_parameters")
        assert client.wait_for_service(10.0)
        futures.append(client.call_async(GetParameters.Request(names=["use_sim_time"])))
    client = tester.create_client(SetBool, "/server/set")
    assert client.wait_for_service(10.0)
    futures.append(client.call_async(SetBool.Request(data=True)))

    def done() -> bool:
        asking.spin_once(timeout_sec=0)
        return all(future.done() for future in futures)

    return live.spin(executor, done)
