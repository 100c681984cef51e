"""Robot: the operator's verbs, awaitable, and a stream of snapshots. An rclpy node inside.

Verbs are called on the asyncio loop. Each ends: done, refused with the reason, or no answer.
"""

from __future__ import annotations

# ruff: noqa: E402
from collections.abc import Callable, Coroutine, Mapping, Sequence
from typing import Any

from archo_tui import engine

engine.ensure()

from rcl_interfaces.msg import Log
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.context import Context
from rclpy.node import Node

from archo_tui.clock import Clock
from archo_tui.errors import in_one_line
from archo_tui.robot import interfaces, messages, ros2_command, services
from archo_tui.robot.consoles import author, own_name
from archo_tui.robot.events import EventLog
from archo_tui.robot.fields import filled
from archo_tui.robot.followed import FARTHEST
from archo_tui.robot.goals import Goals
from archo_tui.robot.graph import Graph, logger_node
from archo_tui.robot.mailbox import Mailbox, Receiver
from archo_tui.robot.offers import Offers
from archo_tui.robot.others import Others
from archo_tui.robot.parameters import Parameters
from archo_tui.robot.services import Services
from archo_tui.robot.state import WATCHING, Event, Leaf, Outcome, Snapshot, linked, target
from archo_tui.robot.stopping import ALL_ANSWERS, Stopping
from archo_tui.robot.stops import HELD, NOT_SENT, Gate, Stops, Void
from archo_tui.robot.subscribe import subscribe
from archo_tui.robot.telemetry import Telemetry
from archo_tui.robot.text import harmless
from archo_tui.robot.thread import RosThread
from archo_tui.robot.values import text_of
from archo_tui.robots import check, model

FLUSH_PERIOD = 0.125  # s between two snapshots while data streams in: 8 a second
WATCH_PERIOD = 0.2  # s between two looks at a goal that runs
LOOK_PERIOD = 1.0  # s between two looks at the graph (rclpy has no event for changes)
_LEVELS = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}


class Robot:
    """Operates whatever robot is on the graph of `context`."""

    def __init__(
        self,
        context: Context,
        description: model.Robot,
        clock: Clock,
        happened: Callable[[Event], None] = lambda _: None,
        *,
        watching: bool = False,
    ) -> None:
        """`happened(event)` is called on the ROS thread for each event, and when one repeats.

        Watching, it calls nothing but what reads, and every verb is refused.
        """
        self.watching = watching
        self.description = description
        self._clock, self._happened = clock, happened
        self.stops = Stops()
        self._mailbox = Mailbox()
        self._log = EventLog()
        self._dirty = False
        self._unseen = False  # something was heard that differs in its time only
        self._outlived: tuple[str, ...] = ()  # goals that still run after an answered STOP
        self._faults: dict[str, str] = {}
        self._consoles: set[str] | None = None  # the others, at the last look
        self._others = Others(command.title for command in description.commands)
        node = self._node = Node(own_name(), context=context, start_parameter_services=False)
        self._services = Services(node, clock)
        self._telemetry = Telemetry(node, description, clock, self._on_telemetry, self._warn)
        self._goals = Goals(node, clock, self._services, self._goal_changed, self._say, watching)
        self._parameters = Parameters(
            node, clock, self._services, self._mark, self._telemetry.measure_anew, self._on_change
        )
        self._graph = Graph(node, description)
        self._offers = Offers(node, description, self._graph)
        self._services.answered = self._on_answer
        self._stopping = Stopping(
            node,
            description.stop,
            clock,
            self._services,
            self._graph,
            self._offers,
            self._look,
            self._flush,
            self._tell,
        )
        subscribe(node, Log, "/rosout", self._on_log, 1000)
        steady = RosClock(clock_type=ClockType.STEADY_TIME)  # whatever the robot's time does
        self._flusher = node.create_timer(FLUSH_PERIOD, self._flush, clock=steady)
        self._flusher.cancel()
        node.create_timer(LOOK_PERIOD, self._look_again, clock=steady)
        self._watcher = node.create_timer(WATCH_PERIOD, self._watch, clock=steady)
        self._watcher.cancel()
        for kind in description.goals:
            self._goals.open(kind)
        self._thread = RosThread(node, context, clock, self._on_error)
        for said in self._offers.unfit.values():
            self._warn(said)
        self._flush()  # what the robot's file says is known before anything is heard

    # life

    def start(self) -> None:
        """Begin to listen."""
        self._thread.submit(self._look)
        self._thread.start()

    def subscribe(self, receiver: Receiver) -> None:
        """Have `receiver(snapshot)` called on this loop, first with what is known already."""
        self._mailbox.open(receiver)
        receiver(self._mailbox.latest)

    def stop(self) -> None:
        """Stop delivering and leave the graph."""
        self._mailbox.close()
        if self._thread.stop():
            self._goals.close()

    @property
    def snapshot(self) -> Snapshot:
        """What is known now."""
        return self._mailbox.latest

    # verbs

    async def emergency_stop(self) -> Outcome:
        """Stop at once; stays stopped until released."""
        stop = self.description.stop
        if stop is None:
            return Outcome(False, f"{self.description.name} {model.NO_STOP}")

        command = self._offers.call_command(stop.service, {})
        return await self._do("STOP", command, lambda _: self._stopping.send())

    async def release_emergency_stop(self) -> Outcome:
        """Allow moves again; none resumes by itself."""
        stop = self.description.stop
        if stop is None or not stop.release:
            return Outcome(False, f"{self.description.name} has no service to release a stop")
        name = stop.release

        async def call(gate: Gate) -> Outcome:
            turn = self._services.turn()
            outcome = await self._call(name, {}, gate)
            if outcome.ok:
                self._stopping.past(turn)
            return outcome

        return await self._do("release stop", self._offers.call_command(name, {}), call)

    async def command(self, command: model.Service, on: bool = True) -> Outcome:
        """Give one of the robot file's commands; `on` is what a toggle is set to."""
        title = command.title.lower() if on else command.off or f"{command.title.lower()} off"
        return await self._service(title, command.service, dict.fromkeys(command.toggle, on))

    async def send(
        self, kind: model.GoalKind, values: Mapping[str, Any], *, queued: bool = False
    ) -> Outcome:
        """Send a goal, with values by dotted path; ends when the robot has accepted or refused.

        A queued one is not sent behind a STOP, whatever the robot would do with it.
        """
        length = self._way(kind)
        title = " ".join(filter(None, (kind.title.lower(), target(kind, values))))

        async def go(gate: Gate) -> Outcome:
            turn = self._services.turn()
            if queued and (self._stopping.open is not None or self._telemetry.motion.stopped):
                return Outcome(False, HELD)
            rivals = self._graph.rivals(kind.action)
            if rivals:  # of another one than the robot file's as well
                return Outcome(False, check.several(kind.action, rivals))
            if kind.action in self._faults:
                return Outcome(False, self._faults[kind.action])
            outcome = await self._goals.send(kind, values, length, gate)
            if outcome.ok:
                self._stopping.past(turn)
            return outcome

        return await self._do(title, self._offers.goal_command(kind, values), go)

    async def send_no_more(self) -> None:
        """The console ends: goals that have not left yet never do."""

        async def there() -> None:
            self._goals.are_over = True

        await self._thread.run(there, services.DEADLINE)

    async def call(self, service: str, type_name: str, values: Mapping[str, Any]) -> Outcome:
        """Call any service, with values by dotted path; the outcome holds what it answered."""
        srv_type = interfaces.load(type_name)
        if srv_type is None:
            return Outcome(False, check.missing(service, type_name))
        try:
            request = filled(srv_type.Request(), values)
        except ValueError as error:
            return Outcome(False, str(error))

        async def work(gate: Gate) -> Outcome:
            answer = await self._services.call(srv_type, service, request, gate=gate)
            if answer is None:
                return Outcome(False, f"no answer in {services.DEADLINE:g} s")
            said = interfaces.outcome(answer)
            return Outcome(
                bool(getattr(answer, "success", True)), messages.text(answer) or said.text
            )

        command = ros2_command.service_call(service, type_name, request)
        return await self._do(f"call {service.lstrip('/')}", command, work)

    def form(self, type_name: str) -> tuple[Leaf, ...] | None:
        """The fields of an action's goal or a service's request; None: it is not installed here."""
        found = interfaces.load(type_name)
        if found is None:
            return None
        return tuple(messages.leaves(found.Goal() if "/action/" in type_name else found.Request()))

    async def give_up_stop(self) -> Outcome:
        """Ask no more for a STOP that the robot does not confirm."""

        async def call(gate: Gate) -> Outcome:
            gate()
            self._stopping.over()
            return Outcome(True, "not asked for any more; the robot has not confirmed it")

        return await self._do("give up STOP", "", call)

    async def cancel(self, *, another: bool = False) -> Outcome:
        """Ask to cancel the running goal; another client's only when that is meant."""
        goal = self._goals.goal
        command = "" if goal is None else ros2_command.cancel(self._offers.full(goal.kind.action))
        return await self._do("cancel", command, lambda _: self._goals.cancel(another=another))

    async def cancel_all(self) -> Outcome:
        """Ask to cancel every goal of the robot's actions, whoever sent it."""
        names = [self._offers.full(kind.action) for kind in self.description.goals]
        command = "; ".join(ros2_command.cancel(name) for name in names)
        return await self._do("cancel every goal", command, lambda _: self._goals.cancel_all())

    async def set_parameters(self, node: str, values: Mapping[str, Any]) -> Outcome:
        """Set parameters of one node, all or none, to values of the types that fit."""
        command = ros2_command.set_parameters(node, values)
        texts = ", ".join(f"{name} {text_of(value)}" for name, value in values.items())
        return await self._do(
            f"set {node.lstrip('/')} {texts}",
            command,
            lambda gate: self._parameters.set(node, values, gate),
        )

    def restarted(self, served: Sequence[str]) -> None:
        """The node that served these actions was restarted: their goals are over. Any thread."""

        def end() -> None:
            self._goals.restarted(lambda kind: self._offers.full(kind.action) in served)

        self._thread.submit(end)

    def note(self, level: str, source: str, text: str, command: str = "") -> None:
        """Add a line to the events, from any thread."""
        event = Event(self._clock.now(), level, source, text, command)
        self._thread.submit(lambda: self._add_event(event))

    # on the ROS thread

    def _way(self, kind: model.GoalKind) -> float | None:
        """The length of the whole way to a goal, where a node of the robot has it."""
        link = None if kind.remaining is None else kind.remaining.length
        if link is None:
            return None
        return linked(self._parameters.all(), self._graph.namespace, link, 0.0, FARTHEST)

    async def _service(self, title: str, name: str, fields: Mapping[str, Any]) -> Outcome:
        return await self._do(
            title,
            self._offers.call_command(name, fields),
            lambda gate: self._call(name, fields, gate),
        )

    async def _call(self, name: str, fields: Mapping[str, Any], gate: Gate) -> Outcome:
        """Call a service with the type that its server has, if its request is what is meant."""
        if name not in self._graph.offered:
            return Outcome(False, f"{self._offers.full(name)} is not offered by any node")
        srv_type, reason = self._offers.fitting(name, fields)
        if srv_type is None:
            return Outcome(False, reason)
        try:
            request = filled(srv_type.Request(), fields)
        except ValueError as error:
            return Outcome(False, str(error))
        answer = await self._services.call(srv_type, name, request, gate=gate)
        if answer is None:
            return Outcome(False, f"no answer in {services.DEADLINE:g} s")
        return interfaces.outcome(answer)

    async def _do(
        self, title: str, command: str, work: Callable[[Gate], Coroutine[Any, Any, Outcome]]
    ) -> Outcome:
        """Run a verb on the ROS thread and log how it ended; the snapshot then shows it.

        A verb that a STOP voids hands its gate on to where its request leaves.
        """
        if self.watching:
            return Outcome(False, WATCHING)
        gate = self.stops.gate()

        def log(outcome: Outcome) -> Outcome:
            outcome = Outcome(outcome.ok, harmless(outcome.text))
            self._tell(f"{title}: {outcome.text}", command)
            self._flush()
            return outcome

        async def there() -> Outcome:
            try:
                return log(await work(gate))
            except Void:
                return log(Outcome(False, NOT_SENT))
            except Exception as error:
                return log(Outcome(False, in_one_line(error)))

        # more than any verb takes that still can end: STOP waits for a server, and then for all
        deadline = services.DEADLINE + ALL_ANSWERS + 1.0
        try:
            return await self._thread.run(there, deadline)
        except TimeoutError:
            outcome = Outcome(False, f"no answer in {deadline:g} s from the console's own node")
            self.note("YOU", "console", f"{title}: {outcome.text}", command)
            return outcome

    def _look_again(self) -> None:
        """Every second."""
        self._look()
        if self._stopping.is_to_be_repeated and self._is_heard:
            self._thread.submit(self._stopping.send_again)

    @property
    def _is_heard(self) -> bool:
        """True while battery or motion is; a robot without them is as long as it is there."""
        now, told = self._clock.monotonic(), (self._telemetry.battery, self._telemetry.motion)
        if self.description.battery is None and self.description.motion is None:
            return True
        return any(one.received is not None and not one.is_old(now) for one in told)

    def _on_answer(self, turn: int) -> None:
        """The answer to what an operator sent in that turn."""
        if self._stopping.is_behind(turn):
            self._thread.submit(self._stop_behind)

    async def _stop_behind(self) -> None:
        """Something that was sent before a STOP was answered behind it, a release perhaps."""
        outcome = await self._stopping.send()
        self._tell(f"STOP, sent again behind an earlier command: {outcome.text}")

    def _look(self) -> None:
        changed = self._graph.look()
        self._tell_of_consoles()
        self._telemetry.look()
        for said in self._others.unexplained(self._clock.monotonic()):
            self._say("PEER", said)
        faults = {**self._telemetry.faults, **self._offers.misfits()}
        for kind in self.description.goals:
            if kind.action in self._graph.several:
                said = check.several(kind.action, self._graph.several[kind.action])
                faults[kind.action] = said
        if changed or faults != self._faults or self._unseen:
            self._faults = faults
            self._mark()
        self._parameters.follow(self._graph.count, self._graph.services)

    def _watch(self) -> None:
        if not self._goals.running:
            self._watcher.cancel()
            if self._outlived:
                self._outlived = ()
                self._mark()
            return
        now = self._clock.monotonic()
        self._goals.way_is(self._way)
        self._goals.check(now, self._telemetry.motion)
        stopped = self._stopping.obeyed_since
        if stopped is not None:
            before, self._outlived = self._outlived, self._goals.cancel_older(stopped)
            if self._outlived != before:
                self._mark()

    def _goal_changed(self) -> None:
        if self._watcher.is_canceled():
            self._watcher.reset()
        self._flush()

    def _on_telemetry(self, topic: str, news: bool) -> None:
        self._graph.heard_topic(topic, self._clock.monotonic())
        motion = self.description.motion
        if motion is not None and topic == motion.topic:
            self._goals.heard()
            if topic not in self._graph.publishers:  # else the readings of several come mixed
                self._others.motion(self._telemetry.motion, self._clock.monotonic())
            alone = self.description.stop is None or (
                self.description.stop.service not in self._graph.several
            )  # of several robots one says nothing about the others
            if alone and self._telemetry.motion.stopped and self._stopping.open is not None:
                if self._stopping.is_to_be_repeated:
                    self._tell("STOP, sent again: the robot says that it is stopped")
                self._stopping.over()
        self._unseen = True
        if news:
            self._mark()

    def _tell_of_consoles(self) -> None:
        """Coming and going; those that are there at the start are in the header."""
        now = set(self._graph.consoles)
        if self._consoles is not None:
            for name in sorted(now - self._consoles):
                self._say("PEER", f"console {name} came")
            for name in sorted(self._consoles - now):
                self._say("PEER", f"console {name} left")
        self._consoles = now

    def _on_log(self, message: Log) -> None:
        who = author(logger_node(message.name))
        if who:
            if who in self._graph.consoles:
                self._others.heard(message.msg, self._clock.monotonic())
                self._add_event(Event(self._clock.now(), "PEER", who, message.msg))
            return
        level = _LEVELS.get(message.level if isinstance(message.level, int) else 0, "INFO")
        node = logger_node(message.name)
        if not self._graph.is_ours(node):
            return  # another robot's
        for kind in self.description.goals:
            servers = self._graph.servers.get(kind.action, ())
            if kind.refusals and node in servers and message.msg.startswith(kind.refusals):
                self._goals.refused(message.msg.removeprefix(kind.refusals))
        self._graph.heard_log(node, self._clock.monotonic())
        # by this clock and not the stamp: the robot's may be another, and the list is in order
        self._add_event(Event(self._clock.now(), level, message.name, message.msg))

    def _on_change(self, node: str, name: str, old: Any, new: Any) -> None:
        self._others.parameter(node, name, old, new, self._clock.monotonic())

    def _warn(self, text: str) -> None:
        self._say("WARN", text)

    def _on_error(self, error: Exception) -> None:
        self._say("ERROR", in_one_line(error))

    def _tell(self, text: str, command: str = "") -> None:
        """What this console did, for other consoles as well."""
        text = harmless(text)
        self._node.get_logger().info(text)
        self._others.heard(text, self._clock.monotonic())
        self._add_event(Event(self._clock.now(), "YOU", "console", text, command))

    def _say(self, level: str, text: str) -> None:
        self._add_event(Event(self._clock.now(), level, "console", text))

    def _add_event(self, event: Event) -> None:
        self._happened(self._log.add(event))
        self._mark()

    def _mark(self) -> None:
        """Something changed: a snapshot goes up within FLUSH_PERIOD."""
        if not self._dirty:
            self._dirty = True
            self._flusher.reset()

    def _flush(self) -> None:
        """A snapshot goes up now."""
        self._dirty = self._unseen = False
        self._flusher.cancel()
        self._mailbox.put(
            Snapshot(
                robot=self.description,
                battery=self._telemetry.battery,
                motion=self._telemetry.motion,
                gauges=self._telemetry.gauges,
                goal=self._goals.goal,
                running=self._goals.running,
                history=tuple(self._goals.history),
                parameters=self._parameters.all(),
                nodes=self._graph.states(),
                offered=self._graph.offered,
                events=self._log.all(),
                charge=self._telemetry.charge,
                open_stop=self._stopping.open,
                outlived=self._outlived,
                namespace=self._graph.namespace,
                faults=self._faults,
                publishers=self._graph.publishers,
                twice=self._graph.twice,
                several=self._graph.several,
                elsewhere=self._graph.elsewhere,
                consoles=self._graph.consoles,
                forms=self._offers.forms,
                actions=self._graph.actions,
                services=self._graph.served,
            )
        )
