"""The verbs for alarms: list, acknowledge, shelve."""

from __future__ import annotations

from typing import Any

from archo_tui.errors import ArchoError
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.station.alarm_board import SHELF_TIME
from archo_tui.station.alarms import Alarm, AlarmState, Priority
from archo_tui.station.station import Station
from archo_tui.verbs.as_data import state
from archo_tui.verbs.base import Argument, Values, Verb
from archo_tui.words.alarm import no_alarms_text, timeline
from archo_tui.words.state import no_data_text

ALL = "all"
_FOR = f"shelved for {SHELF_TIME / 60:.0f} min"


class Alarms(Verb):
    id, title, tells = "alarms", "Alarms", True
    help = "List the alarms"

    def is_ready(self, station: Station, values: Values) -> bool:
        """Return True if there is an alarm: one may still appear until ROBOT_TIMEOUT is over."""
        station.refresh()
        return bool(station.view.alarms)

    async def run(self, station: Station, values: Values) -> Outcome:
        station.refresh()
        lines = [f"{alarm.name}, {timeline(alarm)}: {alarm.text}" for alarm in station.view.alarms]
        return Outcome(Code.DONE, "\n".join(lines) or no_alarms_text(station.robot.snapshot))

    def data(self, station: Station, values: Values) -> Any:
        """Return the alarms; None instead of an empty list while nothing is known of the robot."""
        alarms = state(station)["alarms"]
        return None if not alarms and no_data_text(station.robot.snapshot) else alarms


class _AlarmVerb(Verb):
    """A verb for one alarm, which is typed as its name or the beginning of its name."""

    def find_alarm(self, station: Station, name: str) -> Alarm:
        """Return the alarm that a name means.

        Raises:
            ArchoError: No alarm, or more than one, has a name that begins so.
        """
        fitting = _matching_alarms(station, name)
        if len(fitting) == 1:
            return fitting[0]
        names = ", ".join(alarm.name for alarm in fitting or station.view.alarms)
        if fitting:
            raise ArchoError(f"several alarms begin with {name!r}: {names}")
        raise ArchoError(f"no alarm begins with {name!r}; there is: {names}")


def _matching_alarms(station: Station, name: str) -> list[Alarm]:
    """Return the alarm of that name, or else all whose names begin with it."""
    alarms, wanted = station.view.alarms, _normalized(name)
    exact = [alarm for alarm in alarms if alarm.name.lower() == name.lower()]
    exact = exact or [alarm for alarm in alarms if _normalized(alarm.name) == wanted]
    return exact or [alarm for alarm in alarms if _normalized(alarm.name).startswith(wanted)]


def _normalized(name: str) -> str:
    """Return a name in lower case, without quotes, and with single spaces, for comparison."""
    return " ".join(name.replace('"', "").lower().split())


class Acknowledge(_AlarmVerb):
    """The verb `ack`: without a name it means the first alarm of the list, not all."""

    id, title, tells = "ack", "Acknowledge", True
    help = "Acknowledge the first alarm, the named one, or all"
    arguments = (Argument("alarm", rest=True, optional=True),)

    def disabled_reason(self, station: Station) -> str:
        unseen = any(not alarm.acknowledged for alarm in station.view.alarms)
        return "" if unseen else "no alarm to acknowledge"

    async def run(self, station: Station, values: Values) -> Outcome:
        name, alarms = values.get("alarm", ""), station.view.alarms
        if name and name != ALL:
            alarms = (self.find_alarm(station, name),)
        elif not name:
            alarms = alarms[:1]
        station.acknowledge(alarms)
        return Outcome(Code.DONE, f"acknowledged: {', '.join(alarm.name for alarm in alarms)}")


class Shelve(_AlarmVerb):
    """The verb `shelve`, which takes an alarm that is shelved already off the shelf."""

    id, title, tells = "shelve", "Shelve", True
    help = f"Silence an alarm for {SHELF_TIME / 60:.0f} min, with a reason; or end that early"
    arguments = (Argument("alarm"), Argument("reason", rest=True, optional=True))

    def disabled_reason(self, station: Station) -> str:
        return "" if station.view.alarms else "no alarm to shelve"

    async def run(self, station: Station, values: Values) -> Outcome:
        alarm, reason = self._split(station, values["alarm"], values.get("reason", ""))
        shelved = alarm.state == AlarmState.SHELVED
        if alarm.priority == Priority.HIGH and not shelved and not reason.strip():
            return Outcome(Code.MISUSE, "type a reason: it goes into the journal")
        station.shelve(alarm, reason.strip())
        return Outcome(Code.DONE, f"{alarm.name}: {_FOR if not shelved else 'no longer shelved'}")

    def _split(self, station: Station, name: str, reason: str) -> tuple[Alarm, str]:
        """Split words into an alarm and a reason.

        Names have several words: as many as begin an alarm's name belong to it.
        """
        words = reason.split()
        for count in range(len(words), 0, -1):
            fitting = _matching_alarms(station, " ".join((name, *words[:count])))
            if len(fitting) == 1:
                return fitting[0], " ".join(words[count:])
        return self.find_alarm(station, name), reason
