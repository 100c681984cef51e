"""The state of a recorded robot and console, rebuilt from messages one after the other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from copy import copy
from types import SimpleNamespace
from typing import Any, cast

from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from archo_tui.base.clock import Clock
from archo_tui.base.safe_text import safe
from archo_tui.recordings.console import JOURNAL, STATE, ConsoleState, from_json
from archo_tui.robot.clients import author
from archo_tui.robot.goals.machine import feedback_changes
from archo_tui.robot.graph.graph import is_hidden
from archo_tui.robot.graph.interface_checks import forms_of
from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.state.events import OWN_LEVELS, Event, EventLog, LineCounter
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.graph import (
    TOPIC,
    NodeState,
    in_namespace,
    level_word,
    logger_node,
    node_states,
)
from archo_tui.robot.state.snapshot import Snapshot
from archo_tui.robot.telemetry import Diagnostics, Telemetry
from archo_tui.robot_file.model import GoalKind, RobotFile
from archo_tui.station.alarms import Alarm
from archo_tui.station.conditions import Situation, conditions

ROSOUT = "/rosout"
_MAX_GOALS = 100  # Whose last feedback is kept.
_QOS = SimpleNamespace(reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.VOLATILE)


class RecordedTopics:
    """A stand-in for the console's node; its callbacks are called with the recorded messages."""

    def __init__(self, types: Mapping[str, str], namespace: str) -> None:
        self._types, self._namespace = types, namespace
        self.callbacks: dict[str, Callable[[Any], None]] = {}  # By full topic.

    def resolve_topic_name(self, name: str) -> str:
        return in_namespace(self._namespace, name)

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        kind = self._types.get(self.resolve_topic_name(topic))
        if kind is None:
            return []
        # A bag does not name its publishers.
        nobody = {"node_name": "", "node_namespace": "/", "endpoint_gid": b""}
        return [SimpleNamespace(topic_type=kind, qos_profile=_QOS, **nobody)]

    def listen_quietly(
        self, _kind: Any, topic: str, callback: Callable[[Any], None], _qos: Any
    ) -> Callable[[Any], None]:
        self.callbacks[self.resolve_topic_name(topic)] = callback
        return callback

    def destroy_subscription(self, callback: Callable[[Any], None]) -> None:
        self.callbacks = {n: known for n, known in self.callbacks.items() if known != callback}


def _namespace_of(types: Mapping[str, str], robot: RobotFile) -> str:
    """Return the namespace in which most of the robot file's topics are; of several the shortest.

    It is `/` if none was recorded.
    """
    own = [*robot.shown_topics, *map(_feedback_topic, robot.goals)]
    found = Counter(
        name[: -len(topic) - 1] or "/"
        for topic in own
        for name in types
        if not topic.startswith("/") and name.endswith(f"/{topic}")
    )
    return max(found, key=lambda namespace: (found[namespace], -len(namespace)), default="/")


def _feedback_topic(kind: GoalKind) -> str:
    return f"{kind.action}/_action/feedback"


class _RecordingClock(Clock):
    time = 0.0

    def monotonic(self) -> float:
        return self.time

    def now(self) -> float:
        return self.time


# What changes as messages are applied: of the state, and of its telemetry.
_CHANGING = (*("goal", "_state_json", "_feedback", "_log", "_message_rates", "_logged"),)
_READINGS = ("battery", "motion", "pose", "gauges", "diagnostics", "charge", "periods")
Checkpoint = tuple[Mapping[str, Any], Mapping[str, Any]]


def _copied(value: Any) -> Any:
    """Return a copy that changes independently; the frozen values in it are shared."""
    if isinstance(value, dict):
        return value.copy()
    if isinstance(value, (EventLog, LineCounter, Diagnostics)):
        made = copy(value)
        vars(made).update({name: _copied(part) for name, part in vars(value).items()})
        return made
    return value


class ReplayState:
    """The state of robot and console after the messages applied so far."""

    def __init__(self, file: RobotFile, types: Mapping[str, str]) -> None:
        """Create the state before the first message; `types` are those of the recorded topics."""
        self._file, self._clock, namespace = file, _RecordingClock(), _namespace_of(types, file)
        self._topics = RecordedTopics(types, namespace)
        node, full = cast("Any", self._topics), self._topics.resolve_topic_name
        self._telemetry = Telemetry(node, file, self._clock, self._on_reading, lambda _: None)
        self._telemetry.resubscribe()
        self._feedback_topics = {full(_feedback_topic(kind)) for kind in file.goals}
        self._kinds = {(kind.id, kind.action): kind for kind in file.goals}
        self._forms = forms_of(file)
        actions = {kind.action: "not recorded" for kind in file.goals}
        heard = {name for name in file.shown_topics if full(name) in types}
        offered = frozenset(heard | {*actions, *file.services})
        known = Snapshot(namespace=namespace, offered=offered, faults=actions)
        self._initial = ConsoleState(known)
        # The state, and the JSON it was parsed from.
        self.console, self._state_json = self._initial, ""
        self.goal: Goal | None = None
        # Of each goal, by its id: the last feedback, with its time.
        self._feedback: dict[str, tuple[float, Any]] = {}
        self._log = EventLog()
        self.last_event: Event | None = None  # Of the last applied log line.
        self._message_rates: dict[str, MessageRate] = {}  # Of each topic, by its full name.
        self._logged: dict[str, float] = {}  # When nodes logged last, by name.

    @property
    def has_console_state(self) -> bool:
        """True if a console's own state was applied; a bag of another tool has none."""
        return bool(self._state_json)

    @property
    def topics(self) -> frozenset[str]:
        """The full names of the topics that `apply` uses; it ignores messages of others."""
        own = (ROSOUT, JOURNAL, STATE)
        return frozenset((*own, *self._topics.callbacks, *self._feedback_topics))

    def checkpoint(self) -> Checkpoint:
        """Return a copy of everything that is needed to continue from here."""
        readings = {name: _copied(getattr(self._telemetry, name)) for name in _READINGS}
        return {name: _copied(getattr(self, name)) for name in _CHANGING}, readings

    def restore(self, checkpoint: Checkpoint) -> None:
        """Replace this state with a checkpoint's, maybe of another state of the same recording."""
        state_json, (known, readings) = self._state_json, checkpoint
        for of, values in ((self, known), (self._telemetry, readings)):
            for name, value in values.items():
                setattr(of, name, _copied(value))
        if self._state_json != state_json:  # The JSON takes far less memory than the parsed state.
            is_there = bool(self._state_json)
            self.console = from_json(self._state_json) if is_there else self._initial

    def apply(self, time: float, topic: str, message: Any) -> None:
        """Apply the next message; a hostile one may raise any exception."""
        self._clock.time = time
        if topic == STATE:
            self._apply_state(from_json(message.data))
            self._state_json = message.data
        elif topic == JOURNAL:
            self._on_journal(message)
        elif topic == ROSOUT:
            self._on_log(message)
        elif topic in self._feedback_topics:
            self._on_feedback(bytes(message.goal_id.uuid).hex(), message.feedback)
        elif topic in self._topics.callbacks:
            self._topics.callbacks[topic](message)

    def _apply_state(self, state: ConsoleState) -> None:
        for alarm in state.alarms:
            assert alarm.priority  # Raises KeyError for an unknown kind of alarm.
        found = state.snapshot
        self.console, self.goal = state._replace(snapshot=found._replace(events=())), found.goal
        if self.goal is not None:
            self.goal = self._with_feedback(self._with_file_kind(self.goal))
        if found.events:
            self._log = EventLog.of(found.events)
        if not self._telemetry.charge:
            self._telemetry.charge = found.charge
        # The state may be older than the messages received meanwhile.
        self._message_rates = {**found.message_rates, **self._message_rates}
        for node in found.nodes:
            if node.heard is not None:
                self._logged.setdefault(node.name, node.heard)

    def _with_file_kind(self, goal: Goal) -> Goal:
        return goal._replace(kind=self.goal_kind(goal.kind))

    def goal_kind(self, recorded: GoalKind) -> GoalKind:
        """Return the robot file's goal of the same id and action, else the recorded one."""
        return self._kinds.get((recorded.id, recorded.action), recorded)

    def _on_feedback(self, goal_id: str, feedback: Any) -> None:
        self._feedback.pop(goal_id, None)
        self._feedback[goal_id] = self._clock.time, feedback
        if len(self._feedback) > _MAX_GOALS:
            del self._feedback[next(iter(self._feedback))]
        if self.goal is not None:
            self.goal = self._with_feedback(self.goal)

    def _with_feedback(self, goal: Goal) -> Goal:
        """Return the goal with its last feedback, if it runs and what is known of it is older."""
        time, feedback = self._feedback.get(goal.id, (0.0, None))
        if not goal.is_running or time <= (goal.heard or 0.0):
            return goal
        started = goal.sent if goal.started is None else goal.started
        changes = feedback_changes(goal, feedback, time)
        return goal._replace(heard=time, started=started, **changes)

    def _on_journal(self, message: Any) -> None:
        level, source, text = level_word(message.level), message.name, message.msg
        own, _, rest = text.partition(": ")
        if own in OWN_LEVELS:
            level, text = own, rest
        # A person may paste the command into a shell: it must not hold a line end.
        command, code = safe(message.function), safe(message.file)
        event = Event(self._clock.time, level, source, text, command, code=code)
        self.last_event = self._log.add(event)

    def _on_log(self, message: Any) -> None:
        node = logger_node(message.name)
        below = f"{self.console.snapshot.namespace.rstrip('/')}/"
        if author(node) or not node.startswith(below) or is_hidden(node):
            return  # The journal has what consoles log; other robots do not matter here.
        self._logged[node] = self._clock.time
        level = level_word(message.level)
        self.last_event = self._log.add(Event(self._clock.time, level, message.name, message.msg))

    def _on_reading(self, topic: str, _has_changed: bool) -> None:
        full, now = self._topics.resolve_topic_name(topic), self._clock.time
        rate = self._message_rates.get(full)
        self._message_rates[full] = MessageRate(now) if rate is None else rate.with_message_at(now)

    @property
    def curve_snapshot(self) -> Snapshot:
        """A snapshot of battery, motion and goal only, which is cheap to make."""
        return Snapshot(
            battery=self._telemetry.battery, motion=self._telemetry.motion, goal=self.goal
        )

    @property
    def snapshot(self) -> Snapshot:
        """The state of the robot after the last applied message, as the console knew it."""
        telemetry = self._telemetry
        state = telemetry.in_snapshot(self.console.snapshot)
        return state._replace(
            file=self._file,
            forms=self._forms,
            goal=self.goal,
            history=tuple(map(self._with_file_kind, state.history)),
            nodes=self._nodes(state),
            events=self._log.all(),
            faults={**telemetry.faults, **state.faults},
            message_rates=dict(self._message_rates),
        )

    def _nodes(self, state: Snapshot) -> tuple[NodeState, ...]:
        topics = (each for each in state.resources if each.kind == TOPIC and each.nodes)
        rates = self._message_rates
        by_node = ((t.nodes[0], rates[t.name]) for t in topics if t.name in rates)
        found = node_states([node.name for node in state.nodes], self._logged, by_node)
        return tuple(
            found[n.name]._replace(lifecycle=n.lifecycle, rate=found[n.name].rate or n.rate)
            for n in state.nodes
        )

    def alarms(
        self, snapshot: Snapshot, now: float, evaluated: tuple[Alarm, ...]
    ) -> tuple[Alarm, ...]:
        """Return the recorded alarms, else those evaluated, with their texts at a Unix time."""
        texts = conditions(Situation(snapshot, now, self.console.hosted)).texts
        alarms = self.console.alarms if self.has_console_state else evaluated
        return tuple(
            alarm if alarm.is_over else alarm._replace(text=texts.get(alarm.name, alarm.text))
            for alarm in alarms
        )
