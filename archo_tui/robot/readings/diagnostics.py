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

    def add(self, message: Any, now: float) -> bool:
        """Update the table with the statuses of a DiagnosticArray.

        Of several statuses of one part in the array, the worst counts.
        """
        found = dict(self._by_key)
        well: list[_Key] | None = None  # Parts that may be dropped for one that is not OK.
        for status in _worst(message.status, now):
            if status.key not in found and len(found) >= _MOST:
                if status.level is DiagnosticLevel.OK:
                    continue
                well = _parts_that_are_ok(self._by_key) if well is None else well
                while well and not _is_well(found.get(well[-1])):
                    well.pop()
                if not well:
                    continue
                found.pop(well[-1])
                self._periods.pop(well.pop())
            period = self._periods.get(status.key, Period()).with_message_at(now)
            self._periods[status.key] = period
            found[status.key] = status._replace(period=period.typical)
            unnamed = (status.name, "")
            if status.hardware_id and _is_well(found.get(unnamed)):
                found.pop(unnamed)
                self._periods.pop(unnamed)
        return self._replace_by(found)

    def forget(self, key: tuple[str, str]) -> bool:
        """Drop the part of a name and hardware id; return False if there is none."""
        self._periods.pop(key, None)
        return self._replace_by({k: status for k, status in self._by_key.items() if k != key})

    def _replace_by(self, found: Mapping[_Key, Diagnostic]) -> bool:
        """Set all statuses; return True if a level differs, or a part came or went."""
        levels = {key: status.level for key, status in found.items()}
        changed = levels != {key: status.level for key, status in self._by_key.items()}
        self._by_key = found
        self.all = tuple(found[key] for key in sorted(found))
        return changed


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


def _parts_that_are_ok(found: Mapping[_Key, Diagnostic]) -> list[_Key]:
    """Return the parts that are OK, the one that was received longest ago last."""
    well = filter(_is_well, found.values())
    return [status.key for status in sorted(well, key=lambda status: -status.received)]


def _is_well(status: Diagnostic | None) -> bool:
    return status is not None and status.level is DiagnosticLevel.OK


def _number(level: Any) -> int:
    """Return a level as a number; rosidl's Python has a `byte` as `bytes` of length one."""
    return level[0] if isinstance(level, bytes) else int(level)
