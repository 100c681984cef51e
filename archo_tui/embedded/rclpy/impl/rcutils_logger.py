"""`RcutilsLogger`: what `node.get_logger()` returns."""

from __future__ import annotations

import sys
import warnings
from dataclasses import dataclass

from rcl_interfaces.msg import Log
from rclpy import _logging, _time_source
from rclpy.clock import Clock, ROSClock
from rclpy.impl.logging_severity import LoggingSeverity

_Where = tuple[str, str, int, int]  # of a call: function, file, line, instruction


class RcutilsLogger:
    """A named logger. Each line goes to standard error and, for a node's logger, to /rosout.

    `once`, `skip_first` and `throttle_duration_sec` (s) count per place in the source.
    """

    def __init__(self, name: str = "") -> None:
        self.name = name
        self._places: dict[_Where, _Place] = {}

    def get_child(self, name: str) -> RcutilsLogger:
        """A logger below this one. Raises ValueError for an empty name, TypeError for none."""
        if not name:
            raise ValueError("Child logger name must not be empty.")
        return RcutilsLogger(self.name + "." + name if self.name else name)

    def set_level(self, level: LoggingSeverity | int) -> None:
        """Log from this severity on. Raises ValueError for what is no severity."""
        _logging.set_level(self.name, LoggingSeverity(level))

    def get_effective_level(self) -> LoggingSeverity:
        """The level in force, own or inherited."""
        return LoggingSeverity(_logging.effective_level(self.name))

    def is_enabled_for(self, severity: LoggingSeverity | int) -> bool:
        """True when a line of this severity is logged."""
        return int(severity) >= _logging.effective_level(self.name)

    def log(self, message: str, severity: LoggingSeverity | int, **filters: float) -> bool:
        """Log at a severity; False when it was filtered out."""
        return self._log(message, LoggingSeverity(severity), filters)

    def debug(self, message: str, **filters: float) -> bool:
        """Log at DEBUG; False when it was filtered out."""
        return self._log(message, LoggingSeverity.DEBUG, filters)

    def info(self, message: str, **filters: float) -> bool:
        """Log at INFO; False when it was filtered out."""
        return self._log(message, LoggingSeverity.INFO, filters)

    def warning(self, message: str, **filters: float) -> bool:
        """Log at WARN; False when it was filtered out."""
        return self._log(message, LoggingSeverity.WARN, filters)

    def warn(self, message: str, **filters: float) -> bool:
        """The old name of `warning`."""
        warnings.warn("Deprecated in favor of `RcutilsLogger.warning`.", DeprecationWarning, 2)
        return self._log(message, LoggingSeverity.WARN, filters)

    def error(self, message: str, **filters: float) -> bool:
        """Log at ERROR; False when it was filtered out."""
        return self._log(message, LoggingSeverity.ERROR, filters)

    def fatal(self, message: str, **filters: float) -> bool:
        """Log at FATAL; False when it was filtered out."""
        return self._log(message, LoggingSeverity.FATAL, filters)

    def _log(self, message: str, severity: LoggingSeverity, filters: dict[str, float]) -> bool:
        if not self.is_enabled_for(severity):
            return False
        if not isinstance(message, str):
            raise TypeError(f"a log line is a str, not {type(message).__name__}")
        frame = sys._getframe(2)
        code = frame.f_code
        where = code.co_name, code.co_filename, frame.f_lineno, frame.f_lasti
        if not self._passes(where, severity, filters):
            return False
        stamp = ROSClock().now()
        sec, nanosec = stamp.seconds_nanoseconds()
        _logging.write(f"[{severity.name}] [{sec}.{nanosec:09}] [{self.name}]: {message}")
        publish = _logging.rosout(self.name)
        if publish is not None:
            publish(
                Log(
                    stamp=stamp.to_msg(),
                    level=int(severity),
                    name=self.name,
                    msg=str(message),
                    file=code.co_filename,
                    function=code.co_name,
                    line=frame.f_lineno,
                )
            )
        return True

    def _passes(self, where: _Where, severity: LoggingSeverity, filters: dict[str, float]) -> bool:
        place = self._places.get(where)
        if place is None:
            self._check(filters)
            place = self._places[where] = _Place(severity, filters)
        if place.severity != severity:
            raise ValueError("Logger severity cannot be changed between calls.")
        if place.filters != filters:
            what = "Requested logging filters"
            if _asked(place.filters) == _asked(filters):
                what = "Logging filter parameters"
            raise ValueError(f"{what} cannot be changed between calls.")
        if not filters:
            return True
        now = _time_source.monotonic_ns() / 1e9
        period = filters.get("throttle_duration_sec", 0.0)
        if place.last is not None and now - place.last < period:
            return False
        place.last = now
        if filters.get("skip_first") and not place.skipped:
            place.skipped = True
            return False
        if filters.get("once") and place.logged:
            return False
        place.logged = True
        return True

    def _check(self, filters: dict[str, float]) -> None:
        for name in filters:
            if name not in _FILTERS:
                known = ", ".join(_FILTERS)
                raise TypeError(
                    f'parameter "{name}" is not one of the recognized logging options "{known}"'
                )
        clock = filters.get("throttle_time_source_type")
        if clock is not None and "throttle_duration_sec" not in filters:
            raise TypeError(
                'required parameter "throttle_duration_sec" not specified but is required for the '
                'the logging filter "throttle"'
            )
        if clock is not None and not isinstance(clock, Clock):
            raise ValueError(
                f'Received throttle_time_source_type of "{clock}" is not a clock instance'
            )


_FILTERS = ("throttle_duration_sec", "throttle_time_source_type", "skip_first", "once")


@dataclass
class _Place:
    """One place in the source that logs."""

    severity: LoggingSeverity
    filters: dict[str, float]
    last: float | None = None  # s, when it last passed the throttle
    skipped: bool = False
    logged: bool = False


def _asked(filters: dict[str, float]) -> set[str]:
    """Those that are switched on."""
    return {name for name, value in filters.items() if value}
