"""Settings of DDS from the environment and the caller: domain, reach, distribution.

The environment variables are from ROS 2 (https://docs.ros.org/en/jazzy/Concepts/Intermediate/About-Domain-ID.html and
Improved-Dynamic-Discovery) and Cyclone DDS. Unlike there, no data leaves this computer unless the caller asks for the
network.
"""

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from uuid import uuid4

from sunset_ros.errors import MiddlewareError

LAST_DOMAIN_ID = 232
"""The largest domain id whose ports exist: participant 0 of domain n listens on port 7410 + 250 n."""

DISTROS: Mapping[str, int] = {
    "foxy": 24,
    "galactic": 24,
    "humble": 24,
    "iron": 16,
    "jazzy": 16,
    "kilted": 16,
    "rolling": 16,
}
"""ROS 2 distribution → bytes of a gid in `ros_discovery_info`; distributions with 16 announce type hashes too."""

_RANGES = ("SYSTEM_DEFAULT", "SUBNET", "LOCALHOST", "OFF")

# A participant that announces itself by unicast to the ports of the indices 0 to 32 is found by ROS 2 nodes with any
# ROS_LOCALHOST_ONLY. Its own index is from 10 to 32, by offsets of its ports: where lo has no multicast, as on Linux,
# nodes up to Humble take and search the indices 0 to 9 only. They learn of a participant from its next announcement,
# which must come before a `ros2` command gives up after 0.5 s. Peers are addresses: for a name without an address (no
# /etc/hosts), Cyclone DDS aborts the process. Multicast is for discovery only: images go to the processes that
# subscribe. A writer asks for missing confirmations after 10 ms, not 100: a process that leaves waits for them. A
# reader asks for missing samples after 100 ms, which sometimes delays a client's first request to a server that does
# not know the client yet: asking sooner makes a flood of samples worse.
_COMMON = (
    "<CycloneDDS><Domain><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<MaxAutoParticipantIndex>22</MaxAutoParticipantIndex>"
    "<Ports><UnicastMetaOffset>30</UnicastMetaOffset><UnicastDataOffset>31</UnicastDataOffset></Ports>"
    '<Peers><Peer address="127.0.0.1"/>{}</Peers>'
    "<InitialLocatorPruneDelay>inf</InitialLocatorPruneDelay>"
    "<DiscoveredLocatorPruneDelay>inf</DiscoveredLocatorPruneDelay>"
    "<SPDPInterval>300ms</SPDPInterval></Discovery>"
    '<Internal><HeartbeatInterval min="2ms" minsched="5ms" max="8s">10ms</HeartbeatInterval></Internal>'
    "</Domain></CycloneDDS>"
)
_LOOPBACK = (
    '<CycloneDDS><Domain><General><Interfaces><NetworkInterface address="127.0.0.1" multicast="true"/></Interfaces>'
    "</General></Domain></CycloneDDS>"
)
_LARGE_FRAGMENTS = (  # an image is two datagrams; beyond loopback, networks lose datagrams of this size
    "<CycloneDDS><Domain><General><AllowMulticast>spdp</AllowMulticast><MaxMessageSize>65000B</MaxMessageSize>"
    "<FragmentSize>63000B</FragmentSize></General></Domain></CycloneDDS>"
)
_LOWER_PEER = '<Peer address="127.0.0.1:{}"/>'
_TAG = "<CycloneDDS><Domain><Discovery><Tag>{}</Tag></Discovery></Domain></CycloneDDS>"


@dataclass(frozen=True, slots=True)
class Configuration:
    """The settings of a participant.

    Attributes:
        cyclonedds: settings as in CYCLONEDDS_URI; later settings win.
        gid_size: bytes of a gid in `ros_discovery_info`, at first.
        adapts: whether `gid_size` becomes 16 when other participants send 16 bytes.
        announces_hashes: whether endpoints announce the hash of their type.
    """

    domain_id: int
    cyclonedds: str
    gid_size: int
    adapts: bool
    announces_hashes: bool


def read_configuration(
    environment: Mapping[str, str] | None,
    *,
    domain_id: int | None = None,
    network: bool = False,
    distro: str | None = None,
) -> Configuration:
    """Return the settings from the arguments of `CycloneDDS`, which win, and the environment.

    Announcements begin in the older form if the distribution of other nodes is unknown: newer distributions read it
    as an announcement without nodes, but older distributions fail to join when they receive the newer form.
    """
    environment = os.environ if environment is None else environment
    if distro is not None and distro not in DISTROS:
        raise MiddlewareError(f"The ROS 2 distribution must be one of {', '.join(DISTROS)}, got {distro!r}.")
    reach = _reach(environment, network=network)
    domain = _domain_id(environment, domain_id)
    common = _COMMON.format(
        "".join(_LOWER_PEER.format(7410 + 250 * domain + 2 * index) for index in range(10))
    )
    settings = [common] if network else [common, _LARGE_FRAGMENTS]
    uri = environment.get("CYCLONEDDS_URI", "").strip()
    interfaces = list(_interfaces(uri))
    if not network:
        _check_loopback(interfaces)
        if not interfaces:  # naming an interface twice is an error
            settings.append(_LOOPBACK)
    if reach == "OFF":
        settings.append(_TAG.format(f"ros_discovery_off_{uuid4().hex}"))
    size = DISTROS.get(distro or environment.get("ROS_DISTRO", ""))
    return Configuration(
        domain_id=domain,
        cyclonedds=",".join([*settings, uri] if uri else settings),
        gid_size=size or 24,
        adapts=distro is None,
        announces_hashes=size != 24,  # noqa: PLR2004
    )


def _domain_id(environment: Mapping[str, str], given: int | None) -> int:
    name, text = "The domain id", str(given)
    if given is None:
        name, text = "ROS_DOMAIN_ID", environment.get("ROS_DOMAIN_ID", "").strip() or "0"
    if not re.fullmatch(r"[0-9]{1,3}", text) or int(text) > LAST_DOMAIN_ID:
        raise MiddlewareError(f"{name} must be a whole number from 0 to {LAST_DOMAIN_ID}, got {text!r}.")
    return int(text)


def _reach(environment: Mapping[str, str], *, network: bool) -> str:
    """Return a member of `_RANGES`, of which the first two mean the network."""
    only = environment.get("ROS_LOCALHOST_ONLY", "").strip()
    if only not in {"", "0", "1"}:
        raise MiddlewareError(f"ROS_LOCALHOST_ONLY must be 0 or 1, got {only!r}.")
    reach = environment.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "").strip() or "SYSTEM_DEFAULT"
    if reach not in _RANGES:
        raise MiddlewareError(
            f"ROS_AUTOMATIC_DISCOVERY_RANGE must be one of {', '.join(_RANGES)}, got {reach!r}."
        )
    name, value = ("ROS_LOCALHOST_ONLY", "1") if only == "1" else ("ROS_AUTOMATIC_DISCOVERY_RANGE", reach)
    reach = "LOCALHOST" if only == "1" else reach
    if network and reach in {"LOCALHOST", "OFF"}:
        raise MiddlewareError(
            f"{name}={value} keeps this process from the network that was asked for; unset it, or stay on loopback."
        )
    return reach


def _interfaces(uri: str) -> Iterator[str]:
    """Yield the network interfaces, names or addresses, that CYCLONEDDS_URI selects."""
    text = re.sub(r"<!--.*?-->", "", "".join(_fragments(uri)), flags=re.DOTALL)
    for attributes in re.findall(r"<NetworkInterface\b([^>]*)>", text, re.IGNORECASE):
        found = re.search(r"""\b(?:address|name)\s*=\s*["']([^"']*)["']""", attributes, re.IGNORECASE)
        yield found[1] if found else "chosen automatically"
    for addresses in re.findall(r"<NetworkInterfaceAddress>([^<]*)<", text, re.IGNORECASE):
        yield from (address.strip() for address in addresses.split(","))


def _fragments(uri: str) -> Iterator[str]:
    """Yield the XML texts of CYCLONEDDS_URI, a list of texts and files separated by commas."""
    for part in re.split(r",(?=\s*<)|(?<=>),", uri):
        if part.strip().startswith("<"):
            yield part
            continue
        for name in filter(None, part.split(",")):
            path = Path(name.strip().removeprefix("file://"))
            try:
                yield path.read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError) as error:
                raise MiddlewareError(
                    f"CYCLONEDDS_URI names the file {path}, which cannot be read: {error}."
                ) from error


def _check_loopback(interfaces: list[str]) -> None:
    for name in interfaces:
        if not re.match(r"lo\d*$|localhost$|127\.|::1$|\[::1\]$", name):
            raise MiddlewareError(
                f"CYCLONEDDS_URI selects the network interface {name!r}, but this process stays on loopback unless "
                "the network is asked for (--network); name 'lo' there, or ask for it."
            )
