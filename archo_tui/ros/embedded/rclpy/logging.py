"""The module `rclpy.logging`: loggers, whose lines go to standard error and to /rosout."""

from __future__ import annotations

import sys
from collections.abc import Callable
from enum import IntEnum
from types import FrameType
from typing import TYPE_CHECKING, Any

from rcl_interfaces import srv
from rcl_interfaces.msg import Log, LoggerLevel, SetLoggerLevelsResult
from rclpy import _time_source
from rclpy.time import Time

if TYPE_CHECKING:
    from rclpy.node import Node


class LoggingSeverity(IntEnum):
    """The severities of rcl_interfaces/Log."""

    UNSET = 0
    DEBUG = 10
    INFO = 20
    WARN = 30
    ERROR = 40
    FATAL = 50


Publish = Callable[[Any], None]
_levels: dict[str, int] = {"": LoggingSeverity.INFO}  # The root's level, which all inherit, is "".
_rosout: dict[str, Publish] = {}  # What publishes the lines of a node's logger and its children.
_stdout_logs = True


def configure(stdout_logs: bool, level: int) -> None:
    """Set whether lines are written to standard error, and the root's level unless it is 0."""
    global _stdout_logs
    _stdout_logs = stdout_logs
    _levels[""] = level or _levels[""]


def connect(name: str, publish: Publish) -> None:
    """Publish the lines of a logger and of its children; the last one connected counts."""
    _rosout[name] = publish


def disconnect(name: str, publish: Publish) -> None:
    """Undo `connect`, unless another function has been connected to the name since."""
    if _rosout.get(name) == publish:
        del _rosout[name]


def _of_nearest(table: dict[str, Any], name: str) -> Any:
    """Return what a table has for a logger, or else for the nearest logger above it."""
    while name and not table.get(name):
        name = name.rpartition(".")[0]
    return table.get(name)


class RcutilsLogger:
    """A named logger.

    The filters `once`, `skip_first` and `throttle_duration_sec` (s) count the calls from each place
    in the source by itself.
    """

    def __init__(self, name: str = "") -> None:
        self.name = name
        self._places: dict[tuple[str, int, int], _Place] = {}

    def get_child(self, name: str) -> RcutilsLogger:
        """Return a new logger named `<own name>.<name>`."""
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return RcutilsLogger(f"{self.name}.{name}" if self.name else name)

    def set_level(self, level: LoggingSeverity | int) -> None:
        """Log from this severity on, here and in all loggers below without a level of their own.

        UNSET inherits the level again.
        """
        _levels[self.name] = LoggingSeverity(level)

    def get_effective_level(self) -> LoggingSeverity:
        """Return the level in force, own or inherited."""
        return LoggingSeverity(_of_nearest(_levels, self.name))

    def is_enabled_for(self, severity: LoggingSeverity | int) -> bool:
        """Return True if the level in force lets a line of this severity pass."""
        return bool(severity >= _of_nearest(_levels, self.name))

    def log(self, message: str | None, severity: LoggingSeverity | int, **filters: Any) -> bool:
        """Log a line, and return True; return False if the level or a filter keeps it back."""
        if not self.is_enabled_for(severity):
            return False
        severity = LoggingSeverity(severity)
        frame: FrameType | None = sys._getframe(1)
        while frame is not None and frame.f_code.co_filename == __file__:
            frame = frame.f_back
        assert frame is not None
        code = frame.f_code
        where = code.co_filename, frame.f_lineno, frame.f_lasti
        place = self._places.setdefault(where, _Place())
        if not place.passes(severity, {name: value for name, value in filters.items() if value}):
            return False
        if message is not None and not isinstance(message, str):
            raise TypeError(f"a log line is a str, not {type(message).__name__}")
        text = _encodable(str(message))
        stamp = Time(nanoseconds=_time_source.time_ns()).to_msg()
        if _stdout_logs:
            at = f"{stamp.sec}.{stamp.nanosec:09}"
            line = f"[{severity.name}] [{at}] [{self.name}]: {text}"
            print(line, file=sys.stderr, flush=True)
        publish = _of_nearest(_rosout, self.name)
        if publish is not None:
            entry = Log(stamp=stamp, level=int(severity), name=self.name, msg=text)
            entry.file, entry.function, entry.line = code.co_filename, code.co_name, frame.f_lineno
            publish(entry)
        return True

    def debug(self, message: str | None, **filters: Any) -> bool:
        """Log at DEBUG."""
        return self.log(message, LoggingSeverity.DEBUG, **filters)

    def info(self, message: str | None, **filters: Any) -> bool:
        """Log at INFO."""
        return self.log(message, LoggingSeverity.INFO, **filters)

    def warning(self, message: str | None, **filters: Any) -> bool:
        """Log at WARN."""
        return self.log(message, LoggingSeverity.WARN, **filters)

    warn = warning  # The old name.

    def error(self, message: str | None, **filters: Any) -> bool:
        """Log at ERROR."""
        return self.log(message, LoggingSeverity.ERROR, **filters)

    def fatal(self, message: str | None, **filters: Any) -> bool:
        """Log at FATAL."""
        return self.log(message, LoggingSeverity.FATAL, **filters)


class _Place:
    """A place in the source that logs, and what its filters have counted."""

    _first: tuple[LoggingSeverity, dict[str, Any]] | None = None
    _passed_ns = 0  # When the throttle last let a line pass, by its clock.
    _has_skipped = _has_logged = False

    def passes(self, severity: LoggingSeverity, filters: dict[str, Any]) -> bool:
        """Return True if every filter lets a line pass; ValueError if they were others before."""
        if self._first is None:
            self._first = severity, filters
        if self._first != (severity, filters):
            what = "Logger severity" if self._first[0] != severity else "Logging filters"
            raise ValueError(f"{what} cannot be changed between calls.")
        return not filters or self._count(**filters)

    def _count(
        self,
        *,
        throttle_duration_sec: float = 0.0,
        throttle_time_source_type: Any = None,
        skip_first: bool = False,
        once: bool = False,
    ) -> bool:
        """Ask the filters in this order; those behind the first that refuses count nothing."""
        if throttle_duration_sec:
            clock = throttle_time_source_type
            now = _time_source.time_ns() if clock is None else clock.now().nanoseconds
            if now < self._passed_ns + throttle_duration_sec * 1e9:
                return False
            self._passed_ns = now
        if skip_first and not self._has_skipped:
            self._has_skipped = True
            return False
        if once and self._has_logged:
            return False
        self._has_logged = True
        return True


def _encodable(text: str) -> str:
    try:
        text.encode()
    except UnicodeEncodeError:  # A lone surrogate, which in UTF-16 alone takes one character.
        return text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
    return text


def get_logger(name: str) -> RcutilsLogger:
    """Return a new logger of that name, without a node."""
    return RcutilsLogger().get_child(name)


def set_logger_level(name: str, level: LoggingSeverity | int) -> None:
    """Set a logger's level by name; "" means the root."""
    RcutilsLogger(name).set_level(level)


def get_logger_level(name: str) -> LoggingSeverity:
    """Return the level that was set for that name itself; UNSET if the logger inherits one."""
    return LoggingSeverity(_levels.get(name, LoggingSeverity.UNSET))


def get_logger_effective_level(name: str) -> LoggingSeverity:
    """Return the level in force for that name."""
    return RcutilsLogger(name).get_effective_level()


def get_logging_severity_from_string(log_severity: str) -> LoggingSeverity:
    """Return the severity of a word such as `WARN`, in any case."""
    return LoggingSeverity[log_severity.upper()]


class LoggingService:
    """The services `~/get_logger_levels` and `~/set_logger_levels`, which a new object offers."""

    def __init__(self, node: Node) -> None:
        node.create_service(srv.GetLoggerLevels, "~/get_logger_levels", self._get)
        node.create_service(srv.SetLoggerLevels, "~/set_logger_levels", self._set)

    def _get(self, request: Any, response: Any) -> Any:
        response.levels = [
            LoggerLevel(name=name, level=int(get_logger_level(name))) for name in request.names
        ]
        return response

    def _set(self, request: Any, response: Any) -> Any:
        results = []
        for wanted in request.levels:
            result = SetLoggerLevelsResult(successful=True)
            try:
                set_logger_level(wanted.name, wanted.level)
            except ValueError:
                reason = "Failed reason: Invalid logger level."
                result = SetLoggerLevelsResult(successful=False, reason=reason)
            results.append(result)
        response.results = results
        return response
