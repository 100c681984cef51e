"""Commands that send any goal and call any service on the graph, in the robot file or not."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from archo_tui.base.daemon_threads import in_daemon
from archo_tui.base.errors import ArchoError
from archo_tui.robot.messages.types import TypedField
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot_file.check import not_installed
from archo_tui.robot_file.model import FormField
from archo_tui.robot_file.propose import SeveralRobots
from archo_tui.screen.choose import Choice, Choose
from archo_tui.screen.commands.base import (
    Command,
    Desk,
    VerbCommand,
    Work,
    asking_first,
    file_writer,
)
from archo_tui.screen.commands.robot import FormGoalKey
from archo_tui.screen.dialog import AskPath
from archo_tui.screen.message_form import MessageForm
from archo_tui.verbs.goals import GOALS, KIND, Go, any_kind, kind_of
from archo_tui.verbs.names import topics_of, type_of
from archo_tui.verbs.services import refuse_transition, verbs_by_service
from archo_tui.verbs.stop import StopNow
from archo_tui.verbs.topics import (
    LISTENING,
    MAX_RATE,
    RATE,
    TIMES,
    Publish,
    frequency,
    robot_file_text,
)
from archo_tui.verbs.verb import Question, Verb

_LOOK_PERIOD = 0.02  # Seconds between two looks whether a publication has begun.


class _GenericCommand(VerbCommand):
    """The base of commands that list names on the graph, and open a form for the chosen one."""

    more_fields: Sequence[TypedField] = ()  # Behind those of the message.
    form: Mapping[str, FormField] = {}  # Labels, units and limits of them.

    def types_by_name(self, desk: Desk) -> Mapping[str, tuple[str, ...]]:
        """Return the actions or services on the graph: the types of each by its full name."""
        raise NotImplementedError

    def run(self, desk: Desk) -> None:
        names = sorted(self.types_by_name(desk))
        choices = [choice for name in names for choice in self.choices(desk, name)]
        desk.open(Choose(self.help, choices))

    def choices(self, desk: Desk, name: str) -> list[Choice]:
        """Return the rows for one action or service: by default one, which opens its form."""
        types = ", ".join(self.types_by_name(desk)[name])
        return [Choice(name, partial(self.open_form, desk, name), types)]

    async def open_form(self, desk: Desk, name: str) -> None:
        """Open the form for a goal or a request, which is sent by `self.send`, or show why not."""
        try:
            kind = type_of("one", name, self.types_by_name(desk))
        except ValueError as error:
            desk.show_message(str(error))
            return
        with desk.opening():  # Message classes are read from disk, on another thread.
            message_fields = await in_daemon(desk.station.robot.form, kind)
        if message_fields is None:
            desk.show_message(not_installed(name, kind))
            return
        typed = desk.typed.setdefault(name, {})
        send = partial(self.send, desk, name, kind)
        asking = asking_first(desk, partial(self.question, desk, name, kind), send)
        fields = (*message_fields, *self.more_fields)
        desk.open(MessageForm(f"{name}  {kind}", fields, asking, typed, self.form))

    def question(
        self, desk: Desk, name: str, type_name: str, values: Mapping[str, Any]
    ) -> Question | None:
        """Return the question before what is sent; None for none."""
        return self.verb.question(desk.station, values)

    async def send(
        self, desk: Desk, name: str, type_name: str, values: Mapping[str, Any]
    ) -> Outcome:
        """Send a goal or a service request, and return the outcome; a subclass must define it."""
        raise NotImplementedError


class AnyGoal(_GenericCommand):
    """The command that sends a goal to any action on the graph.

    An action of the robot file opens that file's form.
    """

    key = "G"

    async def open_form(self, desk: Desk, name: str) -> None:
        kind = kind_of(desk.view.snapshot, name)
        if kind is None:
            await super().open_form(desk, name)
            return
        go = next(v for v in desk.verbs.values() if isinstance(v, Go) and v.kind == kind)
        work = FormGoalKey(go).run(desk)  # The robot file has a form of its own.
        if work is not None:
            await work

    def types_by_name(self, desk: Desk) -> Mapping[str, tuple[str, ...]]:
        return desk.view.snapshot.actions

    async def send(
        self, desk: Desk, name: str, type_name: str, values: Mapping[str, Any]
    ) -> Outcome:
        given = {KIND: any_kind(name, type_name), GOALS: [values]}
        outcome = await self.verb.run(desk.station, given)
        desk.update_screen()  # The goal may wait in the queue.
        return outcome


class AnyTopic(_GenericCommand):
    """The command that publishes to any topic on the graph, once or until it is ended."""

    more_fields = (TypedField(RATE, "double", 1.0), TypedField(TIMES, "int32", 1))
    form = {
        RATE: FormField(label="Rate", unit="Hz", low=0.01, high=MAX_RATE),
        TIMES: FormField(label="Times (0: until cancelled)", low=0),
    }

    def __init__(self, verb: Publish) -> None:
        super().__init__(verb)
        self._running: set[asyncio.Future[Outcome]] = set()  # The loop holds tasks weakly.

    def disabled_reason(self, desk: Desk) -> str:
        no_topic = "" if self.types_by_name(desk) else "no topic is on the graph"
        return super().disabled_reason(desk) or no_topic

    def types_by_name(self, desk: Desk) -> Mapping[str, tuple[str, ...]]:
        return {found.name: found.types for found in topics_of(desk.view.snapshot)}

    def question(
        self, desk: Desk, name: str, type_name: str, values: Mapping[str, Any]
    ) -> Question | None:
        moves = desk.view.snapshot.moves_by(name)
        try:
            given = {**_publish_values(name, values), "type": type_name, "moves": moves}
        except ValueError:  # `send` says why.
            return None
        return self.verb.question(desk.station, given)

    async def send(
        self, desk: Desk, name: str, type_name: str, values: Mapping[str, Any]
    ) -> Outcome:
        """Begin to publish, and return once it has begun: the form closes, and it goes on."""
        station = desk.station
        try:
            prepared = await self.verb.prepare(station, _publish_values(name, values))
        except ValueError as error:
            return Outcome(Code.MISUSE, str(error))
        except ArchoError as error:
            return Outcome(Code.REFUSED, str(error))
        before = station.robot.publications.active
        publishing = asyncio.ensure_future(self.verb.run(station, prepared))
        self._running.add(publishing)
        publishing.add_done_callback(self._running.discard)
        active = station.robot.publications
        while not publishing.done():
            if any(each.count for each in active.active if each not in before):
                break
            await station.clock.sleep(_LOOK_PERIOD)
        desk.update_screen()
        if not publishing.done():
            outcome = Outcome(Code.ACCEPTED, "publishing; ctrl+c ends it")
        else:
            outcome = publishing.result()
        if outcome.ok:
            desk.show_message(outcome.text, name)
        return outcome


def _publish_values(name: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of `pub` for those of its form, where no times are without end."""
    fields = {path: value for path, value in values.items() if path not in (RATE, TIMES)}
    rate, times = frequency(values.get(RATE, 1.0), values.get(TIMES, 1) or None)
    return {"topic": name, "field=value": [], "rate": rate, "times": times, "fields": fields}


class AnyService(_GenericCommand):
    """The command that calls any service on the graph."""

    key = "C"

    def choices(self, desk: Desk, name: str) -> list[Choice]:
        """Return a row for each verb that calls the service; without any, one that opens a form."""
        verbs = verbs_by_service(desk.verbs, desk.view.snapshot).get(name, [])
        return [
            Choice(name, partial(self._run_verb, desk, verb), verb.title, words=verb.id)
            for verb in verbs
        ] or super().choices(desk, name)

    async def open_form(self, desk: Desk, name: str) -> None:
        try:
            for kind in self.types_by_name(desk).get(name, ()):
                refuse_transition(name, kind)
        except ValueError as error:
            desk.show_message(str(error))
            return
        await super().open_form(desk, name)

    @staticmethod
    def _run_verb(desk: Desk, verb: Verb) -> Work | None:
        """Run a verb of the robot file, after its question, or notify why not; STOP as its key."""
        if isinstance(verb, StopNow):
            desk.action_command(verb.id)
            return None
        refusal = verb.refusal(desk.station)
        if refusal:
            desk.show_message(refusal)
            return None
        return desk.run_verb(verb, {})

    def types_by_name(self, desk: Desk) -> Mapping[str, tuple[str, ...]]:
        return desk.view.snapshot.services

    async def send(
        self, desk: Desk, name: str, type_name: str, values: Mapping[str, Any]
    ) -> Outcome:
        given = {"service": name, "type": type_name, "fields": values}
        outcome = await self.verb.run(desk.station, given)
        if outcome.ok:
            desk.show_message(outcome.text, name)
        return outcome


class DescribeRobot(Command):
    """The command that writes a robot file for what is on the graph."""

    id = "describe_robot"
    help = "Describe this robot: write a robot file for what is on the graph"

    def run(self, desk: Desk) -> None:
        async def text() -> str:
            try:
                return await robot_file_text(desk.station)
            except SeveralRobots as error:
                raise ArchoError(f"{error}: start with --namespace for one of them") from None
            except TimeoutError:
                raise ArchoError("the console's own node does not answer") from None

        write = file_writer(desk, text, "describe this robot")
        listens = f"Robot file (listens for {LISTENING:g} s first)"
        desk.open(AskPath("Describe this robot", listens, "robot.yaml", write, writes=True))
