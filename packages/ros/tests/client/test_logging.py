from typing import TYPE_CHECKING

import pytest

from sunset_ros.interfaces import Message
from sunset_ros.interfaces.rcl_interfaces.msg import Log
from sunset_ros.logging import Logger, LoggingSeverity
from sunset_ros.rmw.sim import Tap

if TYPE_CHECKING:
    from .conftest import World


class Sink:
    def __init__(self) -> None:
        self.records: list[Log] = []
        self.now = 0

    def now_ns(self) -> int:
        return self.now

    def write(self, message: Log) -> None:
        self.records.append(message)

    @property
    def texts(self) -> list[str]:
        return [record.msg for record in self.records]


@pytest.fixture
def sink() -> Sink:
    return Sink()


def test_a_record_tells_who_logs_and_where(sink: Sink) -> None:
    assert Logger("uav.camera", sink).warning("blurred")
    (record,) = sink.records
    assert (record.level, record.name, record.msg) == (LoggingSeverity.WARN, "uav.camera", "blurred")
    assert (record.file, record.function) == (
        "test_logging.py",
        "test_a_record_tells_who_logs_and_where",
    )


def test_each_severity_has_its_method(sink: Sink) -> None:
    logger = Logger("a", sink, LoggingSeverity.DEBUG)
    for method in (logger.debug, logger.info, logger.warn, logger.error, logger.fatal):
        method("x")
    logger.log("x", LoggingSeverity.INFO)
    names = [LoggingSeverity(record.level).name for record in sink.records]
    assert names == ["DEBUG", "INFO", "WARN", "ERROR", "FATAL", "INFO"]


def test_nothing_less_severe_than_the_level_is_logged(sink: Sink) -> None:
    logger = Logger("a", sink)
    assert not logger.debug("hidden")
    logger.set_level(LoggingSeverity.ERROR)
    assert not logger.warning("hidden")
    assert logger.error("shown")
    assert sink.texts == ["shown"]


def test_a_child_has_its_parents_level_until_it_has_its_own(sink: Sink) -> None:
    parent = Logger("a", sink)
    child = parent.get_child("b")
    parent.set_level(LoggingSeverity.ERROR)
    assert child.name == "a.b"
    assert child.get_effective_level() is LoggingSeverity.ERROR
    child.set_level(LoggingSeverity.DEBUG)
    assert child.is_enabled_for(LoggingSeverity.DEBUG)
    with pytest.raises(ValueError, match="needs a name"):
        parent.get_child("")


def test_once_is_once_for_each_line(sink: Sink) -> None:
    logger = Logger("a", sink)
    for text in ("a", "b", "c"):
        logger.info(text, once=True)
        logger.info(text.upper(), once=True)
    assert sink.texts == ["a", "A"]


def test_throttled_messages_keep_their_distance(sink: Sink) -> None:
    logger = Logger("a", sink)
    for now in (0, 5, 10, 15, 25):
        sink.now = now * 10**8
        logger.info(str(now), throttle_duration_sec=1.0)
    assert sink.texts == ["0", "10", "25"]


def test_the_first_can_be_skipped(sink: Sink) -> None:
    logger = Logger("a", sink)
    for number in range(3):
        logger.info(str(number), skip_first=True)
    assert sink.texts == ["1", "2"]


def test_once_is_the_first_time_that_is_not_skipped_or_throttled(sink: Sink) -> None:
    logger = Logger("a", sink)
    for second in range(4):
        sink.now = second * 10**9
        text = str(second)
        logger.info(text, once=True, skip_first=True)
        logger.warning(text, once=True, throttle_duration_sec=0.5)
    assert [(LoggingSeverity(record.level).name, record.msg) for record in sink.records] == [
        ("WARN", "0"),
        ("INFO", "1"),
    ]


def test_a_clock_of_ones_own_can_throttle(sink: Sink) -> None:
    logger, clock = Logger("a", sink), Sink()
    for second in range(3):
        clock.now = second * 10**9
        logger.info(str(second), throttle_duration_sec=2.0, throttle_time_source_type=clock)
    assert sink.texts == ["0", "2"]


def test_a_node_logs_to_rosout(world: "World") -> None:
    seen: list[Message] = []

    class Listener(Tap):
        def on_message(self, time_ns: int, topic: str, node: str, message: Message) -> None:
            if topic == "/rosout":
                seen.append(message)

    world.simulation.add_tap(Listener())
    node = world.node("camera", namespace="uav")
    world.pass_time(1.5)
    node.get_logger().error("broken")
    (log,) = seen
    assert isinstance(log, Log)
    assert (log.name, log.level, log.msg, log.stamp.sec) == ("uav.camera", Log.ERROR, "broken", 1)


def test_messages_are_throttled_by_a_time_that_nobody_sets(world: "World") -> None:
    node = world.node("camera", ["--ros-args", "-p", "use_sim_time:=true"])  # nobody tells the time
    logged = []
    for _ in range(3):
        logged.append(node.get_logger().error("broken", throttle_duration_sec=1.0))
        world.pass_time(0.6)
    assert logged == [True, False, True]


def test_a_context_can_be_told_to_log_to_stderr(world: "World", capsys: pytest.CaptureFixture[str]) -> None:
    loud = world.node("loud", ["--ros-args", "--enable-stdout-logs", "--log-level", "debug"])
    quiet = world.node("quiet")
    loud.get_logger().debug("heard")
    quiet.get_logger().fatal("not heard")
    captured = capsys.readouterr()
    assert captured.err == "[DEBUG] [0.000000000] [loud]: heard\n"
    assert captured.out == ""


def test_rosout_can_be_left_out(world: "World") -> None:
    world.node("first", ["--ros-args", "--disable-rosout-logs"]).get_logger().info("x")
    second = world.node("second", enable_rosout=False)
    second.get_logger().info("x")
    assert second.count_publishers("/rosout") == 0


def test_a_node_whose_process_has_ended_can_still_be_asked_to_log(world: "World") -> None:
    node = world.node("camera")
    world.simulation.kill(world.processes["camera"])
    assert node.get_logger().info("too late")
