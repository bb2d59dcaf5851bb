"""What the environment may say, and what each bad value is answered with."""

import re
import socket
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from sunset_ros.errors import MiddlewareError
from sunset_ros.rmw.dds import CycloneDDS
from sunset_ros.rmw.dds._config import read_configuration

if TYPE_CHECKING:
    from .conftest import Live

LO = "<CycloneDDS><Domain><General><Interfaces><NetworkInterface {}/></Interfaces></General></Domain></CycloneDDS>"


@pytest.mark.parametrize(
    ("environment", "domain_id"),
    [({}, 0), ({"ROS_DOMAIN_ID": ""}, 0), ({"ROS_DOMAIN_ID": "232"}, 232), ({"ROS_DOMAIN_ID": " 7 "}, 7)],
)
def test_the_domain_comes_from_the_environment(environment: Mapping[str, str], domain_id: int) -> None:
    assert read_configuration(environment).domain_id == domain_id


def test_a_domain_that_is_given_wins() -> None:
    assert read_configuration({"ROS_DOMAIN_ID": "nonsense"}, domain_id=3).domain_id == 3


@pytest.mark.parametrize("text", ["233", "-1", "1.5", "one", "1000000000000", "٣"])
def test_a_bad_domain_is_refused(text: str) -> None:
    with pytest.raises(MiddlewareError, match=rf"^ROS_DOMAIN_ID must be .* from 0 to 232, got '{text}'\.$"):
        read_configuration({"ROS_DOMAIN_ID": text})


@pytest.mark.parametrize("domain_id", [233, -1, True])
def test_a_bad_domain_that_is_given_is_refused(domain_id: int) -> None:
    with pytest.raises(MiddlewareError, match=r"^The domain id must be a whole number from 0 to 232, got"):
        read_configuration({}, domain_id=domain_id)


def test_nothing_leaves_this_computer_unless_the_network_is_asked_for() -> None:
    for environment in ({}, {"ROS_LOCALHOST_ONLY": "0"}, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}):
        assert '<NetworkInterface address="127.0.0.1"' in read_configuration(environment).cyclonedds
    assert "NetworkInterface" not in read_configuration({}, network=True).cyclonedds


@pytest.mark.parametrize("network", [False, True])
def test_processes_here_are_looked_for_by_address_since_names_may_have_none(*, network: bool) -> None:
    peers = re.findall('<Peer address="([^":]*)', read_configuration({}, network=network).cyclonedds)
    assert set(peers) == {"127.0.0.1"}


@pytest.mark.parametrize(
    "environment",
    [
        {"ROS_LOCALHOST_ONLY": "1"},
        {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"},
        {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"},
        {"ROS_LOCALHOST_ONLY": "1", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"},
    ],
)
def test_an_environment_that_stays_here_contradicts_the_network(environment: Mapping[str, str]) -> None:
    with pytest.raises(MiddlewareError, match="keeps this process from the network that was asked for"):
        read_configuration(environment, network=True)
    read_configuration(environment)


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("ROS_LOCALHOST_ONLY", "yes", "0 or 1"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "localhost", "one of SYSTEM_DEFAULT, SUBNET, LOCALHOST, OFF"),
    ],
)
def test_other_values_are_refused(name: str, value: str, expected: str) -> None:
    with pytest.raises(MiddlewareError, match=rf"^{name} must be {expected}, got '{value}'\.$"):
        read_configuration({name: value})


def test_discovery_that_is_off_keeps_even_processes_of_this_computer_out(live: "Live") -> None:
    first = live.process(environment={"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"})
    first.create_node("hermit", "/")
    with pytest.raises(MiddlewareError, match=r"is in domain \d+ already, with other settings"):
        live.process()
    seen = subprocess.run(
        [sys.executable, "-c", LOOK, str(live.domain_id)], check=True, capture_output=True, text=True
    )
    assert seen.stdout == "[]\n"


LOOK = """
import sys
from sunset_ros.rmw.dds import CycloneDDS
with CycloneDDS(domain_id=int(sys.argv[1]), environment={}) as process:
    process.wait_for(lambda: bool(process.nodes()), int(float((sys.argv[2:] or ["0.5"])[0]) * 1e9))
    print(process.nodes())
"""


@pytest.mark.parametrize(
    "settings",
    [
        LO.format('name="lo" multicast="true"'),  # a node that multicasts
        LO.format('address="127.0.0.1"')  # a node with ROS_LOCALHOST_ONLY=1
        + ",<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast></General></Domain></CycloneDDS>",
    ],
)
def test_processes_with_the_settings_of_ros_nodes_are_found(live: "Live", settings: str) -> None:
    live.process(environment={"CYCLONEDDS_URI": settings}).create_node("found", "/")
    seen = subprocess.run(
        [sys.executable, "-c", LOOK, str(live.domain_id), "60"], check=True, capture_output=True, text=True
    )
    assert seen.stdout == "[('found', '/')]\n"


@pytest.mark.parametrize("interface", ['name="lo"', 'address="127.0.0.1" multicast="true"', "name = 'lo'"])
def test_an_interface_that_is_named_is_not_named_twice(live: "Live", interface: str) -> None:
    configuration = read_configuration({"CYCLONEDDS_URI": LO.format(interface)})
    assert configuration.cyclonedds.count("<NetworkInterface ") == 1
    live.process(environment={"CYCLONEDDS_URI": LO.format(interface)}).create_node("node", "/")


def test_settings_may_come_from_files(tmp_path: Path) -> None:
    file = tmp_path / "cyclone.xml"
    file.write_text("<!-- " + LO.format('name="eth0"') + " -->\n" + LO.format('name="lo"'))
    for uri in (f"file://{file}", str(file), f"<CycloneDDS></CycloneDDS>,file://{file}"):
        configuration = read_configuration({"CYCLONEDDS_URI": uri})
        assert configuration.cyclonedds.endswith(f",{uri}")
        assert "NetworkInterface" not in configuration.cyclonedds


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MiddlewareError, match=r"names the file .*missing\.xml, which cannot be read: .*\.$"):
        read_configuration({"CYCLONEDDS_URI": f"file://{tmp_path}/missing.xml"})


@pytest.mark.parametrize(
    ("interface", "named"),
    [
        (LO.format('name="eth0"'), "eth0"),
        (LO.format('name="lo"/><NetworkInterface address="192.168.0.1"'), "192.168.0.1"),
        (LO.format('NAME="eth0"').lower(), "eth0"),
        (LO.format('autodetermine="true"'), "chosen automatically"),
        ("<General><NetworkInterfaceAddress>eth1</NetworkInterfaceAddress></General>", "eth1"),
    ],
)
def test_an_interface_beyond_loopback_needs_the_network_to_be_asked_for(interface: str, named: str) -> None:
    with pytest.raises(
        MiddlewareError, match=f"selects the network interface '{named}', but this process stays"
    ):
        read_configuration({"CYCLONEDDS_URI": interface})
    read_configuration({"CYCLONEDDS_URI": interface}, network=True)


def test_settings_that_cyclone_refuses_are_one_sentence(
    live: "Live", capfd: pytest.CaptureFixture[str]
) -> None:
    nonsense = "<CycloneDDS><Domain><General><Nonsense/></General></Domain></CycloneDDS>"
    with pytest.raises(
        MiddlewareError, match=r"^DDS could not set up domain \d+: either CYCLONEDDS_URI is wrong"
    ):
        CycloneDDS(domain_id=live.domain_id, environment={"CYCLONEDDS_URI": nonsense})
    assert "Nonsense: unknown element" in capfd.readouterr().err
    live.process()  # it can be set up afterwards


@pytest.mark.parametrize(
    ("distro", "environment", "size", "adapts", "hashes"),
    [
        (None, {}, 24, True, True),
        (None, {"ROS_DISTRO": "humble"}, 24, True, False),
        (None, {"ROS_DISTRO": "jazzy"}, 16, True, True),
        (None, {"ROS_DISTRO": "nonsense"}, 24, True, True),
        ("jazzy", {"ROS_DISTRO": "humble"}, 16, False, True),
        ("humble", {}, 24, False, False),
    ],
)
def test_the_distribution_decides_what_is_announced(
    distro: str | None, environment: Mapping[str, str], size: int, adapts: bool, hashes: bool
) -> None:
    configuration = read_configuration(environment, distro=distro)
    assert (configuration.gid_size, configuration.adapts) == (size, adapts)
    assert configuration.announces_hashes is hashes


def test_the_newer_form_of_announcements_is_taken_when_others_have_it(live: "Live") -> None:
    process = live.process()
    process.create_node("ours", "/")
    assert process.link.gid_size == 24
    live.process(distro="humble").create_node("older", "/")
    assert process.wait_for(lambda: len(process.nodes()) == 2, 10**10)
    assert process.link.gid_size == 24
    live.process(distro="jazzy").create_node("newer", "/")
    assert process.wait_for(lambda: process.link.gid_size == 16, 10**10)


# As Cyclone DDS of ROS 2 up to Humble is set up with ROS_LOCALHOST_ONLY=1 where the loopback has no multicast
OLDER = """
import sys, time
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsParticipant
from cyclonedds.domain import Domain, DomainParticipant
number = int(sys.argv[1])
domain = Domain(number, "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast><Interfaces>"
    '<NetworkInterface address="127.0.0.1"/></Interfaces></General><Discovery><ParticipantIndex>auto</ParticipantIndex>'
    "<MaxAutoParticipantIndex>9</MaxAutoParticipantIndex></Discovery></Domain></CycloneDDS>")
participant = DomainParticipant(number)
reader = BuiltinDataReader(participant, BuiltinTopicDcpsParticipant)
end = time.monotonic() + 60
while time.monotonic() < end and len(reader.read(9)) < 2: time.sleep(0.02)
print(len(reader.read(9)))
"""


def test_the_indices_of_older_nodes_are_left_to_them_and_looked_at(live: "Live") -> None:
    live.process().create_node("ours", "/")
    for index in range(10):
        for port in range(2):
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
                probe.bind(("", 7410 + 250 * live.domain_id + 2 * index + port))
    seen = subprocess.run(
        [sys.executable, "-c", OLDER, str(live.domain_id)], check=True, capture_output=True, text=True
    )
    assert seen.stdout == "2\n"  # itself and ours


def test_an_unknown_distribution_is_refused() -> None:
    with pytest.raises(
        MiddlewareError, match=r"^The ROS 2 distribution must be one of foxy, .*, got 'noetic'"
    ):
        read_configuration({}, distro="noetic")
