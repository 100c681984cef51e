"""A snapshot: everything that is known of the robot at one moment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

from archo_tui.robot.message_rate import MessageRate
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.state.diagnostic import Diagnostic
from archo_tui.robot.state.event import Event
from archo_tui.robot.state.goal import Goal
from archo_tui.robot.state.names import in_namespace, not_offered
from archo_tui.robot.state.node import NodeState
from archo_tui.robot.state.parameter import Parameter, linked_number
from archo_tui.robot.state.resource import Resource
from archo_tui.robot.state.stop import Latch, OpenStop
from archo_tui.robot.state.telemetry import Battery, GaugeReading, Motion, Pose
from archo_tui.robot_file.model import FormField, GoalKind, Limit, ParameterRef, RobotFile

_NOTHING: Mapping[str, Any] = MappingProxyType({})


class Snapshot(NamedTuple):
    """Everything that a front end can show of the robot, at one moment.

    Attributes:
        file: The robot file.
        battery: The last reading of the battery.
        motion: The last reading of the motion.
        pose: The last reading of the pose.
        diagnostics: The last diagnostic status of each part, by name.
        gauges: The last readings of the gauges, in the order of the robot file.
        goal: The goal to show: one of this console, else another's, else the last that ended.
        running: The number of goals that run, of all clients.
        history: The last 20 goals that ended, newest first.
        parameters: The parameters of all nodes.
        unreported: Why a node's parameters are not known, by its full name.
        nodes: The nodes in the robot's namespace.
        offered: The names of the robot file for which a node publishes or serves something.
        events: The events, newest last.
        charge: Samples of the charge since charging began or ended: monotonic seconds and percent.
        open_stop: The STOP that is not confirmed; None if there is none.
        latch: The state of the last confirmed STOP.
        latch_doubt: Why `latch` is UNCERTAIN; "" if it is not.
        latch_time: The Unix time at which that STOP was confirmed; 0 before the first.
        released: When a release or a goal was last accepted, in monotonic seconds; None if none
            was.
        stop_held_by_nobody: True if the open STOP was never sent to any node, or, without an open
            one, if every node that confirmed that STOP ran in this process and
            has ended, and no further STOP is open.
        stop_not_obeyed: True if the robot moves though it has confirmed a STOP.
        still_running_after_stop: The names of goals that still run after a STOP was answered.
        namespace: The namespace of the robot.
        faults: Why a topic, a service or an action is not used, by its name in the robot file.
        publishers: The nodes of each topic of the robot file that several nodes publish.
        duplicate_nodes: The names that several nodes have.
        duplicate_servers: The nodes of STOP's service and of each action that several nodes serve.
        clock_offsets: The clocks that differ from this computer's: theirs minus ours in seconds, by
            node or topic.
        has_clock: True if a node publishes simulated time on /clock.
        clock_still_since: Since when /clock stands still, in monotonic seconds; None while it does
            not, or no node goes by it.
        other_namespaces: The other namespaces that have nodes.
        consoles: The other consoles in this namespace: `user_host_pid`.
        forms: The fields of each goal's form, by the goal's id, where its type is installed here.
        actions: The types of each action that is served, by its name.
        services: The types of each service that is served, by its name.
        resources: The topics, services and actions, without those that every node has.
        message_rates: The rate of each topic that the console reads, by its full name.
    """

    file: RobotFile = RobotFile()
    battery: Battery = Battery()
    motion: Motion = Motion()
    pose: Pose = Pose()
    diagnostics: tuple[Diagnostic, ...] = ()
    gauges: tuple[GaugeReading, ...] = ()
    goal: Goal | None = None
    running: int = 0
    history: tuple[Goal, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    unreported: Mapping[str, str] = _NOTHING
    nodes: tuple[NodeState, ...] = ()
    offered: frozenset[str] = frozenset()
    events: tuple[Event, ...] = ()
    charge: tuple[tuple[float, float], ...] = ()
    open_stop: OpenStop | None = None
    latch: Latch = Latch.NONE
    latch_doubt: str = ""
    latch_time: float = 0.0
    released: float | None = None
    stop_held_by_nobody: bool = False
    stop_not_obeyed: bool = False
    still_running_after_stop: tuple[str, ...] = ()
    namespace: str = "/"
    faults: Mapping[str, str] = _NOTHING
    publishers: Mapping[str, tuple[str, ...]] = _NOTHING
    duplicate_nodes: tuple[str, ...] = ()
    duplicate_servers: Mapping[str, tuple[str, ...]] = _NOTHING
    has_clock: bool = False
    clock_still_since: float | None = None
    clock_offsets: Mapping[str, float] = _NOTHING
    other_namespaces: tuple[str, ...] = ()
    consoles: tuple[str, ...] = ()
    forms: Mapping[str, tuple[TypedField, ...]] = _NOTHING
    actions: Mapping[str, tuple[str, ...]] = _NOTHING
    services: Mapping[str, tuple[str, ...]] = _NOTHING
    resources: tuple[Resource, ...] = ()
    message_rates: Mapping[str, MessageRate] = _NOTHING

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
        """True if the robot reports that it is stopped, or does not move while a STOP holds."""
        return self.says_stopped or (self.stop_holds and not self.motion.moving)

    @property
    def says_stopped(self) -> bool:
        """True if the robot's last report, newer than `released`, is that it is stopped.

        False while the latch is UNCERTAIN.
        """
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

    def unavailable(self, name: str) -> str:
        """Return why a topic, service or action of the robot file cannot be used; "" if it can.

        Args:
            name: The name as in the robot file.
        """
        return self.faults.get(name, "") if name in self.offered else not_offered(name)

    @property
    def unavailable_names(self) -> frozenset[str]:
        """The names in the robot file that no node offers, or not as the file says."""
        actions = (kind.action for kind in self.file.goals)
        names = (*self.file.topics, *self.file.services, *actions)
        return frozenset(name for name in names if self.unavailable(name))

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
        """Return the present number of a limit in the robot file; None if there is none.

        Args:
            given: The limit: a number, or the parameter of a node that holds it.
        """
        if isinstance(given, ParameterRef):
            return linked_number(self.parameters, self.namespace, given)
        return given

    def form(self, kind: GoalKind) -> Mapping[str, FormField]:
        """Return the fields of a goal's form by path, with the present numbers of their limits."""
        return {
            path: replace(given, low=self.limit(given.low), high=self.limit(given.high))
            for path, given in kind.form.items()
        }
