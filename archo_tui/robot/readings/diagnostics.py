"""The last diagnostic statuses by part. No input or output."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from archo_tui.robot.messages.period import Period
from archo_tui.robot.state.readings import WORST_FIRST, Diagnostic, DiagnosticLevel
from archo_tui.safe_text import harmless

_MOST = 1000  # Parts that are kept; a publisher of ever new names must not fill the memory.
# The constants of diagnostic_msgs/msg/DiagnosticStatus.
_LEVELS = dict(enumerate(DiagnosticLevel))


_Key = tuple[str, str]  # The name and the hardware id of a part.


class Diagnostics:
    """The last diagnostic status of each part of the robot, by its name and hardware id."""

    def __init__(self) -> None:
        self.all: tuple[Diagnostic, ...] = ()  # The statuses, sorted by name and hardware id.
        self._by_key: Mapping[_Key, Diagnostic] = {}
        self._periods: dict[_Key, Period] = {}

    def add(self, message: Any, now: float) -> None:
        """Update the table with the statuses of a DiagnosticArray.

        Of several statuses of one part in the array, the worst counts.
        """
        found = dict(self._by_key)
        for status in _worst(message.status, now):
            period = self._periods.get(status.key, Period()).with_message_at(now)
            self._periods[status.key] = period
            found[status.key] = status._replace(period=period.typical)
            unnamed = found.get((status.name, ""))
            if status.hardware_id and unnamed and unnamed.level is DiagnosticLevel.OK:
                del found[unnamed.key]
        if len(found) > _MOST:  # What is OK, and was received longest ago, makes way.
            kept = sorted(
                found.values(), key=lambda s: (s.level is DiagnosticLevel.OK, -s.received)
            )
            found = {status.key: status for status in kept[:_MOST]}
        self._periods = {key: self._periods[key] for key in found}
        self._replace_by(found)

    def forget(self, key: tuple[str, str]) -> None:
        """Drop the part of a name and hardware id."""
        self._periods.pop(key, None)
        self._replace_by({k: status for k, status in self._by_key.items() if k != key})

    def _replace_by(self, found: Mapping[_Key, Diagnostic]) -> None:
        self._by_key = found
        self.all = tuple(found[key] for key in sorted(found))


def _worst(statuses: Iterable[Any], now: float) -> Iterable[Diagnostic]:
    """Return the worst status of each part in one array; of equally bad ones, the first."""
    worst: dict[_Key, Diagnostic] = {}
    for status in statuses:
        name = harmless(status.name) or "(without a name)"
        level = _LEVELS.get(_number(status.level), DiagnosticLevel.ERROR)
        text = harmless(status.message)
        new = Diagnostic(name, harmless(status.hardware_id), level, text, now)
        known = worst.setdefault(new.key, new)
        if WORST_FIRST.index(level) < WORST_FIRST.index(known.level):
            worst[new.key] = new
    return worst.values()


def _number(level: Any) -> int:
    """Return a level as a number; rosidl's Python has a `byte` as `bytes` of length one."""
    return level[0] if isinstance(level, bytes) else int(level)
