"""The state of a recorded robot and console, rebuilt from messages one after the other."""

from __future__ import annotations

import json
from collections.abc import Mapping
from math import floor
from typing import Any, NamedTuple, cast

from archo_tui.clock import Clock
from archo_tui.recording.console_recorder import JOURNAL, STATE
from archo_tui.recording.data import from_data
from archo_tui.recording.state import ConsoleState, RecordedAction, all_times
from archo_tui.replay.topics import RecordedTopics
from archo_tui.robot.consoles import author
from archo_tui.robot.events import EventLog
from archo_tui.robot.goals.machine import feedback_changes
from archo_tui.robot.graph.graph import is_hidden
from archo_tui.robot.messages.text import flat_fields
from archo_tui.robot.messages.types import TypedField, load_class
from archo_tui.robot.period import MessageRate
from archo_tui.robot.readings.subscriptions import News
from archo_tui.robot.readings.telemetry import SavedReadings, Telemetry
from archo_tui.robot.state import (
    OWN_LEVELS,
    TOPIC,
    Event,
    Goal,
    NodeState,
    Snapshot,
    level_word,
    logger_node,
)
from archo_tui.robot_file.model import GoalKind, RobotFile
from archo_tui.safe_text import safe
from archo_tui.station.alarm_board import AlarmBoard
from archo_tui.station.alarms import Alarm, conditions
from archo_tui.station.conditions import Situation

ROSOUT = "/rosout"
_MAX_TIME = 1e11  # Unix time; a date much later cannot be shown.
MAX_SILENCE = 3600  # Seconds without a message in which alarms are evaluated.


class RecordingClock(Clock):
    """A clock that stands at `time`, the Unix time of the last message.

    `monotonic` returns the same as `now`.
    """

    time = 0.0

    def monotonic(self) -> float:
        return self.time

    def now(self) -> float:
        return self.time


class Checkpoint(NamedTuple):
    """A copy of everything that a ReplayState needs to continue from a moment.

    Attributes:
        state_json: The console state as JSON, which takes far less memory than the parsed one; ""
            if none was applied.
        nodes: For each node, when it was last heard (Unix time), and the period of its messages.
        evaluated_until: Unix time of the last evaluation of alarms.
    """

    readings: SavedReadings
    state_json: str
    goal: Goal | None
    log: EventLog
    message_rates: Mapping[str, MessageRate]
    nodes: Mapping[str, tuple[float | None, MessageRate | None]]
    board: AlarmBoard
    evaluated_until: float


class ReplayState:
    """The state of robot and console after the messages applied so far.

    `snapshot` and `alarms` show it; `checkpoint` and `restore` move it to another moment.

    Attributes:
        console: The last recorded state of the console, without its events.
        goal: The goal as the console state and later feedback tell it; None if there is none.
    """

    def __init__(self, file: RobotFile, types: Mapping[str, str], namespace: str) -> None:
        """Create the state before the first message.

        Args:
            file: The robot.
            types: The type of each topic of the recording, by full names.
            namespace: The robot's namespace.
        """
        self._file, self._clock = file, RecordingClock()
        self._topics = RecordedTopics(types, namespace)
        node = cast("Any", self._topics)
        self._telemetry = Telemetry(node, file, self._clock, self._on_reading, lambda _: None)
        self._telemetry.resubscribe()
        self._feedback = {
            self._topics.resolve_topic_name(f"{kind.action}/_action/feedback"): kind
            for kind in file.goals
        }
        self._kinds = {(kind.id, kind.action): kind for kind in file.goals}
        self._forms = {kind.id: _form_fields(kind) for kind in file.goals}
        heard = {name for name in file.topics if self._topics.resolve_topic_name(name) in types}
        actions = {kind.action: "not recorded" for kind in file.goals}
        offered = frozenset(heard | {*actions, *file.services})
        self._initial = ConsoleState(namespace=namespace, offered=offered, faults=actions)
        # The state, and the JSON it was parsed from.
        self.console, self._state_json = self._initial, ""
        self.goal: Goal | None = None
        self._log = EventLog()
        self._message_rates: dict[str, MessageRate] = {}  # Of each topic, by its full name.
        # Of each node: when it was last heard, and the period of its messages.
        self._nodes: dict[str, tuple[float | None, MessageRate | None]] = {}
        self._board, self._evaluated_until = AlarmBoard(), 0.0

    @property
    def has_console_state(self) -> bool:
        """Return True if a console's own state was applied; a bag of another tool has none."""
        return bool(self._state_json)

    @property
    def topics(self) -> frozenset[str]:
        """Return the full names of the topics that `apply` uses; it ignores messages of others."""
        own = (ROSOUT, JOURNAL, STATE)
        return frozenset((*own, *self._topics.callbacks, *self._feedback))

    def checkpoint(self) -> Checkpoint:
        """Return a copy of this state, for `restore`."""
        return Checkpoint(
            self._telemetry.saved(),
            self._state_json,
            self.goal,
            self._log.copy(),
            dict(self._message_rates),
            dict(self._nodes),
            self._board.copy(),
            self._evaluated_until,
        )

    def restore(self, checkpoint: Checkpoint) -> None:
        """Replace this state with a checkpoint's.

        It may be a checkpoint of another ReplayState of the same recording.
        """
        self._telemetry.restore(checkpoint.readings)
        if checkpoint.state_json != self._state_json:
            self._state_json = checkpoint.state_json
            self.console = (
                _parse_state(checkpoint.state_json) if checkpoint.state_json else self._initial
            )
        self.goal = checkpoint.goal
        self._log, self._board = checkpoint.log.copy(), checkpoint.board.copy()
        self._message_rates, self._nodes = dict(checkpoint.message_rates), dict(checkpoint.nodes)
        self._evaluated_until = checkpoint.evaluated_until

    def apply(self, time: float, topic: str, message: Any) -> None:
        """Apply the next message; one of a topic that is not in `topics` only moves the time.

        If no console state was applied yet, the alarms of each second up to the message's time are
        evaluated first.

        Args:
            time: Its Unix time, in s; not before that of the last message.
            topic: Its full topic name.
            message: The message; a hostile one may raise any exception.
        """
        self._evaluate_alarms_until(time)
        self._clock.time = time
        if topic == STATE:
            self._apply_state(_parse_state(message.data))
            self._state_json = message.data
        elif topic == JOURNAL:
            self._on_journal(message)
        elif topic == ROSOUT:
            self._on_log(message)
        elif topic in self._feedback:
            self._on_feedback(self._feedback[topic], message.feedback)
        elif topic in self._topics.callbacks:
            self._topics.callbacks[topic](message)

    def _evaluate_alarms_until(self, time: float) -> None:
        """Evaluate the alarms of each second up to a Unix time, unless a console state was applied.

        Of a longer silence, only the first MAX_SILENCE seconds and the last one are evaluated.
        """
        if self.has_console_state:
            return
        first = floor(self._evaluated_until) + 1 if self._evaluated_until else floor(time)
        seconds = range(first, floor(time) + 1)
        # A silence raises its alarms in the first seconds, however long it is.
        for second in (*seconds[:MAX_SILENCE], *seconds[MAX_SILENCE:][-1:]):
            self._evaluated_until = float(second)
            self._board.update(
                conditions(Situation(self.snapshot, self._evaluated_until)),
                self._evaluated_until,
                self._evaluated_until,
            )

    def _apply_state(self, state: ConsoleState) -> None:
        """Replace the console's state, keeping what messages have told since it was made.

        If the state has events, they replace the log.

        Raises:
            KeyError: It has an alarm of an unknown kind.
            ValueError: One of its times is out of range.
        """
        before = self.goal
        for alarm in state.alarms:
            assert alarm.priority  # Raises KeyError for an unknown kind of alarm.
        if not all(time is None or 0 <= time < _MAX_TIME for time in all_times(state)):
            raise ValueError("a time that has no date")
        self.console = state._replace(events=())
        self.goal = None if state.goal is None else self._with_file_kind(state.goal)
        if before and self.goal and before.number == self.goal.number:
            self.goal = self.goal._replace(way=before.way)
            newer = (before.heard or 0.0) > (self.goal.heard or 0.0)
            if newer and self.goal.is_running:  # A feedback came after the state was made.
                names = ("heard", "remaining", "feedback")
                received = {name: getattr(before, name) for name in names}
                self.goal = self.goal._replace(**received)
        if state.events:
            self._log = EventLog.of(state.events)
        if not self._telemetry.charge:
            self._telemetry.charge = state.charge
        # The state may be older than the messages received meanwhile.
        self._message_rates = {**state.paces, **self._message_rates}
        for node in state.nodes:
            if node.heard is not None and node.name not in self._nodes:
                rate = MessageRate(node.heard, 1 / node.rate) if node.rate else None
                self._nodes[node.name] = node.heard, rate

    def _with_file_kind(self, goal: Goal) -> Goal:
        """Return the goal with what `goal_kind` returns for its kind."""
        return goal._replace(kind=self.goal_kind(goal.kind))

    def goal_kind(self, recorded: RecordedAction | GoalKind) -> GoalKind:
        """Return the robot file's goal of the same id and action, else one made of `recorded`."""
        known = self._kinds.get((recorded.id, recorded.action))
        return known or GoalKind(
            recorded.id, recorded.title, recorded.action, recorded.type, noun=recorded.noun
        )

    def _on_journal(self, message: Any) -> None:
        """Add to the log the event that a message of the journal's topic records."""
        level, source, text = level_word(message.level), message.name, message.msg
        own, _, rest = text.partition(": ")
        if own in OWN_LEVELS:
            level, text = own, rest
        # A person may paste the command into a shell: it must not hold a line end.
        command, code = safe(message.function), safe(message.file)
        self._log.add(Event(self._clock.time, level, source, text, command, code=code))

    def _on_log(self, message: Any) -> None:
        node = logger_node(message.name)
        below = f"{self.console.namespace.rstrip('/')}/"
        if author(node) or not node.startswith(below) or is_hidden(node):
            return  # The journal has what consoles log; other robots do not matter here.
        _, rate = self._nodes.get(node, (None, None))
        self._nodes[node] = self._clock.time, rate
        level = level_word(message.level)
        self._log.add(Event(self._clock.time, level, message.name, message.msg))

    def _on_reading(self, topic: str, _news: News) -> None:
        full, now = self._topics.resolve_topic_name(topic), self._clock.time
        rate = self._message_rates.get(full)
        self._message_rates[full] = MessageRate(now) if rate is None else rate.with_message_at(now)
        for resource in self.console.resources:
            if (resource.kind, resource.name) == (TOPIC, full) and resource.nodes:
                _, rate = self._nodes.get(resource.nodes[0], (None, None))
                beat = MessageRate(now) if rate is None else rate.with_message_at(now)
                self._nodes[resource.nodes[0]] = now, beat

    def _on_feedback(self, kind: GoalKind, feedback: Any) -> None:
        goal = self.goal
        if goal is None or not goal.is_running or goal.kind != kind or self.console.running > 1:
            return  # With several goals running, a feedback cannot be attributed.
        self.goal = goal._replace(
            heard=self._clock.time,
            started=goal.sent if goal.started is None else goal.started,
            **feedback_changes(goal, feedback, self._clock.time),
        )

    @property
    def curve_snapshot(self) -> Snapshot:
        """Return a snapshot of battery, motion and goal only, which is cheap to make."""
        return Snapshot(
            battery=self._telemetry.battery, motion=self._telemetry.motion, goal=self.goal
        )

    @property
    def snapshot(self) -> Snapshot:
        """Return the state of the robot after the last applied message, as the console knew it."""
        state, telemetry = self.console, self._telemetry
        return Snapshot(
            file=self._file,
            battery=telemetry.battery,
            motion=telemetry.motion,
            pose=telemetry.pose,
            diagnostics=telemetry.diagnostics.all,
            gauges=telemetry.gauges,
            goal=self.goal,
            running=state.running,
            history=tuple(map(self._with_file_kind, state.history)),
            parameters=state.parameters,
            nodes=tuple(map(self._node, state.nodes)),
            offered=state.offered,
            events=self._log.all(),
            charge=telemetry.charge,
            open_stop=state.open_stop,
            still_running_after_stop=state.outlived,
            namespace=state.namespace,
            faults={**telemetry.faults, **state.faults},
            publishers=state.publishers,
            duplicate_nodes=state.twice,
            duplicate_servers=state.several,
            has_clock=state.has_clock,
            other_namespaces=state.elsewhere,
            consoles=state.consoles,
            forms=self._forms,
            actions=state.actions,
            services=state.services,
            resources=state.resources,
            message_rates=dict(self._message_rates),
        )

    def _node(self, node: NodeState) -> NodeState:
        heard, rate = self._nodes.get(node.name, (None, None))
        return node._replace(heard=heard, rate=None if rate is None else rate.hertz)

    def alarms(self, snapshot: Snapshot, now: float) -> tuple[Alarm, ...]:
        """Return the alarms at a Unix time; those that are not over have their text of that time.

        They are the alarms that the console recorded. If no console state was applied, they are
        evaluated up to `now`, which changes this state.

        Args:
            snapshot: The state's snapshot.
            now: Unix time in s.
        """
        found = conditions(Situation(snapshot, now, self.console.hosted))
        self._evaluate_alarms_until(now)
        alarms = self.console.alarms if self.has_console_state else self._board.all()
        return tuple(
            alarm if alarm.is_over else alarm._replace(text=found.get(alarm.name, alarm.text))
            for alarm in alarms
        )


def _parse_state(text: str) -> ConsoleState:
    """Return a console state; raise TypeError, ValueError or KeyError if the text is none."""
    return from_data(ConsoleState, json.loads(text))  # type: ignore[no-any-return]


def _form_fields(kind: GoalKind) -> tuple[TypedField, ...]:
    found = load_class(kind.type)
    return () if found is None else tuple(flat_fields(found.Goal()))
