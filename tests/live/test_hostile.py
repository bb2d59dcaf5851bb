"""Absurd samples, malformed ones and noise, thrown at every topic and service of a running system.

With SUNSET_HOSTILE_SAMPLES=10000 in the environment each of them gets so many; `pytest -s` shows the figures.
"""

import os
import re
import signal
import time
from collections import Counter
from pathlib import Path

import pytest
from tests.live.systems import MANAGED, Tool, Up, exists, going_up

from rmw.hostile import padded, samples, targets
from rmw.peer import LATCHED, Peer
from sunset.errors import InterfaceError
from sunset.system_interfaces.srv import Redeploy
from sunset_ros.interfaces import Message, deserialize
from sunset_ros.interfaces.lifecycle_msgs.srv import ChangeState
from sunset_ros.interfaces.rcl_interfaces.srv import GetParameters
from sunset_ros.rmw.dds import CycloneDDS
from sunset_ros.seeding import generator

pytestmark = [pytest.mark.xdist_group("processes"), pytest.mark.thorough]

SAMPLES = int(os.environ.get("SUNSET_HOSTILE_SAMPLES", "150"))
"""For each topic and service, the half of them before memory is measured first."""
GROWTH_MB = 10.0 if SAMPLES >= 1000 else 100.0
"""DDS keeps memory for some hundreds of frames to use it again, so that the first ones need more."""
PLACES = 25
"""Topics, services and callbacks of a node that may be complained of, each at most once in `EVERY_S`."""
EVERY_S = 10.0

NODES = (
    *(f"/managed_subsystem/{node}" for node in MANAGED),
    *("/bag_player", "/monitor", "/evaluator", "/scenario_executor", "/launcher", "/operator"),
)


def is_forbidden(message: Message) -> bool:
    """Return whether a request ends a process rightly."""
    if isinstance(message, ChangeState.Request):
        label, number = message.transition.label, message.transition.id
        return label == "shutdown" if label else number in {5, 6, 7}
    return isinstance(message, Redeploy.Request) and message.node.rsplit("/", 1)[-1] in MANAGED


class Aim:
    """A topic, or one of the two of a service, on which somebody listens."""

    def __init__(self, peer: Peer, topic: str, type_name: str, kind: type[Message]) -> None:
        self.kind = kind
        self._service = topic.startswith(("rq/", "rr/"))
        self._samples = samples(kind, generator(1, topic), service=self._service)
        self._writer = peer.writer(topic, type_name)
        assert peer.wait(lambda: bool(self._writer.get_matched_subscriptions()))

    def throw(self) -> bool:
        """Send the next sample, if DDS lets it; return whether it does."""
        sample = next(self._samples)
        while self._is_forbidden(sample):
            sample = next(self._samples)
        return Peer.try_to_send(self._writer, sample)

    def throw_giant(self) -> None:
        """Send more than anybody expects."""
        Peer.try_to_send(self._writer, b"\x00\x01\x00\x00" + bytes(1_000_000))

    def _is_forbidden(self, sample: bytes) -> bool:
        payload = sample[:4] + sample[20:] if self._service else sample
        try:
            return is_forbidden(deserialize(payload, self.kind))
        except InterfaceError:
            return False


class Storm:
    """Throws samples at everything in a domain."""

    def __init__(self, tool: Tool) -> None:
        middleware = tool.node.context.middleware
        assert isinstance(middleware, CycloneDDS)
        self._tool = tool
        self._peer = Peer(middleware.domain_id)
        assert tool.spin(lambda: len(tool.node.get_node_names()) > len(NODES))
        self._peer.wait(lambda: len(targets(self._peer)) > 100)
        self.aims = [
            Aim(self._peer, topic, *what)
            for topic, what in targets(self._peer).items()
            if "/_tool/" not in topic
        ]
        self._discovery = self._peer.writer(
            "ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_", LATCHED
        )
        self._random = generator(1, "discovery")
        self._clients = [tool.node.create_client(GetParameters, f"{node}/get_parameters") for node in NODES]
        self.sent = self.refused = 0
        for aim in self.aims:
            aim.throw_giant()

    def blow(self, count: int) -> None:
        """Throw so many samples at each; all nodes answer every now and then."""
        for number in range(count):
            for aim in self.aims:
                sent = aim.throw()
                self.sent += sent
                self.refused += not sent
            noise = self._random.bytes(int(self._random.integers(1, 99)))
            self._peer.try_to_send(self._discovery, b"\x00\x01\x00\x00" + padded(noise))
            if number % 5 == 0:
                self.wait_for_answers()

    def wait_for_answers(self) -> None:
        """Wait until every node has answered a question."""
        assert self._tool.spin(lambda: all(client.service_is_ready() for client in self._clients))
        asked = {
            client.service_name: client.call_async(GetParameters.Request(names=["use_sim_time"]))
            for client in self._clients
        }
        answered = self._tool.spin(lambda: all(future.done() for future in asked.values()))
        assert answered, [name for name, future in asked.items() if not future.done()]

    def end(self) -> None:
        """Leave."""
        self._peer.leave()


def resident_mb(pid: int) -> float:
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def complaints(up: Up) -> Counter[str]:
    """Count what the nodes have logged."""
    logged = (re.match(r"\[(\w+)\] \[(WARN|ERROR)\]", line) for line in tuple(up.lines))
    return Counter(match[1] for match in logged if match)


def test_nothing_that_comes_from_the_network_ends_a_node_or_stays_in_it() -> None:
    with going_up("--scenario", "image_degradation") as (up, tool):
        assert up.tells("The faults are injected")
        nodes = up.pids
        processes = {**nodes, "launcher": up.process.pid}
        storm = Storm(tool)
        memory = []
        began = time.monotonic()
        for _ in range(2):
            storm.blow(SAMPLES // 2)
            memory.append({node: resident_mb(pid) for node, pid in processes.items()})
        seconds = time.monotonic() - began
        logged = complaints(up)
        figures = [
            f"{len(storm.aims)} topics and services, {SAMPLES} samples each, in {seconds:.0f} s",
            f"{storm.sent} were sent; {storm.refused} the sender's own DDS refused",
            *(
                f"  {node:18}{memory[0][node]:6.1f} MB after the first half, {memory[1][node]:6.1f} MB after the "
                f"second, {logged[node]:4} lines logged"
                for node in processes
            ),
        ]
        print("", *figures, sep="\n")  # noqa: T201  for pytest -s
        assert len(storm.aims) > 100
        assert storm.sent > 0.8 * SAMPLES * len(storm.aims)
        assert up.process.poll() is None
        assert up.pids == nodes
        assert all(exists(pid) for pid in nodes.values())
        for node in processes:
            assert memory[1][node] - memory[0][node] < GROWTH_MB, figures
            assert logged[node] <= PLACES * (1 + seconds / EVERY_S), figures
        for node in nodes:
            assert logged[node] > 0, figures
        assert up.end(signal.SIGTERM) == 0
        storm.end()  # only now: each of its writers would wait for a second for somebody to confirm its last sample
