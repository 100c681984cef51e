"""The last diagnostic statuses by name. No input or output."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.robot.period import Period
from archo_tui.robot.state import Diagnostic, DiagnosticLevel
from archo_tui.safe_text import harmless

_MOST = 1000  # Names that are kept; a publisher of ever new names must not fill the memory.
# The constants of diagnostic_msgs/msg/DiagnosticStatus.
_LEVELS = dict(enumerate(DiagnosticLevel))


class Diagnostics:
    """The last diagnostic status of each part of the robot, by its name on /diagnostics.

    Attributes:
        all: The statuses, sorted by name.
    """

    def __init__(self) -> None:
        """Create a table without a status."""
        self.all: tuple[Diagnostic, ...] = ()
        self._by_name: Mapping[str, Diagnostic] = {}
        self._periods: dict[str, Period] = {}

    def copy(self) -> Diagnostics:
        """Return an independent table with the same statuses."""
        copied = Diagnostics()
        copied.all, copied._by_name, copied._periods = self.all, self._by_name, dict(self._periods)
        return copied

    def add(self, message: Any, now: float) -> bool:
        """Update the table with the statuses of a DiagnosticArray.

        At most 1,000 names are kept. Then a new name that is OK is ignored, and one that is not
        takes the place of the name that has been OK and silent for the longest time, if any is. An
        unknown level counts as ERROR.

        Args:
            message: The DiagnosticArray.
            now: The monotonic time of its receipt in seconds.

        Returns:
            True if a level differs from the one before, or a name came or went; not for another
            text.
        """
        found = dict(self._by_name)
        well: list[str] | None = None  # Names that may be dropped for one that is not OK.
        for status in message.status:
            name = harmless(status.name) or "(without a name)"
            level = _LEVELS.get(_number(status.level), DiagnosticLevel.ERROR)
            if name not in found and len(found) >= _MOST:
                if level is DiagnosticLevel.OK:
                    continue
                well = _names_that_are_ok(self._by_name) if well is None else well
                while well and not _is_well(found.get(well[-1])):
                    well.pop()
                if not well:
                    continue
                found.pop(well[-1])
                self._periods.pop(well.pop())
            period = self._periods[name] = self._periods.get(name, Period()).with_message_at(now)
            found[name] = Diagnostic(
                name,
                harmless(status.hardware_id),
                level,
                harmless(status.message),
                now,
                period.typical,
            )
        levels = {name: status.level for name, status in found.items()}
        changed = levels != {name: status.level for name, status in self._by_name.items()}
        self._by_name = found
        self.all = tuple(found[name] for name in sorted(found))
        return changed


def _names_that_are_ok(found: Mapping[str, Diagnostic]) -> list[str]:
    """Return the names of the statuses that are OK, the one that was received longest ago last."""
    well = filter(_is_well, found.values())
    return [status.name for status in sorted(well, key=lambda status: -status.received)]


def _is_well(status: Diagnostic | None) -> bool:
    return status is not None and status.level is DiagnosticLevel.OK


def _number(level: Any) -> int:
    """Return a level as a number; rosidl's Python has a `byte` as `bytes` of length one."""
    return level[0] if isinstance(level, bytes) else int(level)
