"""Everything that a front end can show of the robot, at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from enum import Enum
from types import MappingProxyType
from typing import Any, NamedTuple

from archo_tui.base.clock import Monotonic, UnixTime
from archo_tui.robot.messages.period import MessageRate
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.state.events import Event
from archo_tui.robot.state.frames import Transforms
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.graph import (
    NodeState,
    Parameter,
    Resource,
    in_namespace,
    linked_number,
    not_offered,
)
from archo_tui.robot.state.readings import Battery, Diagnostic, GaugeReading, Motion, Pose
from archo_tui.robot_file.model import FormField, GoalKind, Limit, ParameterRef, RobotFile


class Life(Enum):
    """The state of a hosted node, or of a program that the console runs."""

    UP = "up"
    STOPPED = "stopped by you"
    CRASHED = "crashed"
    STUCK = "does not stop"
    STARTING = "starting"  # Its constructor has not returned.
    ENDED = "ended"  # Its program has returned.
    WAITING = "waits: s once the STOP is released"  # A program that was to start behind a STOP.

    @property
    def is_running(self) -> bool:
        """True for UP and STARTING: the node can be stopped and not be started."""
        return self in (Life.UP, Life.STARTING)


class Hosted(NamedTuple):
    """A node that this process hosts."""

    name: str
    life: Life = Life.UP
    error: str = ""  # What a callback raised.
    traceback: str = ""  # The traceback of `error`, or "".
    serves: tuple[str, ...] = ()  # The full names of the services and actions that it serves.
    file: str = ""  # The name of the user's file that it comes from; "" for a node of a package.
    saved: UnixTime = 0.0  # The Unix time at which the text that runs was saved.


_NOTHING: Mapping[str, Any] = MappingProxyType({})


class StopAnswer(Enum):
    """The answer so far to a STOP that is not confirmed; the value is the word for it."""

    AWAITED = ""
    NONE = "no answer"  # Not from every server in time.
    NOT_SENT = "NOT SENT"
    REFUSED = "REFUSED"
    UNCONFIRMED = "ANSWERED, NOT CONFIRMED"


class OpenStop(NamedTuple):
    """A STOP that was requested and that the robot has not confirmed."""

    asked: Monotonic  # When it was requested, in monotonic seconds; a repeat does not change it.
    answer: StopAnswer = StopAnswer.AWAITED
    why: str = ""  # Details of the answer for people; "" if there are none.


class Latch(Enum):
    """The state of the last STOP that the robot or another console has reported as confirmed."""

    NONE = "none"  # There was none, or it was released.
    HELD = "held"
    UNCERTAIN = "uncertain"  # It may no longer hold; `Snapshot.latch_doubt` says why.


class Snapshot(NamedTuple):
    """Everything that a front end can show of the robot, at one moment."""

    file: RobotFile = RobotFile()
    battery: Battery = Battery()
    motion: Motion = Motion()
    pose: Pose = Pose()
    diagnostics: tuple[Diagnostic, ...] = ()  # The last diagnostic status of each part, by name.
    # The last readings of the gauges, in the order of the robot file.
    gauges: tuple[GaugeReading, ...] = ()
    # The goal to show: one of this console, else another's, else the last that ended.
    goal: Goal | None = None
    running: int = 0  # The number of goals that run, of all clients.
    history: tuple[Goal, ...] = ()  # The last 20 goals that ended, newest first.
    parameters: tuple[Parameter, ...] = ()
    # Why a node's parameters are not known, by its full name.
    unreported: Mapping[str, str] = _NOTHING
    nodes: tuple[NodeState, ...] = ()  # The nodes in the robot's namespace.
    # The names of the robot file for which a node publishes or serves something.
    offered: frozenset[str] = frozenset()
    events: tuple[Event, ...] = ()
    # Samples of the charge since charging began or ended: monotonic seconds and percent.
    charge: tuple[tuple[Monotonic, float], ...] = ()
    open_stop: OpenStop | None = None  # The STOP that is not confirmed; None if there is none.
    latch: Latch = Latch.NONE  # The state of the last confirmed STOP.
    latch_doubt: str = ""  # Why `latch` is UNCERTAIN; "" if it is not.
    latch_time: UnixTime = 0.0  # When that STOP was confirmed; 0 before the first.
    # When a release or a goal was last accepted, in monotonic seconds; None if none was.
    released: Monotonic | None = None
    # True if the open STOP was never sent to any node, or, without an open one, if every node that
    # confirmed that STOP ran in this process and has ended, and no further STOP is open.
    stop_held_by_nobody: bool = False
    stop_not_obeyed: bool = False  # True if the robot moves though it has confirmed a STOP.
    # The names of goals that still run after a STOP was answered.
    still_running_after_stop: tuple[str, ...] = ()
    namespace: str = "/"
    # Why a topic, a service or an action is not used, by its name in the robot file.
    faults: Mapping[str, str] = _NOTHING
    # The nodes of each topic of the robot file that several nodes publish.
    publishers: Mapping[str, tuple[str, ...]] = _NOTHING
    duplicate_nodes: tuple[str, ...] = ()  # The names that several nodes have.
    # The nodes of STOP's service and of each action that several nodes serve.
    duplicate_servers: Mapping[str, tuple[str, ...]] = _NOTHING
    has_clock: bool = False  # True if a node publishes simulated time on /clock.
    # The clocks that differ from this computer's: theirs minus ours in seconds, by node or topic.
    clock_offsets: Mapping[str, float] = _NOTHING
    other_namespaces: tuple[str, ...] = ()  # The other namespaces that have nodes.
    consoles: tuple[str, ...] = ()  # The other consoles in this namespace: `user_host_pid`.
    # The fields of each goal's form, by the goal's id, where its type is installed here.
    forms: Mapping[str, tuple[TypedField, ...]] = _NOTHING
    # The types of each action that is served, by its name.
    actions: Mapping[str, tuple[str, ...]] = _NOTHING
    # The types of each service that is served, by its name.
    services: Mapping[str, tuple[str, ...]] = _NOTHING
    # The topics, services and actions, without those that every node has.
    resources: tuple[Resource, ...] = ()
    # The rate of each topic that the console reads, by its full name.
    message_rates: Mapping[str, MessageRate] = _NOTHING
    transforms: Transforms = Transforms()  # Empty while nobody needs them.

    @property
    def is_stopped(self) -> bool:
        """True while the robot reports that it is stopped, or a STOP holds, is open or in doubt."""
        in_doubt = self.open_stop is not None or self.latch is Latch.UNCERTAIN
        return in_doubt or self.says_stopped or self.stop_holds

    @property
    def simulated_nodes(self) -> tuple[str, ...]:
        """The nodes that go by simulated time."""
        return tuple(
            p.node for p in self.parameters if p.name == "use_sim_time" and p.value is True
        )

    @property
    def has_stop(self) -> bool:
        """True if a STOP can be sent, by the robot file and the nodes that were found so far."""
        stop = self.file.stop
        return stop is not None and not (self.nodes and self.unavailable(stop.service))

    @property
    def stop_holds(self) -> bool:
        """True while the latch is HELD, for a robot that does not report whether it is stopped.

        False for a robot without a service to release a STOP: there a STOP is over as soon as it is
        confirmed.
        """
        stop = self.file.stop
        is_latched = self.latch is Latch.HELD and stop is not None and bool(stop.release)
        return is_latched and self.motion.stopped is None

    @property
    def is_at_rest(self) -> bool:
        """True if the robot reports that it is stopped, or does not move while a STOP holds.

        Not while a goal runs on behind that STOP: a robot without motion may drive.
        """
        is_still = self.says_stopped or (self.stop_holds and not self.motion.moving)
        return is_still and not self.still_running_after_stop

    @property
    def runs_on(self) -> bool:
        """True if a goal still runs although the robot confirmed a STOP, or reports one."""
        return bool(self.still_running_after_stop) and (self.says_stopped or self.stop_holds)

    @property
    def says_stopped(self) -> bool:
        """True if the robot reports that it is stopped, unless that is past or uncertain."""
        heard, released = self.motion.received, self.released
        is_past = heard is not None and released is not None and heard <= released
        return bool(self.motion.stopped) and not is_past and self.latch is not Latch.UNCERTAIN

    @property
    def running_goal(self) -> Goal | None:
        """The goal that is shown, if it runs; else None."""
        return self.goal if self.goal is not None and self.goal.is_running else None

    def full(self, name: str) -> str:
        """Return the full name on the graph of a name in the robot file."""
        return in_namespace(self.namespace, name)

    def moves_by(self, topic: str) -> bool:
        """Return False for a full topic name of which the robot file says that nothing moves."""
        return all(rule.moves for rule in self.file.topics if self.full(rule.topic) == topic)

    def expected_rate(self, topic: str) -> float | None:
        """Return the rate in Hz that the robot file expects of a full topic name; None for none."""
        rates = (rule.rate for rule in self.file.topics if self.full(rule.topic) == topic)
        return next((rate for rate in rates if rate is not None), None)

    def unavailable(self, name: str) -> str:
        """Return why a topic, service or action of the robot file cannot be used; "" if it can."""
        return self.faults.get(name, "") if name in self.offered else not_offered(name)

    def parameter(self, name: str) -> Parameter | None:
        """Return the first parameter of that name, by node names; None if no node has one."""
        return next((p for p in self.parameters if p.name == name), None)

    @property
    def low_charge(self) -> float | None:
        """The charge in % below which the battery is low; None if it is not known."""
        low = None if self.file.battery is None else self.file.battery.low
        if isinstance(low, ParameterRef):
            return linked_number(self.parameters, self.namespace, low, 0.0, 100.0)
        return low

    @property
    def time_factor(self) -> float | None:
        """The simulated seconds in a real one; None if the factor is 1, or is not reported."""
        link = None if self.file.motion is None else self.file.motion.time_factor
        found = None if link is None else linked_number(self.parameters, self.namespace, link, 0.0)
        return None if found == 1.0 else found

    def limit(self, given: Limit) -> float | None:
        """Return the present number of a limit in the robot file; None if there is none."""
        if isinstance(given, ParameterRef):
            return linked_number(self.parameters, self.namespace, given)
        return given

    def form(self, kind: GoalKind) -> Mapping[str, FormField]:
        """Return the fields of a goal's form by path, with the present numbers of their limits."""
        return {
            path: replace(given, low=self.limit(given.low), high=self.limit(given.high))
            for path, given in kind.form.items()
        }
