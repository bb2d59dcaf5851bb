"""The one place where private functions of the wheel are called."""

import gc
import socket
import time
from contextlib import ExitStack
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING

import pytest

from sunset_ros.errors import MiddlewareError, MissingExtraError
from sunset_ros.interfaces.std_msgs.msg import String
from sunset_ros.rmw.core.qos import QoSProfile
from sunset_ros.rmw.dds import _library as dds
from sunset_ros.rmw.dds import _wheel as wheel

if TYPE_CHECKING:
    from .conftest import Live

STRING = "std_msgs::msg::dds_::String_"
HELLO = bytes.fromhex("00010000 06000000 68656c6c6f000000")


def test_the_wheel_is_the_pinned_one() -> None:
    assert version("cyclonedds") == dds.VERSION


@pytest.mark.parametrize(("found", "named"), [(None, "none"), ("0.10.5", "0.10.5"), ("11.0.2", "11.0.2")])
def test_another_wheel_is_refused(found: str | None, named: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def version_of(_: str) -> str:
        if found is None:
            raise PackageNotFoundError
        return found

    monkeypatch.setattr(dds, "version", version_of)
    message = rf"^The live middleware needs cyclonedds 11\.0\.1, found {named}: pip install 'sunset-exemplar\[live\]', "
    with pytest.raises(MissingExtraError, match=message):
        dds.check_version()


def pair(live: "Live") -> tuple[int, int]:
    """Return a writer and a reader that are connected."""
    link = live.process().link
    with wheel.topic_of(link.participant, "rt/x", STRING) as topic:
        writer = dds.create_writer(link.participant, topic, QoSProfile())
        reader = dds.create_reader(link.participant, topic, QoSProfile(), b"key=value;")
    gc.collect()
    return writer, reader


def test_bytes_arrive_as_they_were_sent(live: "Live") -> None:
    writer, reader = pair(live)
    assert wheel.take(reader) is None
    wheel.write(writer, HELLO, "x")
    sample = wheel.take(reader)
    assert sample is not None
    assert sample[:2] == (HELLO, dds.instance_handle_of(writer))
    assert 0 <= time.time_ns() - sample[2] < 10 * 10**9
    assert wheel.take(reader) is None


def test_ends_know_each_other(live: "Live") -> None:
    writer, reader = pair(live)
    (handle,) = dds.matched_subscriptions(writer)
    assert handle == dds.instance_handle_of(reader)
    end = wheel.matched_subscription(writer, handle)
    assert end is not None
    assert (end.guid, end.topic, end.type_name, end.user_data) == (
        dds.guid_of(reader),
        "rt/x",
        STRING,
        b"key=value;",
    )
    (handle,) = dds.matched_publications(reader)
    other = wheel.matched_publication(reader, handle)
    assert other is not None
    assert other.guid == dds.guid_of(writer)
    assert wheel.matched_publication(reader, 1) is None
    dds.delete(writer)
    assert dds.matched_publications(reader) == ()
    assert dds.matched_subscriptions(writer) == ()


def test_what_is_gone_cannot_be_used(live: "Live") -> None:
    writer, reader = pair(live)
    for entity in (writer, reader):
        dds.delete(entity)
        dds.delete(entity)
    with pytest.raises(MiddlewareError, match=r"^DDS could not send a sample on x: .*\.$"):
        wheel.write(writer, HELLO, "x")
    with pytest.raises(MiddlewareError, match="DDS could not read a GUID"):
        dds.guid_of(writer)
    assert wheel.take(reader) is None


def test_topics_can_be_made_again_and_again(live: "Live") -> None:
    process = live.process()
    node = process.create_node("node", "/")
    for _ in range(200):
        publisher = node.create_publisher(String, "/x", QoSProfile())
        subscription = node.create_subscription(String, "/x", QoSProfile(), print, label="print")
        assert publisher.matched == 1
        publisher.destroy()
        subscription.destroy()
    assert process.endpoints() == []  # those that came and went between two looks included


def test_a_domain_has_room_for_23_processes_of_a_computer(
    live: "Live", capfd: pytest.CaptureFixture[str]
) -> None:
    with ExitStack() as held:
        for index in range(10, 33):
            port = held.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            port.bind(("", 7410 + 250 * live.domain_id + 2 * index))
        with pytest.raises(
            MiddlewareError,
            match="or 23 processes of this library are in the domain on this computer already",
        ):
            live.process()
    assert "Failed to find a free participant index" in capfd.readouterr().err
    live.process()
