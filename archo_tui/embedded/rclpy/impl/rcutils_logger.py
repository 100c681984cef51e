"""The module `rclpy.impl.rcutils_logger`: the loggers that `node.get_logger()` returns."""

from __future__ import annotations

import sys
import warnings
from types import FrameType
from typing import Any

from rcl_interfaces.msg import Log
from rclpy import _logging
from rclpy.clock import Clock, ROSClock
from rclpy.impl.logging_severity import LoggingSeverity

_Where = tuple[str, str, int, int]  # Function, file, line and instruction of a call.
_BY_WARN = "warn", __file__, 0, 0  # In rclpy, the place of the decorator of deprecated functions.


class RcutilsLogger:
    """A named logger, whose lines go to standard error and, for a node's logger, to /rosout.

    The filters `once`, `skip_first` and `throttle_duration_sec` (s) count the calls from each place
    in the source by itself.
    """

    def __init__(self, name: str = "") -> None:
        self.name = name
        self._places: dict[_Where, _Place] = {}

    def get_child(self, name: str) -> RcutilsLogger:
        """Return a new logger named `<own name>.<name>`."""
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return RcutilsLogger(self.name + "." + name if self.name else name)

    def set_level(self, level: LoggingSeverity | int) -> None:
        """Log from this severity on, here and in all loggers below without a level of their own.

        UNSET inherits the level again.
        """
        _logging.set_level(self.name, LoggingSeverity(level))

    def get_effective_level(self) -> LoggingSeverity:
        """Return the level in force, own or inherited."""
        return LoggingSeverity(_logging.effective_level(self.name))

    def is_enabled_for(self, severity: LoggingSeverity | int) -> bool:
        """Return True if the level in force lets a line of this severity pass."""
        return int(severity) >= _logging.effective_level(self.name)

    def log(
        self,
        message: str | None,
        severity: LoggingSeverity | int,
        name: str | None = None,
        **filters: Any,
    ) -> bool:
        """Log a line, and return True; return False if the level or a filter keeps it back."""
        if not self.is_enabled_for(severity):
            return False
        if type(severity) is not LoggingSeverity:
            severity = LoggingSeverity(severity)
        name = self.name if name is None else name
        asked = _filter_options(filters) if filters else {}
        frame: FrameType | None = sys._getframe(1)
        by_warn = False
        while frame is not None and frame.f_code.co_filename == __file__:
            by_warn = by_warn or frame.f_code is RcutilsLogger.warn.__code__
            frame = frame.f_back
        assert frame is not None
        code = frame.f_code
        here = code.co_name, code.co_filename, frame.f_lineno, frame.f_lasti
        where = _BY_WARN if by_warn else here
        place = self._places.get(where)
        if place is None:
            place = self._places[where] = _Place(severity, name, asked)
        place.check(severity, name, asked)
        if asked and not place.passes():
            return False
        if message is not None and not isinstance(message, str):
            raise TypeError(f"a log line is a str, not {type(message).__name__}")
        message = _encodable(str(message))
        stamp = _SYSTEM.now().to_msg()
        if _logging.is_written():
            at = f"{stamp.sec}.{stamp.nanosec:09}"
            _logging.write(f"[{severity.name}] [{at}] [{name}]: {message}")
        publish = _logging.rosout(name)
        if publish is not None:
            publish(
                Log(
                    stamp=stamp,
                    level=int(severity),
                    name=name,
                    msg=message,
                    file=code.co_filename,
                    function=code.co_name,
                    line=frame.f_lineno,
                )
            )
        return True

    def debug(self, message: str | None, **options: Any) -> bool:
        """Log at DEBUG; arguments, value and errors are those of `log`."""
        return self.log(message, LoggingSeverity.DEBUG, **options)

    def info(self, message: str | None, **options: Any) -> bool:
        """Log at INFO; arguments, value and errors are those of `log`."""
        return self.log(message, LoggingSeverity.INFO, **options)

    def warning(self, message: str | None, **options: Any) -> bool:
        """Log at WARN; arguments, value and errors are those of `log`."""
        return self.log(message, LoggingSeverity.WARN, **options)

    def warn(self, message: str | None, **options: Any) -> bool:
        """Log at WARN, and give a DeprecationWarning for this old name of `warning`.

        All calls count as one place, as in rclpy.
        """
        warnings.warn("Deprecated in favor of `RcutilsLogger.warning`.", DeprecationWarning, 2)
        return self.warning(message, **options)

    def error(self, message: str | None, **options: Any) -> bool:
        """Log at ERROR; arguments, value and errors are those of `log`."""
        return self.log(message, LoggingSeverity.ERROR, **options)

    def fatal(self, message: str | None, **options: Any) -> bool:
        """Log at FATAL; arguments, value and errors are those of `log`."""
        return self.log(message, LoggingSeverity.FATAL, **options)


def _encodable(text: str) -> str:
    try:
        text.encode()
    except UnicodeEncodeError:  # A lone surrogate, which in UTF-16 alone takes one character.
        return text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")
    return text


# The options of each filter, in the order in which the filters are asked.
_OPTIONS = {
    "throttle": ("throttle_duration_sec", "throttle_time_source_type"),
    "skip_first": ("skip_first",),
    "once": ("once",),
}
_KNOWN = [option for options in _OPTIONS.values() for option in options]
_MACHINE = Clock()  # The throttle's clock by default.
_SYSTEM = ROSClock()  # Without a node it is never simulated.


def _filter_options(given: dict[str, Any]) -> dict[str, Any]:
    """Return all options of those filters that are switched on, in the order of the filters."""
    found = {name for name, options in _OPTIONS.items() if any(map(given.get, options))}
    if "throttle" in found and "throttle_duration_sec" not in given:
        raise TypeError(
            'required parameter "throttle_duration_sec" not specified but is required for the '
            'the logging filter "throttle"'
        )
    for option in given:
        if option not in _KNOWN:
            raise TypeError(
                f'parameter "{option}" is not one of the recognized logging options "{_KNOWN}"'
            )
    return {
        option: given.get(option, _MACHINE)
        for name in _OPTIONS
        if name in found
        for option in _OPTIONS[name]
    }


class _Place:
    """A place in the source that logs, and what its filters have counted."""

    def __init__(self, severity: LoggingSeverity, name: str, asked: dict[str, Any]) -> None:
        clock = asked.get("throttle_time_source_type", _MACHINE)
        if not isinstance(clock, Clock):
            raise ValueError(
                f'Received throttle_time_source_type of "{clock}" is not a clock instance'
            )
        self._first = severity, name, asked
        self._asked = asked
        self._last = 0  # When the throttle last let a line pass, in ns of its clock.
        self._is_first, self._is_logged = True, False

    def check(self, severity: LoggingSeverity, name: str, asked: dict[str, Any]) -> None:
        """Raise ValueError if severity, name or filters differ from the first call's here."""
        if self._first == (severity, name, asked):
            return
        if self._first[0] != severity:
            what = "Logger severity"
        elif self._first[1] != name:
            what = "Logger name"
        elif self._asked.keys() != asked.keys():
            what = "Requested logging filters"
        else:
            what = "Logging filter parameters"
        raise ValueError(f"{what} cannot be changed between calls.")

    def passes(self) -> bool:
        """Return True if every filter lets a line pass, and count the line.

        The filters are asked in their order, and those behind the first that refuses count nothing.
        """
        asked = self._asked
        if "throttle_duration_sec" in asked:
            now = asked["throttle_time_source_type"].now().nanoseconds
            if now < self._last + asked["throttle_duration_sec"] * 1e9:
                return False
            self._last = now
        if "skip_first" in asked and self._is_first:
            self._is_first = False
            return False
        if "once" in asked and self._is_logged:
            return False
        self._is_logged = True
        return True
