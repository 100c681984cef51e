"""Verbs of the robot, with their keys."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from archo_tui.commands.base import EVERYWHERE, Command, Console, Speak, Work
from archo_tui.robot.outcome import Code, Outcome
from archo_tui.robot.state import Phase
from archo_tui.screens.leaving import Leaving
from archo_tui.verbs import goals, services
from archo_tui.verbs.base import Verb


class Go(Command):
    """The first goal of the robot file, whose form is on the screen."""

    id, key, footer, verbs = "go", "g", "Go", ("go",)
    runs_blocked = True  # what is typed next is meant for the field, not for the panels

    def __init__(self, verb: goals.Go | None) -> None:
        """None: the robot file has no goals."""
        self._verb = verb
        kind = None if verb is None else verb.kind
        labels = [] if kind is None else [given.label or p for p, given in kind.form.items()]
        title = "Send a goal" if kind is None else kind.title
        what = labels[0].lower() if len(labels) == 1 else ", ".join(labels)
        does = "enter sends the robot there" if kind and kind.noun else "enter sends it"
        self.help = f"{title}: type the {what}; {does}" if labels else title

    def blocked(self, console: Console) -> str:
        return "" if self._verb is None else self._verb.refusal(console.station)

    def run(self, console: Console) -> None:
        console.main.focus_panel(3)


class SendGoal(Speak):
    """A goal of the robot file beside the first one."""

    once = True

    def __init__(self, verb: goals.Go) -> None:
        super().__init__(verb)
        self._go = verb
        self.key, self.from_file = verb.kind.key, verb.kind.where

    def run(self, console: Console) -> Work | None:
        from archo_tui.screens.message_form import MessageForm

        kind = self._go.kind
        if not kind.form:
            return console.speak(self._go, {goals.GOALS: [{}]})
        leaves, typed = console.view.snapshot.forms[kind.id], console.typed.setdefault(kind.id, {})

        async def send(values: Mapping[str, Any]) -> Outcome:
            try:
                given = await self._go.prepare(console.station, {goals.GOALS: [values]})
            except ValueError as error:
                return Outcome(Code.MISUSE, str(error))
            outcome = await self._go.run(console.station, given)
            console.look()  # it may wait in the queue
            return outcome

        console.open(MessageForm(kind.title, leaves, send, typed, kind.form))
        return None


class Cancel(Speak):
    key, footer = "ctrl+c", "Cancel"
    where = EVERYWHERE
    every = 0.5

    def __init__(self, verb: Verb) -> None:
        super().__init__(verb)
        self.help = "Cancel the running goal; if none is running, copy the selection"

    def run(self, console: Console) -> Work | None:
        running = console.station.running_goal
        is_ours = running is not None and running.mine and running.phase != Phase.CANCELLING
        if console.repeated and not is_ours:
            return None
        if running is None:
            dialog = console.screen
            if isinstance(dialog, Leaving) and dialog.is_asking:
                dialog.stop_waiting()
                return None
            if not console.copy_selection():
                keys = f"{console.view.key('quit')} (or {console.view.key('quit_everywhere')})"
                console.say(f"No goal is running. Press {keys} to quit.")
            return None
        return console.speak(self.verb, {goals.RUNNING: running})


class CancelAll(Speak):
    def __init__(self, verb: Verb) -> None:
        super().__init__(verb)
        self.id = "cancel_all"
        self.help = "Cancel every goal of the robot's actions, whoever sent it (asks first)"

    def run(self, console: Console) -> Work | None:
        return console.speak(self.verb, {"--all": True})


class StopNow(Speak):
    key = "ctrl+x"
    where = EVERYWHERE
    insists = True  # never dropped: the robot may only just have been found
    every = 0.5

    def __init__(self, verb: Verb) -> None:
        super().__init__(verb)
        self.footer = "STOP" if verb.service else "Cancel all"

    def run(self, console: Console) -> Work | None:
        stops = console.station.robot.stops
        if console.repeated and console.view.snapshot.says_stopped and not stops.superseded:
            return None  # the key is held, and the robot has stopped
        return super().run(console)


class Release(Speak):
    key = "R"
    once = True


class Continue(Speak):
    key = "n"


class Skip(Speak):
    key = "k"


class Give(Speak):
    """A command of the robot file; a toggle inverts what the robot says of itself.

    Where the robot does not say it, a person says which way: a guess could be the wrong one.
    """

    once = True

    def __init__(self, on: services.Give, off: services.Give | None) -> None:
        super().__init__(on)
        given = on.given
        self._on, self._off = on, off
        if off is not None:
            self.verbs = (on.id, off.id)
            self.help = f"{given.help or given.title}{services.ASKS[given.ask]}"
        self.key, self.from_file = given.key, given.where
        self.footer = "" if given.toggles_reading_of("battery") else given.title.split()[0]

    def run(self, console: Console) -> Work | None:
        if self._off is None:
            return console.speak(self._on, {})
        (name,) = self._on.given.toggle.values()
        is_on = _reading(console, name)
        if is_on is None:
            self._ask(console, name, self._off)
            return None
        return console.speak(self._off if is_on else self._on, {})

    def _ask(self, console: Console, reading: str, off: services.Give) -> None:
        title = self._on.given.title
        question = f"The robot does not report {reading}: {title} or {off.title}?"
        answers = {verb.title: partial(console.speak, verb, {}) for verb in (self._on, off)}
        console.confirm(title, question, "Leave it", answers)


def _reading(console: Console, name: str) -> bool | None:
    """Return what a toggle inverts, None when nobody reports it.

    Args:
        console: Shows what was heard last.
        name: `battery.charging`, `motion.moving` or `motion.stopped`.
    """
    topic, _, reading = name.partition(".")
    found: bool | None = getattr(getattr(console.view.snapshot, topic), reading)
    return found
