"""Random and malformed samples, thrown at every topic and service of a process: it lives, and says so seldom."""

import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from tests.conformance.nodes import Echo, Managed, Parametrised, Server, Talker
from tests.rmw.peer import LATCHED, Peer

from sunset.interfaces import FieldType, Message, field_types, get_message, serialize
from sunset.interfaces.rcl_interfaces.srv import GetParameters
from sunset.interfaces.std_srvs.srv import SetBool
from sunset.seeding import generator

if TYPE_CHECKING:
    from .conftest import Live

ROUNDS = int(os.environ.get("SUNSET_HOSTILE_ROUNDS", "100"))
"""Samples for each topic and service, of each kind."""

NODES = (Echo, Managed, Parametrised, Server, Talker)
WORDS = ("", "flag", "image.shift", "use_sim_time", "configure", "shutdown", "\x00", "ä" * 50, "x" * 1000)


def random_value(kind: FieldType, random: np.random.Generator) -> Any:
    """Return any value that a field may have."""
    if kind.is_array:
        size = kind.size if kind.size is not None else int(random.integers(0, 4))
        values = [random_value(FieldType(kind.base, kind.string_bound), random) for _ in range(size)]
        return np.array(values, kind.base) if kind.is_numpy else values
    if kind.is_message:
        return random_message(get_message(kind.base), random)
    if kind.base == "byte":
        return random.bytes(1)
    choices = edges(kind)
    return choices[random.integers(len(choices))]


def edges(kind: FieldType) -> list[Any]:
    """Return values of a primitive type that tend to be forgotten."""
    if kind.base == "string":
        return [word[: kind.string_bound or None] for word in WORDS]
    if kind.base == "bool":
        return [False, True]
    if kind.base.startswith("float"):
        return [0.0, -1.5, float(np.finfo(kind.base).max), np.nan, np.inf]
    limits = np.iinfo(kind.base)
    return [0, 1, 2, 3, 4, 5, int(limits.min), int(limits.max)]


def random_message(kind: type[Message], random: np.random.Generator) -> Message:
    """Return a message with any values that its definition allows."""
    return kind(**{name: random_value(field, random) for name, field in field_types(kind).items()})


def samples(kind: type[Message], random: np.random.Generator, *, service: bool) -> Iterator[bytes]:
    """Yield samples: allowed ones with any values, such ones cut, spoilt or grown, and noise."""
    for _ in range(ROUNDS):
        body = serialize(random_message(kind, random))
        head = random.bytes(16) if service else b""
        whole = body[:4] + head + body[4:]
        yield whole
        yield padded(whole[: 5 + int(random.integers(len(whole)))])
        spoilt = bytearray(whole)
        for position in random.integers(4, len(whole), 3):
            spoilt[position] = int(random.integers(256))
        yield bytes(spoilt)
        yield whole + random.bytes(4 * int(random.integers(1, 10)))
        yield b"\x00\x01\x00\x00" + padded(random.bytes(int(random.integers(1, 200))))
        yield random.bytes(2) + whole[2:]


def padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)


def targets(peer: Peer) -> dict[str, tuple[str, type[Message]]]:
    """Return the DDS type and the message of every topic and service on which somebody listens."""
    found: dict[str, tuple[str, type[Message]]] = {}
    for reader in peer.every_reader():
        match = re.fullmatch(r"(\w+)::(\w+)::dds_::(\w+)_", reader.type_name)
        if match and not reader.topic_name.startswith("ros_discovery") and "/leave" not in reader.topic_name:
            found[reader.topic_name] = (reader.type_name, get_message("/".join(match.groups())))
    return found


def test_nothing_that_comes_from_the_network_ends_a_process(
    live: "Live", capfd: pytest.CaptureFixture[str]
) -> None:
    executor = live.executor(*NODES, arguments=["--ros-args", "--enable-stdout-logs", "--log-level", "warn"])
    (process,) = live.processes
    peer = live.peer()
    random = generator(1, "hostile")
    aims = targets(peer)
    assert len(aims) > 35
    memory: list[int] = []
    for topic, (type_name, kind) in aims.items():
        writer = peer.writer(topic, type_name)
        assert peer.wait(lambda writer=writer: bool(writer.get_matched_subscriptions()))  # type: ignore[misc]
        for sample in samples(kind, random, service=topic.startswith("r")):
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
