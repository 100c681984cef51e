"""The verbs for the commands of the robot file, and for any service."""

from __future__ import annotations

from collections.abc import Mapping

from archo_tui.robot.outcome import CALL_WAIT, Outcome
from archo_tui.robot_file.model import CommandService, Scalar
from archo_tui.station.station import Station
from archo_tui.verbs.base import Argument, Question, Values, Verb
from archo_tui.verbs.graph_names import fields_of, full_name, is_elsewhere, is_known, type_of
from archo_tui.words.goal import activity

_CHANGE_STATE = "lifecycle_msgs/srv/ChangeState"
TIMEOUT = "--timeout"  # The key of `call`'s longest wait in s, if more than the default.
ASKS = {"never": "", "moving": "; asks first while a goal runs", "always": "; asks first"}


class Give(Verb):
    """The verb for a command of the robot file; a toggle has two, one for each way."""

    acts = True

    def __init__(self, given: CommandService, on: bool = True) -> None:
        self.given, self.is_on = given, on
        self.id = given.id if on else given.off_word
        self.title = given.title if on else given.off or f"{given.title} off"
        if given.toggle:  # The file's help is about a key that does both.
            undone = f"switch {given.title.lower()} off"
            if given.off and ", or " in given.help:
                undone = given.help.rpartition(", or ")[2]
            undone = undone[:1].upper() + undone[1:]
            does = given.title if on else undone
        else:
            does = given.help or given.title
        self.help = f"{does}{ASKS[given.ask]}"
        self.service, self.moves = given.service, given.moves
        self.request: Mapping[str, Scalar] = dict.fromkeys(given.toggle, on)
        self.may_ask = given.ask != "never"

    def question(self, station: Station, values: Values) -> Question | None:
        goal, given = station.running_goal, self.given
        if given.ask == "never" or (given.ask == "moving" and goal is None):
            return None
        now = f"The robot is {activity(goal)}. " if goal is not None else ""
        title = self.title[0].upper() + self.title[1:]
        return Question(title, f"{now}{title} now?", "Leave it", title.split()[0])

    async def run(self, station: Station, values: Values) -> Outcome:
        return await station.robot.command(self.given, self.is_on)


class Call(Verb):
    """The verb `call`: call any service on the graph; its outcome is the response."""

    id, title = "call", "Call a service"
    help = "Call any service on the graph"
    arguments = (Argument("service"), Argument("field=value", many=True, optional=True))
    acts = moves = tells = True

    def disabled_reason(self, station: Station) -> str:
        return "" if station.robot.snapshot.services else "no service is on the graph"

    def is_ready(self, station: Station, values: Values) -> bool:
        snapshot = station.robot.snapshot
        name = full_name(snapshot, values["service"], snapshot.services)
        return is_known(station, name, snapshot.services)

    def tells_with(self, values: Values) -> bool:
        """Return False, since an event shows the response on the screen and in `--plain`.

        A shell goes by `tells`, which is True.
        """
        return False

    async def prepare(self, station: Station, values: Values) -> Values:
        snapshot, found = station.robot.snapshot, station.robot.snapshot.services
        name = full_name(snapshot, values["service"], found)
        if is_elsewhere(snapshot, name):
            found = {**found, name: await station.robot.types_anywhere(name)}
        kind = type_of("service", name, found)
        refuse_transition(name, kind)
        fields = await fields_of(station, name, kind, values["field=value"])
        return {**values, "service": name, "type": kind, "fields": fields}

    async def run(self, station: Station, values: Values) -> Outcome:
        wait = max(values.get(TIMEOUT) or 0.0, CALL_WAIT)
        return await station.robot.call(values["service"], values["type"], values["fields"], wait)


def refuse_transition(service: str, type_name: str) -> None:
    """Raise ValueError for a `change_state` service, since only `lifecycle` asks before."""
    if type_name == _CHANGE_STATE:
        node = service.rpartition("/")[0]
        raise ValueError(f"{service} is a part of the lifecycle of {node}: type lifecycle {node}")
