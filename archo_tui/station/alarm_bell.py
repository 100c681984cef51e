"""The record of which alarms the operator was called for, by bell and notification."""

from __future__ import annotations

from collections.abc import Iterable

from archo_tui.station.alarms import Alarm, AlarmState, Priority


class AlarmBell:
    """The record of which alarms the operator was called for, by bell and notification.

    An alarm of high priority calls once each time that it is raised. The caller rings.
    """

    def __init__(self) -> None:
        """Create a bell that has not rung for any alarm."""
        self._rung: set[tuple[str, float]] = set()  # Name, and Unix time at which it was raised.

    def take_new(self, alarms: Iterable[Alarm]) -> list[Alarm]:
        """Return the alarms to ring for now, and remember that they have rung.

        These are unacknowledged, of high priority, and have not rung since they were raised. An
        alarm that has left the board is forgotten.

        Args:
            alarms: All alarms on the board.
        """
        on_board = {(alarm.name, alarm.since): alarm for alarm in alarms}
        self._rung &= on_board.keys()
        new = {
            key: alarm
            for key, alarm in on_board.items()
            if alarm.priority == Priority.HIGH
            and alarm.state == AlarmState.UNACKNOWLEDGED
            and key not in self._rung
        }
        self._rung |= new.keys()
        return list(new.values())
