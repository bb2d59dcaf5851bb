"""A world of nodes has the same history in any process."""

import os
import subprocess
import sys

import pytest

PROGRAM = """
import hashlib

from sunset_ros.interfaces import serialize
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.rmw.sim import Tap
from conformance.harness import SimHarness

digest = hashlib.sha256()


class Recorder(Tap):
    def on_message(self, time_ns, topic, node, message):
        digest.update(f"{time_ns} {topic} {node} ".encode() + serialize(message))

    def on_response(self, time_ns, service, server, response, request_id):
        digest.update(f"{time_ns} {service} {server} ".encode() + serialize(response))


harness = SimHarness()
harness.simulation.add_tap(Recorder())
for node in ("Talker", "Echo", "Server", "Parametrised", "Managed", "Clocked"):
    harness.start(node, "-p", "activate:=error", "-p", "flag:=true")
harness.call(harness.node.create_client(Trigger, "/server/ask"), Trigger.Request())
harness.pause(2.0)
harness.kill("Server")
graph = harness.node.get_topic_names_and_types() + harness.node.get_service_names_and_types()
print(digest.hexdigest(), hashlib.sha256(repr(graph).encode()).hexdigest(), harness.node.get_node_names())
"""


def history(hash_seed: str) -> str:
    environment = {**os.environ, "PYTHONHASHSEED": hash_seed, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", PROGRAM]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout


@pytest.mark.thorough
@pytest.mark.parametrize("hash_seed", ["1", "424242"])
def test_the_history_does_not_depend_on_the_process(hash_seed: str) -> None:
    assert history(hash_seed) == history("0")
