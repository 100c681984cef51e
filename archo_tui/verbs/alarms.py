"""The verbs for alarms: list, acknowledge, shelve."""

from __future__ import annotations

from archo_tui.base.errors import ArchoError
from archo_tui.robot.outcome import Code, Outcome, Report
from archo_tui.station.alarms import SHELF_TIME, Alarm, AlarmState
from archo_tui.station.conditions import Priority
from archo_tui.station.station import Station
from archo_tui.text.alarm import no_alarms_text, timeline
from archo_tui.text.state import no_data_text
from archo_tui.verbs.as_json import state
from archo_tui.verbs.verb import Argument, Values, Verb

ALL = "all"
_FOR = f"shelved for {SHELF_TIME / 60:.0f} min"


class Alarms(Verb):
    id, title, tells = "alarms", "Alarms", True
    help = "List the alarms"

    def is_found(self, station: Station, values: Values) -> bool:
        """Return True once there is one: most begin some seconds after their cause."""
        station.refresh()
        return bool(station.view.alarms)

    async def run(self, station: Station, values: Values) -> Outcome:
        station.refresh()
        lines = [f"{alarm.name}, {timeline(alarm)}: {alarm.text}" for alarm in station.view.alarms]
        text = "\n".join(lines) or no_alarms_text(station.robot.snapshot)
        alarms = state(station)["alarms"]
        # None for no alarms before any data has come.
        is_unknown = not alarms and no_data_text(station.robot.snapshot)
        return Report.of(text, None if is_unknown else alarms)


class _AlarmVerb(Verb):
    """The base of the verbs that take the name of one alarm, or the beginning of its name."""

    def find_alarm(self, station: Station, name: str) -> Alarm:
        """Return the alarm with a typed name, or the only one that begins so; raise ArchoError."""
        fitting = _matching_alarms(station, name)
        if len(fitting) == 1:
            return fitting[0]
        names = ", ".join(alarm.name for alarm in fitting or station.view.alarms)
        if fitting:
            raise ArchoError(f"several alarms begin with {name!r}: {names}")
        raise ArchoError(f"no alarm begins with {name!r}; there is: {names}")


def _matching_alarms(station: Station, name: str) -> list[Alarm]:
    """Return the alarms with a typed name, in any case, else all whose names begin with it."""
    alarms, wanted = station.view.alarms, _normalized(name)
    exact = [alarm for alarm in alarms if alarm.name.lower() == name.lower()]
    exact = exact or [alarm for alarm in alarms if _normalized(alarm.name) == wanted]
    return exact or [alarm for alarm in alarms if _normalized(alarm.name).startswith(wanted)]


def _normalized(name: str) -> str:
    return " ".join(name.replace('"', "").lower().split())


class Acknowledge(_AlarmVerb):
    """The verb `ack`: acknowledge the named alarm, all for `all`, or without a name the first."""

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
    """The verb `shelve`: silence an alarm for a while, or end that; HIGH ones need a reason."""

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
        """Split typed words into an alarm, of as many words as fit exactly one, and the reason."""
        words = reason.split()
        for count in range(len(words), 0, -1):
            fitting = _matching_alarms(station, " ".join((name, *words[:count])))
            if len(fitting) == 1:
                return fitting[0], " ".join(words[count:])
        return self.find_alarm(station, name), reason
