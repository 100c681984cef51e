"""What a console showed, told from a recording's messages: the same telemetry, goals and alarms."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import floor
from typing import Any, NamedTuple, cast

from archo_tui.clock import Clock
from archo_tui.recording.console_recorder import JOURNAL, STATE
from archo_tui.recording.data import from_data
from archo_tui.recording.state import ConsoleState, RecordedAction, all_times
from archo_tui.replay.topics import Topics
from archo_tui.robot import message_classes, messages
from archo_tui.robot.consoles import author
from archo_tui.robot.events import EventLog
from archo_tui.robot.followed import said_by
from archo_tui.robot.graph import is_hidden
from archo_tui.robot.period import Pace
from archo_tui.robot.state import (
    OWN_LEVELS,
    TOPIC,
    Event,
    Goal,
    Leaf,
    NodeState,
    Snapshot,
    level_word,
    logger_node,
)
from archo_tui.robot.telemetry import Kept as Readings
from archo_tui.robot.telemetry import News, Telemetry
from archo_tui.robot.text import safe
from archo_tui.robot_file.model import GoalKind, RobotFile
from archo_tui.station.alarms import Alarm, AlarmBoard, conditions

ROSOUT = "/rosout"
_LATEST = 1e11  # Unix time that has a date
LONGEST = 3600  # s without a message in which is looked for alarms


class At(Clock):
    """The time of a recording: Unix time, for ages as well."""

    time = 0.0

    def monotonic(self) -> float:
        return self.time

    def now(self) -> float:
        return self.time


class Kept(NamedTuple):
    """All of a story at one moment."""

    readings: Readings
    said: str  # the JSON of the state: read, it takes many times as much memory
    goal: Goal | None
    log: EventLog
    paces: Mapping[str, Pace]
    nodes: Mapping[str, tuple[float | None, Pace | None]]
    board: AlarmBoard
    looked: float


class Story:
    """`apply` takes each message in turn; `snapshot` and `alarms` are what was shown then."""

    def __init__(self, file: RobotFile, types: Mapping[str, str], namespace: str) -> None:
        """`types` of the recording's topics, by their full names."""
        self._file, self._clock = file, At()
        self._topics = Topics(types, namespace)
        node = cast("Any", self._topics)
        self._telemetry = Telemetry(node, file, self._clock, self._on_reading, lambda _: None)
        self._telemetry.look()
        self._feedback = {
            self._topics.resolve_topic_name(f"{kind.action}/_action/feedback"): kind
            for kind in file.goals
        }
        self._kinds = {(kind.id, kind.action): kind for kind in file.goals}
        self._forms = {kind.id: _form(kind) for kind in file.goals}
        heard = {name for name in file.topics if self._topics.resolve_topic_name(name) in types}
        actions = {kind.action: "not recorded" for kind in file.goals}
        offered = frozenset(heard | {*actions, *file.services})
        self._unsaid = ConsoleState(namespace=namespace, offered=offered, faults=actions)
        self.state, self._said = self._unsaid, ""  # and the JSON that it was read from
        self.goal: Goal | None = None
        self._log = EventLog()
        self._paces: dict[str, Pace] = {}  # of topics, by their full names
        # of nodes: when they were last heard, and how often what they publish
        self._nodes: dict[str, tuple[float | None, Pace | None]] = {}
        self._board, self._looked = AlarmBoard(), 0.0  # and up to which second

    @property
    def is_ours(self) -> bool:
        """True once what no topic says is known."""
        return bool(self._said)

    @property
    def wanted(self) -> frozenset[str]:
        """The topics that are told from."""
        own = (ROSOUT, JOURNAL, STATE)
        return frozenset((*own, *self._topics.callbacks, *self._feedback))

    def kept(self) -> Kept:
        """The story so far, to be put back."""
        return Kept(
            self._telemetry.kept(),
            self._said,
            self.goal,
            self._log.copy(),
            dict(self._paces),
            dict(self._nodes),
            self._board.copy(),
            self._looked,
        )

    def put_back(self, kept: Kept) -> None:
        """As it was when that was kept, by this story or another one of the same recording."""
        self._telemetry.put_back(kept.readings)
        if kept.said != self._said:
            self._said = kept.said
            self.state = _read(kept.said) if kept.said else self._unsaid
        self.goal = kept.goal
        self._log, self._board = kept.log.copy(), kept.board.copy()
        self._paces, self._nodes = dict(kept.paces), dict(kept.nodes)
        self._looked = kept.looked

    def apply(self, time: float, topic: str, message: Any) -> None:
        """One more message came, at that Unix time. Raises anything for one that says nonsense."""
        self._pass_to(time)
        self._clock.time = time
        if topic == STATE:
            self._stand(_read(message.data))
            self._said = message.data
        elif topic == JOURNAL:
            self._note(message)
        elif topic == ROSOUT:
            self._on_log(message)
        elif topic in self._feedback:
            self._on_feedback(self._feedback[topic], message.feedback)
        elif topic in self._topics.callbacks:
            self._topics.callbacks[topic](message)

    def _pass_to(self, time: float) -> None:
        """Where nobody says which alarms there were, look for them each second."""
        if self.is_ours:
            return
        first = floor(self._looked) + 1 if self._looked else floor(time)
        seconds = range(first, floor(time) + 1)
        # a silence is seen in its first seconds, however long it is
        for second in (*seconds[:LONGEST], *seconds[LONGEST:][-1:]):
            self._looked = float(second)
            self._board.update(conditions(self.snapshot, self._looked), self._looked, self._looked)

    def _stand(self, state: ConsoleState) -> None:
        """So it is from now on, whatever was told before."""
        before = self.goal
        for alarm in state.alarms:
            assert alarm.priority  # KeyError: of no kind that there is
        if not all(time is None or 0 <= time < _LATEST for time in all_times(state)):
            raise ValueError("a time that has no date")
        self.state = state._replace(events=())
        self.goal = None if state.goal is None else self._known(state.goal)
        if before and self.goal and before.number == self.goal.number:
            newer = (before.heard or 0.0) > (self.goal.heard or 0.0)
            if newer and self.goal.is_running:  # a feedback that the state did not know of
                told = {name: getattr(before, name) for name in ("heard", "remaining", "feedback")}
                self.goal = self.goal._replace(**told)
        if state.events:
            self._log = EventLog.of(state.events)
        if not self._telemetry.charge:
            self._telemetry.charge = state.charge
        # of what was heard meanwhile a state may not know yet
        self._paces = {**state.paces, **self._paces}
        for node in state.nodes:
            if node.heard is not None and node.name not in self._nodes:
                pace = Pace(node.heard, 1 / node.rate) if node.rate else None
                self._nodes[node.name] = node.heard, pace

    def _known(self, goal: Goal) -> Goal:
        """With what the robot file says of its kind."""
        return goal._replace(kind=self.kind(goal.kind))

    def kind(self, called: RecordedAction | GoalKind) -> GoalKind:
        """The goal of the robot file that is called so, or one that is not in it."""
        known = self._kinds.get((called.id, called.action))
        return known or GoalKind(
            called.id, called.title, called.action, called.type, noun=called.noun
        )

    def _note(self, message: Any) -> None:
        """What a console did, or had to say."""
        level, source, text = level_word(message.level), message.name, message.msg
        own, _, rest = text.partition(": ")
        if own in OWN_LEVELS:
            level, text = own, rest
        # a command is copied, and pasted into a shell: no line end may stand in it
        self._log.add(Event(self._clock.time, level, source, text, safe(message.function)))

    def _on_log(self, message: Any) -> None:
        node = logger_node(message.name)
        below = f"{self.state.namespace.rstrip('/')}/"
        if author(node) or not node.startswith(below) or is_hidden(node):
            return  # of a console, which the journal has, or of another robot
        _, pace = self._nodes.get(node, (None, None))
        self._nodes[node] = self._clock.time, pace
        level = level_word(message.level)
        self._log.add(Event(self._clock.time, level, message.name, message.msg))

    def _on_reading(self, topic: str, _news: News) -> None:
        full, now = self._topics.resolve_topic_name(topic), self._clock.time
        pace = self._paces.get(full)
        self._paces[full] = Pace(now) if pace is None else pace.again(now)
        for resource in self.state.resources:
            if (resource.kind, resource.name) == (TOPIC, full) and resource.nodes:
                _, pace = self._nodes.get(resource.nodes[0], (None, None))
                beat = Pace(now) if pace is None else pace.again(now)
                self._nodes[resource.nodes[0]] = now, beat

    def _on_feedback(self, kind: GoalKind, feedback: Any) -> None:
        goal = self.goal
        if goal is None or not goal.is_running or goal.kind != kind or self.state.running > 1:
            return  # of several it is not known whose it is
        self.goal = goal._replace(
            heard=self._clock.time,
            started=goal.sent if goal.started is None else goal.started,
            **said_by(goal, feedback),
        )

    @property
    def readings(self) -> Snapshot:
        """The part of the snapshot that curves are drawn from, cheap enough for each message."""
        return Snapshot(
            battery=self._telemetry.battery, motion=self._telemetry.motion, goal=self.goal
        )

    @property
    def snapshot(self) -> Snapshot:
        """What was known then."""
        state, telemetry = self.state, self._telemetry
        return Snapshot(
            file=self._file,
            battery=telemetry.battery,
            motion=telemetry.motion,
            gauges=telemetry.gauges,
            goal=self.goal,
            running=state.running,
            history=tuple(map(self._known, state.history)),
            parameters=state.parameters,
            nodes=tuple(map(self._node, state.nodes)),
            offered=state.offered,
            events=self._log.all(),
            charge=telemetry.charge,
            open_stop=state.open_stop,
            outlived=state.outlived,
            namespace=state.namespace,
            faults={**telemetry.faults, **state.faults},
            publishers=state.publishers,
            twice=state.twice,
            several=state.several,
            has_clock=state.has_clock,
            elsewhere=state.elsewhere,
            consoles=state.consoles,
            forms=self._forms,
            actions=state.actions,
            services=state.services,
            resources=state.resources,
            paces=dict(self._paces),
        )

    def _node(self, node: NodeState) -> NodeState:
        heard, pace = self._nodes.get(node.name, (None, None))
        return node._replace(heard=heard, rate=None if pace is None else pace.rate)

    def alarms(self, snapshot: Snapshot, now: float) -> tuple[Alarm, ...]:
        """Those that were shown, with what they said at that Unix time."""
        found = conditions(snapshot, now, self.state.hosted)
        self._pass_to(now)
        alarms = self.state.alarms if self.is_ours else self._board.all()
        return tuple(
            alarm if alarm.is_over else alarm._replace(text=found.get(alarm.name, alarm.text))
            for alarm in alarms
        )


def _read(said: str) -> ConsoleState:
    """Raises TypeError, ValueError or KeyError for nonsense."""
    return from_data(ConsoleState, json.loads(said))  # type: ignore[no-any-return]


def _form(kind: GoalKind) -> tuple[Leaf, ...]:
    found = message_classes.load(kind.type)
    return () if found is None else tuple(messages.leaves(found.Goal()))
