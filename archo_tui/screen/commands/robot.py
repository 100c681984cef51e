"""The commands that drive the robot: verbs with keys."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from archo_tui.base.errors import ArchoError
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state.goal import Phase
from archo_tui.screen.commands.base import (
    EVERYWHERE,
    Command,
    Desk,
    VerbCommand,
    Work,
    asking_first,
)
from archo_tui.screen.dialog import AskText, Dialog
from archo_tui.screen.message_form import MessageForm
from archo_tui.verbs import goals, services
from archo_tui.verbs.verb import Verb


class GoKey(Command):
    """The command for the first goal of the robot file: it focuses that goal's form on the screen.

    Also while no goal can be sent, but not on a console that only watches.
    """

    id, key, footer, verbs = "go", "g", "Go", ("go",)
    runs_disabled = True  # The next keys are meant for the field, not for the panels.

    def __init__(self, verb: goals.Go | None) -> None:
        self._verb = verb
        kind = None if verb is None else verb.kind
        labels = [] if kind is None else [given.label or p for p, given in kind.form.items()]
        title = "Send a goal" if kind is None else kind.title
        what = labels[0].lower() if len(labels) == 1 else ", ".join(labels)
        does = "enter sends the robot there" if kind and kind.noun else "enter sends it"
        self.help = f"{title}: type the {what}; {does}" if labels else title

    def disabled_reason(self, desk: Desk) -> str:
        return "" if self._verb is None else self._verb.refusal(desk.station)

    def run(self, desk: Desk) -> None:
        desk.main.focus_panel(3)


class FormGoalKey(VerbCommand):
    """A command for another goal of the robot file, which opens a form if it has values."""

    waits_for_answer = True

    def __init__(self, verb: goals.Go) -> None:
        super().__init__(verb)
        self._go = verb
        self.key, self.from_file = verb.kind.key, verb.kind.where

    def run(self, desk: Desk) -> Work | None:
        kind = self._go.kind
        if not kind.form:
            return desk.run_verb(self._go, {goals.GOALS: [{}]})
        message_fields = desk.view.snapshot.forms[kind.id]
        typed = desk.typed.setdefault(kind.id, {})

        async def send(values: Mapping[str, Any]) -> Outcome:
            try:
                given = await self._go.prepare(desk.station, {goals.GOALS: [values]})
            except ValueError as error:
                return Outcome(Code.MISUSE, str(error))
            outcome = await self._go.run(desk.station, given)
            desk.update_screen()  # The goal may wait in the queue.
            return outcome

        form = desk.view.snapshot.form(kind)
        sends = asking_first(desk, partial(self._go.question, desk.station), send)
        desk.open(MessageForm(kind.title, message_fields, sends, typed, form))
        return None


class CancelKey(VerbCommand):
    """The command of ctrl+c, which cancels the running goal; another client's after a question.

    If none is running, it ends the wait of a dialog for an answer, else it copies the selection,
    else it says which key quits. Held down, it only cancels an own goal, once.
    """

    key, footer = "ctrl+c", "Cancel"
    where = EVERYWHERE
    resend_after = 0.5

    def __init__(self, verb: Verb) -> None:
        super().__init__(verb)
        self.help = "Cancel the running goal; if none is running, copy the selection"

    def run(self, desk: Desk) -> Work | None:
        running = desk.station.running_goal
        is_ours = running is not None and running.mine and running.phase != Phase.CANCELLING
        if desk.repeated and not is_ours:
            return None
        if running is None and desk.station.robot.publications.active:
            return desk.run_verb(self.verb, {goals.RUNNING: None})
        if running is None:
            dialog = desk.screen
            if isinstance(dialog, Dialog) and dialog.is_asking:
                dialog.stop_waiting()
                return None
            if not desk.copy_selection():
                keys = f"{desk.view.key('quit')} (or {desk.view.key('quit_everywhere')})"
                desk.show_message(f"No goal is running. Press {keys} to quit.")
            return None
        return desk.run_verb(self.verb, {goals.RUNNING: running})


class StopKey(VerbCommand):
    key = "ctrl+x"
    where = EVERYWHERE
    always_tried = True  # The robot may have been found just now.
    resend_after = 0.5

    def __init__(self, verb: Verb) -> None:
        super().__init__(verb)
        self.footer = "STOP" if verb.service else "Cancel all"

    def run(self, desk: Desk) -> Work | None:
        stops, snapshot = desk.station.robot.stops, desk.view.snapshot
        is_stopped = snapshot.is_at_rest and snapshot.says_stopped and not snapshot.stop_not_obeyed
        if desk.repeated and is_stopped and not stops.superseded:
            return None  # The key is held, and the robot has stopped.
        return super().run(desk)


class GiveKey(VerbCommand):
    """The command for a service of the robot file, or for the two services of a toggle.

    A toggle calls the opposite of the state that the robot reports, or asks which to call.
    """

    waits_for_answer = True

    def __init__(self, on: services.Give, off: services.Give | None) -> None:
        super().__init__(on)
        given = on.given
        self._on, self._off = on, off
        if off is not None:
            self.verbs = (on.id, off.id)
            self.help = f"{given.help or given.title}{services.ASKS[given.ask]}"
        self.key, self.from_file = given.key, given.where
        self.footer = "" if given.toggles_reading_of("battery") else given.title.split()[0]

    def run(self, desk: Desk) -> Work | None:
        if self._off is None:
            return desk.run_verb(self._on, {})
        (name,) = self._on.given.toggle.values()
        is_on = _reported_state(desk, name)
        if is_on is None:
            self._ask_which_way(desk, name, self._off)
            return None
        return desk.run_verb(self._off if is_on else self._on, {})

    def _ask_which_way(self, desk: Desk, reading: str, off: services.Give) -> None:
        title = self._on.given.title
        why = "" if reading == "ask" else f"The robot does not report {reading}: "
        question = f"{why}{title} or {off.title}?"
        answers = {verb.title: partial(desk.run_verb, verb, {}) for verb in (self._on, off)}
        desk.confirm(title, question, "Leave it", answers)


def _reported_state(desk: Desk, name: str) -> bool | None:
    """Return the state that a toggle inverts; None if it is not reported, or for `ask`."""
    if name == "ask":
        return None
    topic, _, reading = name.partition(".")
    found: bool | None = getattr(getattr(desk.view.snapshot, topic), reading)
    return found


class SaveUnderName(VerbCommand):
    """The command that asks for a name, and runs a verb with it."""

    def __init__(self, verb: Verb, *others: str) -> None:
        """Create it; `others` are the verbs that use what it saves."""
        super().__init__(verb)
        self.verbs = (verb.id, *others)

    def run(self, desk: Desk) -> None:
        async def save(name: str) -> str:
            station = desk.station
            try:
                values = await self.verb.prepare(station, self.verb.values([name]))
                outcome = await self.verb.run(station, values)
            except (ArchoError, ValueError) as error:
                return str(error)
            desk.show_message(outcome.text)
            return ""

        desk.open(AskText("name", self.verb.title, f"{self.verb.help}:", "", save))
