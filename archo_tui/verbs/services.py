"""The verbs for the commands of the robot file, and for any service.

`call` on a service of the robot file runs the verb that stands for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from archo_tui.robot.messages.typed import as_typed, typed_request
from archo_tui.robot.outcome import CALL_WAIT, Outcome
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file.model import CommandService, RobotFile, Scalar
from archo_tui.station.station import Station
from archo_tui.text.goal import activity
from archo_tui.verbs.goals import Go, kind_of
from archo_tui.verbs.names import fields_of, full_name, is_elsewhere, type_of
from archo_tui.verbs.stop import ReleaseStop, StopNow
from archo_tui.verbs.verb import TIMEOUT, YES, Argument, Forms, Question, Values, Verb, named

_ACTION_PART = "/_action/"  # Between an action's name and those of its services.
_CHANGE_STATE = "lifecycle_msgs/srv/ChangeState"
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
        self.service = given.service
        self.request: Mapping[str, Scalar] = dict.fromkeys(given.toggle, on)
        self.may_ask = given.ask != "never"

    @classmethod
    def of_robot(cls, robot: RobotFile, _forms: Forms) -> Iterator[Verb]:
        for command in robot.commands:
            yield cls(command)
            if command.toggle:
                yield cls(command, on=False)

    def question(self, station: Station, values: Values) -> Question | None:
        goal, given = station.running_goal, self.given
        if given.ask == "never" or (given.ask == "moving" and goal is None):
            return None
        now = f"The robot is {activity(goal)}. " if goal is not None else ""
        title = self.title[0].upper() + self.title[1:]
        return Question(title, f"{now}{title} now?", "Leave it", title.split()[0], goal)

    async def run(self, station: Station, values: Values) -> Outcome:
        return await station.robot.command(self.given, self.is_on)


class Call(Verb):
    """The verb `call`: call any service on the graph; its outcome is the response."""

    id, title = "call", "Call a service"
    help = "Call any service on the graph"
    arguments = (
        Argument("service", completer=lambda station, _: station.robot.snapshot.services),
        Argument("field=value", many=True, optional=True),
    )
    acts = tells = True

    def disabled_reason(self, station: Station) -> str:
        return "" if station.robot.snapshot.services else "no service is on the graph"

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


Called = StopNow | ReleaseStop | Give  # Verbs that call a service of the robot file.


def choose_verb(
    verbs: Mapping[str, Verb], station: Station, word: str, words: Sequence[str]
) -> tuple[Verb, list[str]]:
    """Return the verb for a typed word, and the words that are left for that verb.

    `call SERVICE` on a service of the robot file gives the verb that calls this service, so that it
    asks, refuses and checks as that verb does. Raises ValueError if no single verb is meant.
    """
    verb, rest = named(verbs, word), list(words)
    without_yes = [each for each in rest if each != YES]
    if not isinstance(verb, Call) or not without_yes:
        return verb, rest
    service, *fields = without_yes
    snapshot = station.robot.snapshot
    own = verbs_by_service(verbs, snapshot)
    service = full_name(snapshot, service, {*snapshot.services, *own})
    _refuse_part_of_action(verbs, snapshot, service)
    if service not in own or fields == ["--help"]:  # `call` itself refuses it, and calls nothing.
        return verb, rest
    meant = _pick(own[service], service, fields)
    return meant, [YES] if meant.may_ask and YES in rest else []


def verbs_by_service(verbs: Mapping[str, Verb], snapshot: Snapshot) -> dict[str, list[Called]]:
    """Return `stop`, `release` and the robot file's commands by their service's full name."""
    found: dict[str, list[Called]] = {}
    for verb in verbs.values():
        if isinstance(verb, (StopNow, ReleaseStop, Give)) and verb.service:
            found.setdefault(snapshot.full(verb.service), []).append(verb)
    return found


def _pick(found: Sequence[Called], service: str, fields: Sequence[str]) -> Called:
    """Return the verb whose request has the fields that were typed; ValueError unless one has.

    A STOP without fields is returned whatever was typed; one with fields comes before other verbs
    with the same request.
    """
    stop = next((verb for verb in found if isinstance(verb, StopNow)), None)
    if stop is not None and not stop.request:  # Whatever fields were typed.
        return stop
    asked = next((verb.request for verb in found if verb.request), {})
    if not asked and any(field != "{}" for field in fields):
        raise ValueError(f"{service} takes no field, not {' '.join(fields)}")
    given = typed_request(service, fields, asked)
    meant = [verb for verb in found if verb.request == given]
    if stop is not None and stop in meant:
        return stop
    if len(meant) > 1:
        raise ValueError(
            f"{service} is called by several: type {' or '.join(verb.id for verb in meant)}"
        )
    if not meant:
        ways = " or ".join(f"{as_typed(verb.request)} ({verb.id})" for verb in found)
        raise ValueError(f"{service} needs {ways}")
    return meant[0]


def _refuse_part_of_action(verbs: Mapping[str, Verb], snapshot: Snapshot, service: str) -> None:
    """Raise ValueError for a service by which an action takes or cancels goals."""
    action, _, part = service.partition(_ACTION_PART)
    if part == "cancel_goal":
        raise ValueError(f"{service} is a part of the action {action}: type cancel")
    if part == "send_goal":
        kind = kind_of(snapshot, action)
        goals = [verb for verb in verbs.values() if isinstance(verb, Go) and verb.kind == kind]
        ways = goals[0].id if goals else f"send_goal {action}"
        raise ValueError(f"{service} is a part of the action {action}: type {ways}")
