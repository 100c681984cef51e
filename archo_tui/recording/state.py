"""The state of the console in a recording, on the topic `/archo_tui/state`.

The names of the fields are those of the recorded JSON. All times are Unix times in s.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from archo_tui.robot.period import MessageRate
from archo_tui.robot.state import (
    Event,
    Goal,
    Hosted,
    NodeState,
    OpenStop,
    Parameter,
    Resource,
)
from archo_tui.robot_file.model import GoalKind
from archo_tui.station.alarms import Alarm
from archo_tui.station.view import View

Names = Mapping[str, tuple[str, ...]]
_GOAL_TIMES = ("sent", "heard", "started", "ended", "cancel_asked", "lost")


class RecordedAction(NamedTuple):
    """The action of a recorded goal, with the words of its entry in the robot file.

    A replay uses the entry that its robot file has for the same `id` and `action`, if there is one.
    """

    id: str
    title: str
    action: str
    type: str
    noun: str = ""


class RecordedGoal(NamedTuple):
    """A goal that waited in the console's queue, with the values of its fields by name."""

    kind: RecordedAction
    values: Mapping[str, Any]


class ConsoleState(NamedTuple):
    """The console's state at one moment: what no topic of the robot tells.

    Fields that are not explained have the meaning of those of the same name in Snapshot and View.
    """

    engine: str = ""
    namespace: str = "/"
    nodes: tuple[NodeState, ...] = ()
    hosted: tuple[Hosted, ...] = ()
    offered: frozenset[str] = frozenset()
    parameters: tuple[Parameter, ...] = ()
    faults: Mapping[str, str] = {}
    publishers: Names = {}
    twice: tuple[str, ...] = ()  # As in Snapshot.duplicate_nodes.
    several: Names = {}  # As in Snapshot.duplicate_servers.
    has_clock: bool = False
    elsewhere: tuple[str, ...] = ()  # As in Snapshot.other_namespaces.
    consoles: tuple[str, ...] = ()
    actions: Names = {}
    services: Names = {}
    resources: tuple[Resource, ...] = ()
    paces: Mapping[str, MessageRate] = {}  # As in Snapshot.message_rates.
    charge: tuple[tuple[float, float], ...] = ()
    open_stop: OpenStop | None = None
    outlived: tuple[str, ...] = ()  # As in Snapshot.still_running_after_stop.
    goal: Goal | None = None
    running: int = 0
    history: tuple[Goal, ...] = ()
    alarms: tuple[Alarm, ...] = ()
    queue: tuple[RecordedGoal, ...] = ()
    held: str = ""
    clients: tuple[str, ...] = ()
    events: tuple[Event, ...] = ()  # In the first state of a recording only.


def all_times(state: ConsoleState) -> Iterator[float | None]:
    """Yield every time in a state, for a check of their range; None for each that is not set."""
    for goal in (*state.history, *([state.goal] if state.goal else [])):
        yield goal.time
        yield from (getattr(goal, name) for name in _GOAL_TIMES)
    for alarm in state.alarms:
        yield from (alarm.since, alarm.until, alarm.shelved_until, alarm.shelf_ends)
    for line in state.events:
        yield from (line.time, line.first)
    yield from (node.heard for node in state.nodes)
    yield from (hosted.saved for hosted in state.hosted)
    yield from (rate.heard for rate in state.paces.values())
    yield from (time for time, _ in state.charge)
    if state.open_stop:
        yield state.open_stop.asked


def change_key(view: View) -> tuple[object, ...]:
    """Return a tuple that differs from an earlier view's if this view is worth recording again.

    It leaves out what changes all the time: times, the feedback of goals, readings.
    """
    snapshot = view.snapshot
    goal = snapshot.goal
    return (
        tuple([node.name for node in snapshot.nodes]),
        view.hosted,
        snapshot.offered,
        snapshot.parameters,
        snapshot.faults,
        snapshot.publishers,
        snapshot.duplicate_nodes,
        snapshot.duplicate_servers,
        snapshot.has_clock,
        snapshot.other_namespaces,
        snapshot.consoles,
        snapshot.resources,
        snapshot.open_stop,
        snapshot.still_running_after_stop,
        None if goal is None else (goal.number, goal.phase, goal.length, goal.message),
        snapshot.running,
        tuple([(alarm.name, alarm.state, alarm.reason) for alarm in view.alarms]),
        view.waiting,
        view.held,
        view.clients,
    )


def console_state(view: View, since: float, *, with_events: bool) -> ConsoleState:
    """Return the state of the console for a recording, all times as Unix times, secrets masked.

    Args:
        view: The station's view.
        since: Unix time minus monotonic time, in s.
        with_events: True to include the events so far, without their audit records, as the first
            state of a recording does.
    """
    snapshot = view.snapshot
    stop, goal = snapshot.open_stop, snapshot.goal

    def at(monotonic: float | None) -> float | None:
        return None if monotonic is None else monotonic + since

    return ConsoleState(
        engine=view.engine,
        namespace=snapshot.namespace,
        nodes=tuple(node._replace(heard=at(node.heard)) for node in snapshot.nodes),
        hosted=view.hosted,
        offered=snapshot.offered,
        parameters=tuple(parameter.masked for parameter in snapshot.parameters),
        faults=snapshot.faults,
        publishers=snapshot.publishers,
        twice=snapshot.duplicate_nodes,
        several=snapshot.duplicate_servers,
        has_clock=snapshot.has_clock,
        elsewhere=snapshot.other_namespaces,
        consoles=snapshot.consoles,
        actions=snapshot.actions,
        services=snapshot.services,
        resources=snapshot.resources,
        paces={
            name: rate._replace(heard=rate.heard + since)
            for name, rate in snapshot.message_rates.items()
        },
        charge=tuple((time + since, percentage) for time, percentage in snapshot.charge),
        open_stop=None if stop is None else stop._replace(asked=stop.asked + since),
        outlived=snapshot.still_running_after_stop,
        goal=None if goal is None else _with_unix_times(goal, since),
        running=snapshot.running,
        history=tuple(_with_unix_times(ended, since) for ended in snapshot.history),
        alarms=view.alarms,
        queue=tuple(RecordedGoal(_recorded_action(goal.kind), goal.values) for goal in view.queue),
        held=view.held,
        clients=view.clients,
        events=tuple(replace(event, audit_record=None) for event in snapshot.events)
        if with_events
        else (),
    )


def _with_unix_times(goal: Goal, since: float) -> Goal:
    values = {name: getattr(goal, name) for name in _GOAL_TIMES}
    moved = {name: None if time is None else time + since for name, time in values.items()}
    # Messages tell the way of the last seconds again.
    return goal._replace(kind=_recorded_action(goal.kind), way=(), **moved)  # type: ignore[arg-type]


def _recorded_action(kind: GoalKind) -> RecordedAction:
    return RecordedAction(kind.id, kind.title, kind.action, kind.type, kind.noun)
