"""Loggers, as in `rclpy.logging`: to /rosout, and to stderr if the context says so."""

import sys
from enum import IntEnum
from pathlib import PurePath
from types import FrameType
from typing import Final, Protocol, TypedDict, Unpack

from sunset_ros.interfaces.rcl_interfaces.msg import Log
from sunset_ros.texts import shorten

_LONGEST: Final = 10_000
"""Characters of a message that are logged."""


class LoggingSeverity(IntEnum):
    """How severe a message is; numbers as in rcl_interfaces/msg/Log."""

    UNSET = 0
    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50


class _ClockLike(Protocol):
    def now_ns(self) -> int: ...


class LogSink(_ClockLike, Protocol):
    """Where the messages of a node's loggers go, and the time by which they are throttled."""

    def write(self, message: Log) -> None:
        """Take a message without a stamp."""


class LogOptions(TypedDict, total=False):
    """Whether a line of source that logs is skipped; lines are identified by file and number."""

    throttle_duration_sec: float | None  # log from it at most once in so many seconds
    throttle_time_source_type: _ClockLike | None  # the clock for that; the node's if it is left out
    skip_first: bool  # do not log from it the first time
    once: bool  # log from it only once


class Logger:
    """Logs messages under a name, such as `managed_subsystem.camera`; without a level, its parent's holds."""

    def __init__(
        self,
        name: str,
        sink: LogSink,
        level: LoggingSeverity = LoggingSeverity.UNSET,
        parent: "Logger | None" = None,
    ) -> None:
        self.name = name
        self._sink = sink
        self._level = level
        self._parent = parent
        self._lines: dict[tuple[str, int], tuple[int, bool]] = {}  # when last due, whether ever logged

    def __repr__(self) -> str:
        return f"<Logger {self.name} {self.get_effective_level().name}>"

    def get_child(self, name: str) -> "Logger":
        """Return a logger whose name has another part; raise a `ValueError` if the part is empty."""
        if not name:
            raise ValueError("A child logger needs a name.")
        return Logger(f"{self.name}.{name}", self._sink, parent=self)

    def set_level(self, level: LoggingSeverity) -> None:
        """Log nothing less severe than `level`."""
        self._level = LoggingSeverity(level)

    def get_effective_level(self) -> LoggingSeverity:
        """Return the severity below which nothing is logged."""
        if self._level is LoggingSeverity.UNSET:
            return LoggingSeverity.INFO if self._parent is None else self._parent.get_effective_level()
        return self._level

    def is_enabled_for(self, severity: LoggingSeverity) -> bool:
        """Return whether messages of a severity are logged."""
        return severity >= self.get_effective_level()

    def debug(self, message: str, **options: Unpack[LogOptions]) -> bool:
        """Log with severity DEBUG; see `log`."""
        return self._log(message, LoggingSeverity.DEBUG, options)

    def info(self, message: str, **options: Unpack[LogOptions]) -> bool:
        """Log with severity INFO; see `log`."""
        return self._log(message, LoggingSeverity.INFO, options)

    def warning(self, message: str, **options: Unpack[LogOptions]) -> bool:
        """Log with severity WARN; see `log`."""
        return self._log(message, LoggingSeverity.WARN, options)

    warn = warning

    def error(self, message: str, **options: Unpack[LogOptions]) -> bool:
        """Log with severity ERROR; see `log`."""
        return self._log(message, LoggingSeverity.ERROR, options)

    def fatal(self, message: str, **options: Unpack[LogOptions]) -> bool:
        """Log with severity FATAL; see `log`."""
        return self._log(message, LoggingSeverity.FATAL, options)

    def log(self, message: str, severity: LoggingSeverity, **options: Unpack[LogOptions]) -> bool:
        """Log a message, unless the level or the options say otherwise; return whether it was logged."""
        return self._log(message, severity, options)

    def _log(self, message: str, severity: LoggingSeverity, options: LogOptions) -> bool:
        if not self.is_enabled_for(severity):
            return False
        frame = sys._getframe(2)  # noqa: SLF001  the only way to learn who logs
        if options and not self._is_due(frame, options):
            return False
        code = frame.f_code
        self._sink.write(
            Log(
                level=severity.value,
                name=self.name,
                msg=shorten(str(message), _LONGEST),
                file=PurePath(code.co_filename).name,  # without its folder: the same on every computer
                function=code.co_name,
                line=frame.f_lineno,
            )
        )
        return True

    def _is_due(self, frame: FrameType, options: LogOptions) -> bool:
        line = (frame.f_code.co_filename, frame.f_lineno)
        last_ns, logged = self._lines.get(line, (None, False))
        if logged and options.get("once"):
            return False
        now = (options.get("throttle_time_source_type") or self._sink).now_ns()
        throttle_s = options.get("throttle_duration_sec")
        if throttle_s is not None and last_ns is not None and now - last_ns < throttle_s * 1e9:
            return False
        due = last_ns is not None or not options.get("skip_first")
        self._lines[line] = (now, logged or due)
        return due
