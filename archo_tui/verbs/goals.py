"""The verbs for goals: send those of the robot file or of any action, cancel, continue, skip."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.robot.goals.queue import QueuedGoal
from archo_tui.robot.messages.typed import (
    check_ranges,
    is_number,
    parse_all,
    texts_by_path,
    typed_text,
)
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot_file import check
from archo_tui.robot_file.model import (
    FormField,
    GoalKind,
    ParameterRef,
    RobotFile,
    is_place_name,
)
from archo_tui.ros.names import base_name
from archo_tui.station.alarms import Alarm
from archo_tui.station.conditions import is_battery_low
from archo_tui.station.station import Station
from archo_tui.verbs.names import fields_of, full_name, is_elsewhere, type_of
from archo_tui.verbs.verb import GOAL_ENDED, Argument, Forms, Question, Values, Verb

# The keys of these verbs' values: the kind; a mapping of values by dotted path for each goal; and
# the goal that ran at the time.
KIND, GOALS, RUNNING = "kind", "goals", "running"
_MOST_NUMBERS = 1000  # Numbers of a range, such as shelves, that are offered for completion.


def low_battery_question(station: Station, does: str) -> Question | None:
    """Return the question that comes before a goal while the battery is low; None if none does.

    It is asked while the robot charges, too, and no more once the alarm was acknowledged.
    """
    snapshot, alarms = station.robot.snapshot, _battery_alarms(station)
    if any(alarm.acknowledged for alarm in alarms):
        return None
    if not (alarms or is_battery_low(snapshot)):  # An alarm may stand as last known.
        return None
    battery = snapshot.battery
    charge = "" if battery.percentage is None else f", {battery.percentage:.1f} %"
    charging = ", charging" if battery.charging else ""
    text = f"The battery is low{charge}{charging}. {does} all the same?"
    return Question("Low battery", text, "Leave it", does)


def accept_low_battery(station: Station) -> None:
    """Acknowledge the alarm that was asked about, so that it does not hold the goals behind it."""
    if low_battery_question(station, "") is not None:
        station.acknowledge(_battery_alarms(station))


def _battery_alarms(station: Station) -> list[Alarm]:
    """Return the active alarms of the battery, which hold goals until they are acknowledged."""
    alarms = station.view.alarms
    return [alarm for alarm in alarms if alarm.holds_until_acknowledged and not alarm.is_over]


class _Named(NamedTuple):
    """A word in the place of a goal's values, which may be a place."""

    word: str
    mistake: str  # Why it is no value.


class GoalVerb(Verb):
    """The base of the verbs that send goals, which wait behind those that were sent before.

    The outcome is the robot's answer to the first one, or that it waits in the queue.
    """

    acts = has_goals = may_ask = True

    def question(self, station: Station, values: Values) -> Question | None:
        return low_battery_question(station, "Send")

    def run(self, station: Station, values: Values) -> Awaitable[Outcome]:
        accept_low_battery(station)
        return station.goals.drive(self.queued(values))

    def queued(self, values: Values) -> list[QueuedGoal]:
        """Return the goals that the prepared values mean."""
        raise NotImplementedError


class Go(GoalVerb):
    """The verb for goals of one kind, one or several in turn: `go 12 7`, `pose x=1.5 y=2`."""

    def __init__(self, kind: GoalKind, fields: Sequence[TypedField] | None, verb: str = "") -> None:
        """Create the verb; `fields` is None if the type is not installed."""
        self.kind, self._fields = kind, fields
        self.id = verb or kind.id
        self.title = self.help = kind.title
        self.service = kind.action
        several = fields is not None and len(fields) == 1 and is_number(fields[0])
        names = [kind.form.get(f.path, FormField()).label or f.path for f in fields or ()]
        self.arguments = tuple(Argument(name, several, completer=self._complete) for name in names)

    def _complete(self, station: Station, _: Sequence[str]) -> list[str]:
        """Return the numbers of a goal's only field, else the names of all, and the places."""
        found = [f"{argument.name.lower()}=" for argument in self.arguments]
        if self.arguments[0].many:
            given = self.kind.form.get((self._fields or ())[0].path, FormField())
            least, most = map(station.robot.snapshot.limit, (given.low, given.high))
            found = []
            if least is not None and most is not None and 0 <= least <= most < math.inf:
                numbers = range(math.ceil(least), math.floor(most) + 1)[:_MOST_NUMBERS]
                found = [*map(str, numbers)]
        return [*found, *station.places.of(self.kind)]

    @classmethod
    def of_robot(cls, robot: RobotFile, forms: Forms) -> Iterator[Go]:
        """Yield the verb of each goal of the robot file, of which the first is `go`."""
        for number, kind in enumerate(robot.goals):
            yield cls(kind, forms.get(kind.id), "" if number else "go")

    @property
    def usage(self) -> str:
        if len(self.arguments) == 1:
            return "N ..." if self.arguments[0].many else self.arguments[0].name.upper()
        return " ".join(f"{argument.name.lower()}=..." for argument in self.arguments)

    @property
    def how(self) -> str:
        """The way to type the verb, to be read aloud: `Type go and the shelf number.`."""
        names = [argument.name.lower() for argument in self.arguments]
        if not names:
            return f"Type {self.id}."
        if len(names) == 1:
            is_thing = names[0] == self.kind.noun and self.arguments[0].many
            return f"Type {self.id} and the {names[0]}{' number' if is_thing else ''}."
        listed = f"{', '.join(names[:-1])} and {names[-1]}"
        return f"Type {self.id}, then {listed}, each with an equals sign and its value."

    def values(self, words: Sequence[str]) -> Values:
        """Return the values of each goal by dotted path, as a list under GOALS.

        Where a goal is a single number, each word is a goal of its own (`go 3 12 7`), unless a word
        has a `=`.
        """
        if self._fields is None:
            raise ValueError(check.not_installed(self.kind.action, self.kind.type))
        several = any(argument.many for argument in self.arguments) and "=" not in "".join(words)
        rows = [[word] for word in words] if several and words else [list(words)]
        return {GOALS: [goal for row in rows for goal in self._goals(row)]}

    def _goals(self, row: Sequence[str]) -> Sequence[Mapping[str, Any] | _Named]:
        """Return the values that words give to one goal, or the words if they may name places."""
        fields, form = self._fields or (), self.kind.form
        try:
            return [parse_all(fields, form, texts_by_path(fields, form, row))]
        except ValueError as error:
            if row and all(map(is_place_name, row)):
                return [_Named(word, str(error)) for word in row]
            raise

    def _values_of(self, station: Station, goal: Mapping[str, Any] | _Named) -> Mapping[str, Any]:
        if not isinstance(goal, _Named):
            return goal
        if not station.places.of(self.kind):
            raise ValueError(goal.mistake)
        return self.parsed(station.places.find(self.kind, goal.word))

    def parsed(self, values: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return the values of a file, converted to their fields' types; ValueError."""
        texts = {path: typed_text(value) for path, value in values.items()}
        return parse_all(self._fields or (), self.kind.form, texts)

    def is_found(self, station: Station, values: Values) -> bool:
        """Return True if the nodes with its limits, if any, have reported their parameters."""
        snapshot = station.robot.snapshot
        limits = [limit for field in self.kind.form.values() for limit in (field.low, field.high)]
        nodes = {snapshot.full(limit.node) for limit in limits if isinstance(limit, ParameterRef)}
        return nodes <= {parameter.node for parameter in snapshot.parameters}

    async def prepare(self, station: Station, values: Values) -> Values:
        form = station.robot.snapshot.form(self.kind)
        if any(isinstance(goal, _Named) for goal in values[GOALS]):
            await in_daemon(station.places.read_again)
        goals = [self._values_of(station, goal) for goal in values[GOALS]]
        for goal in goals:
            check_ranges(self._fields or (), form, goal)
        return {**values, GOALS: goals}

    def queued(self, values: Values) -> list[QueuedGoal]:
        return [QueuedGoal(self.kind, given) for given in values[GOALS]]


class Cancel(Verb):
    id, title = "cancel", "Cancel"
    help = "Cancel the running goal, or every goal; the queue behind it is held; end pub, too"
    arguments = (Argument("--all", optional=True),)
    acts = may_ask = survives_stop = True

    def is_found(self, station: Station, values: Values) -> bool:
        """Return True once a goal runs, or enough of the graph is known to tell that none does."""
        snapshot, publishes = station.robot.snapshot, station.robot.publications.active
        found = snapshot.offered or snapshot.actions or publishes
        return station.running_goal is not None or bool(found)

    async def prepare(self, station: Station, values: Values) -> Values:
        return {**values, RUNNING: station.running_goal}

    def question(self, station: Station, values: Values) -> Question | None:
        goal = station.running_goal
        if "--all" in values:
            text = "Cancel every goal of the robot's actions, other clients' too?"
            return Question("Cancel every goal", text, "No", "Cancel all")
        if goal is None or goal.mine:
            return None
        text = "Another client sent this goal. Cancel it?"
        return Question("Cancel", text, "No", "Cancel it", goal)

    async def run(self, station: Station, values: Values) -> Outcome:
        ended = await station.robot.end_publications()
        running = values.get(RUNNING) or station.running_goal
        if ended and running is None and "--all" not in values:
            return Outcome(Code.DONE, f"ended: pub {ended}")
        staying = station.goals.staying
        outcome = await self._cancel(station, values)
        if not (outcome.ok and staying):
            return outcome
        return outcome._replace(text=f"{outcome.text}; held in the queue: {staying}")

    @staticmethod
    async def _cancel(station: Station, values: Values) -> Outcome:
        if "--all" in values:
            return await station.robot.cancel_all()
        goal, now = values[RUNNING], station.running_goal
        if goal is None or goal.mine:
            return await station.goals.cancel()
        if now is None or now.number != goal.number:  # The question may have waited for long.
            return Outcome(Code.REFUSED, GOAL_ENDED)
        return await station.goals.cancel(another=True)


class ContinueQueue(Verb):
    id, title = "continue", "Continue the queue"
    help = "Continue the held queue of goals"
    acts = may_ask = True

    def disabled_reason(self, station: Station) -> str:
        if station.is_releasing:
            return "the release has no answer yet"
        return "" if station.queue.hold_reason else "no queue is held"

    def is_answered(self, station: Station) -> bool:
        """Return False while a release has no answer, or a goal ends, which may hold the queue."""
        if station.is_releasing:
            return False
        goal = station.robot.snapshot.goal
        ends = goal is not None and (goal.phase == Phase.CANCELLING or not goal.is_running)
        return bool(station.queue.hold_reason) or not (station.queue.waiting and ends)

    def question(self, station: Station, values: Values) -> Question | None:
        return low_battery_question(station, "Continue")

    async def run(self, station: Station, values: Values) -> Outcome:
        accept_low_battery(station)
        return station.goals.resume()


class SkipGoal(Verb):
    id, title = "skip", "Skip a goal"
    help = "Skip the next goal of the queue"
    acts = survives_stop = True

    def disabled_reason(self, station: Station) -> str:
        return "" if station.queue.waiting else "no goal waits in the queue"

    async def run(self, station: Station, values: Values) -> Outcome:
        return station.goals.skip()


class SendGoal(GoalVerb):
    """The verb `send_goal`: send one goal to any action on the graph, also in another namespace.

    For an action of the robot file, its labels, fixed values and limits hold, and several goals can
    be given as to its own verb.
    """

    id, title = "send_goal", "Send a goal"
    help = "Send a goal to any action on the graph"
    arguments = (
        Argument("action", completer=lambda station, _: station.robot.snapshot.actions),
        Argument("field=value", many=True, optional=True),
    )

    def disabled_reason(self, station: Station) -> str:
        return "" if station.robot.snapshot.actions else "no action is on the graph"

    async def prepare(self, station: Station, values: Values) -> Values:
        snapshot, found = station.robot.snapshot, station.robot.snapshot.actions
        name = full_name(snapshot, values["action"], found)
        known = kind_of(snapshot, name)
        if known is not None:  # Use the robot file's labels and fixed values.
            go = Go(known, snapshot.forms.get(known.id))
            return {KIND: known, **await go.prepare(station, go.values(values["field=value"]))}
        if is_elsewhere(snapshot, name):
            found = {**found, name: await station.robot.types_anywhere(name, is_action=True)}
        type_name = type_of("action", name, found)
        fields = await fields_of(station, name, type_name, values["field=value"])
        return {KIND: any_kind(name, type_name), GOALS: [fields]}

    def queued(self, values: Values) -> list[QueuedGoal]:
        return [QueuedGoal(values[KIND], given) for given in values[GOALS]]


def any_kind(action: str, type_name: str) -> GoalKind:
    """Return the kind of a goal of an action that the robot file does not name."""
    return GoalKind(SendGoal.id, base_name(action), action, type_name)  # No file has that id.


def kind_of(snapshot: Snapshot, action: str) -> GoalKind | None:
    """Return the goal of the robot file for an action's full name; None if the file has none."""
    goals = snapshot.file.goals
    return next((kind for kind in goals if snapshot.full(kind.action) == action), None)
