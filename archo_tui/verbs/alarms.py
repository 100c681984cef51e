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
        """Refresh the station, and return True if there is an alarm.

        While there is none, frontends wait for one until ROBOT_TIMEOUT seconds after the start.
        """
        station.refresh()
        return bool(station.view.alarms)

    async def run(self, station: Station, values: Values) -> Outcome:
        station.refresh()
        lines = [f"{alarm.name}, {timeline(alarm)}: {alarm.text}" for alarm in station.view.alarms]
        return Outcome(Code.DONE, "\n".join(lines) or no_alarms_text(station.robot.snapshot))

    def data(self, station: Station, values: Values) -> Any:
        """Return the alarms as in `status --json`; None if there are none and no data has come yet.

        The data is the robot's: battery, motion, gauges.
        """
        alarms = state(station)["alarms"]
        return None if not alarms and no_data_text(station.robot.snapshot) else alarms


class _AlarmVerb(Verb):
    """The base of the verbs that take the name of one alarm, or the beginning of its name."""

    def find_alarm(self, station: Station, name: str) -> Alarm:
        """Return the alarm with a typed name, or the only one whose name begins with it.

        Case, double quotes and repeated spaces make no difference.

        Raises:
            ArchoError: No alarm fits, or several do; the message lists the alarms.
        """
        fitting = _matching_alarms(station, name)
        if len(fitting) == 1:
            return fitting[0]
        names = ", ".join(alarm.name for alarm in fitting or station.view.alarms)
        if fitting:
            raise ArchoError(f"several alarms begin with {name!r}: {names}")
        raise ArchoError(f"no alarm begins with {name!r}; there is: {names}")


def _matching_alarms(station: Station, name: str) -> list[Alarm]:
    """Return the alarms with a typed name, else all whose names begin with it; [] if none does.

    Case, double quotes and repeated spaces make no difference.
    """
    alarms, wanted = station.view.alarms, _normalized(name)
    exact = [alarm for alarm in alarms if alarm.name.lower() == name.lower()]
    exact = exact or [alarm for alarm in alarms if _normalized(alarm.name) == wanted]
    return exact or [alarm for alarm in alarms if _normalized(alarm.name).startswith(wanted)]


def _normalized(name: str) -> str:
    """Return a name in lower case, without double quotes, and with single spaces, to compare it."""
    return " ".join(name.replace('"', "").lower().split())


class Acknowledge(_AlarmVerb):
    """The verb `ack`: acknowledge the named alarm, all for `all`, or the first of the list.

    The first is meant if no name is typed. The journal gets what was acknowledged. The verb is
    disabled while every alarm is acknowledged.
    """

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
    """The verb `shelve`: silence an alarm for SHELF_TIME, or end that early if it is shelved.

    The reason goes into the journal; without one, an alarm of HIGH priority is not shelved, and the
    outcome is MISUSE.
    """

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
        """Split typed words into an alarm and the reason for shelving it.

        As many words belong to the alarm's name as still fit exactly one alarm.

        Args:
            station: The station that has the alarms.
            name: The first word.
            reason: The further words.

        Raises:
            ArchoError: Neither the first word, nor it with further ones, fits exactly one alarm.
        """
        words = reason.split()
        for count in range(len(words), 0, -1):
            fitting = _matching_alarms(station, " ".join((name, *words[:count])))
            if len(fitting) == 1:
                return fitting[0], " ".join(words[count:])
        return self.find_alarm(station, name), reason
