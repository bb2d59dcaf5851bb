"""The same program and seed give the same history in any process."""

import os
import subprocess
import sys

import pytest

PROGRAM = """
import hashlib
from sunset_ros.interfaces import serialize
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.interfaces.std_srvs.srv import Trigger
from sunset_ros.rmw.core.port import QoSProfile
from sunset_ros.rmw.sim import Simulation, Tap

digest = hashlib.sha256()
class Recorder(Tap):
    def on_message(self, time_ns, topic, node, message):
        digest.update(f"{time_ns} {topic} {node} ".encode() + serialize(message))
    def on_request(self, time_ns, service, client, server, request, request_id):
        digest.update(f"{time_ns} {service} {client} {server} {tuple(request_id)}".encode())
    def on_response(self, time_ns, service, server, response, request_id):
        digest.update(f"{time_ns} {service} {server} {tuple(request_id)}".encode())

def build(sim, name, source, target):
    process = sim.create_process(name)
    node = process.create_node(name, "/ns")
    node.attach()
    process.run()
    qos = QoSProfile(depth=3)
    publisher = node.create_publisher(String, target, qos)
    client = node.create_client(Trigger, "/trigger", qos, lambda number, response: None, label="client")
    def relay(message):
        publisher.publish(String(data=message.data[-20:] + name))
        client.send_request(Trigger.Request())
    node.create_subscription(String, source, qos, relay, label="relay")
    node.create_timer(7_000_000, lambda: publisher.publish(String(data="tick")), label="tick")
    service = node.create_service(
        Trigger, "/trigger", qos,
        lambda request_id, request: service.send_response(request_id, Trigger.Response(message=name)), label="serve")
    sim.on_exit(process, lambda ended: build(sim, name, source, target))
    return process

sim = Simulation(seed=SEED, compute={"/ns/a": 0.002, "/ns/b": 0.003, "/ns/c": 0.004})
sim.add_tap(Recorder())
processes = [build(sim, name, source, target) for name, source, target in
             (("a", "/x", "/y"), ("b", "/y", "/z"), ("c", "/z", "/x"))]
sim.call_at(200_000_000, lambda: sim.kill(processes[1]))
sim.run_until(1_000_000_000)
print(digest.hexdigest(), [info.gid.hex() for info in sim.endpoints()][-1])
"""


def history(seed: int, hash_seed: str) -> str:
    program = PROGRAM.replace("SEED", str(seed))
    environment = {**os.environ, "PYTHONHASHSEED": hash_seed}
    command = [sys.executable, "-c", program]
    return subprocess.run(command, env=environment, check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("hash_seed", ["1", "12345", "random"])
def test_the_history_does_not_depend_on_the_process(hash_seed: str) -> None:
    assert history(7, hash_seed) == history(7, "0")


def test_the_history_depends_on_the_seed() -> None:
    assert history(7, "0") != history(8, "0")
