"""Commands that the robot carries out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from archo_tui.commands.base import EVERYWHERE, Command, Console, Work
from archo_tui.goal_text import way
from archo_tui.robot.state import RUNNING, Outcome, Phase
from archo_tui.robots.model import GoalKind, Service, Stop
from archo_tui.screens.message_form import MessageForm

# a cancel was asked for, or there is nothing to cancel any more
_CANCELLED = {Phase.CANCELLING} | (set(Phase) - set(RUNNING))


class Go(Command):
    acts = True
    id, key, footer = "go", "g", "Go"
    runs_blocked = True  # what is typed next is meant for the field, not for the panels

    def __init__(self, kind: GoalKind | None) -> None:
        labels = [] if kind is None else [given.label or p for p, given in kind.form.items()]
        title = "Send a goal" if kind is None else kind.title
        what = labels[0].lower() if len(labels) == 1 else ", ".join(labels)
        does = "enter sends the robot there" if kind and kind.noun else "enter sends it"
        self.help = f"{title}: type the {what}; {does}" if labels else title
        self.service = "" if kind is None else kind.action

    def run(self, console: Console) -> None:
        console.main.focus_panel(3)


class SendGoal(Command):
    """A goal of the robot file beside the first one."""

    acts = True

    once = True

    def __init__(self, kind: GoalKind) -> None:
        self._kind = kind
        self.id, self.key, self.from_file = kind.id, kind.key, kind.where
        self.help = kind.title
        self.service = kind.action

    def run(self, console: Console) -> Work | None:
        kind = self._kind

        async def send(values: Mapping[str, Any]) -> Outcome:
            return await console.station.robot.send(kind, values)

        async def now() -> None:
            console.tell(await send({}))

        if not kind.form:
            return now()
        leaves, typed = console.view.snapshot.forms[kind.id], console.typed.setdefault(kind.id, {})
        console.open(MessageForm(kind.title, leaves, send, typed, kind.form))
        return None


class Cancel(Command):
    acts = True
    id, key, footer = "cancel", "ctrl+c", "Cancel"
    help = "Cancel the running goal; if none is running, copy the selection"
    where = EVERYWHERE
    every = 0.5

    def run(self, console: Console) -> Work | None:
        goal = console.view.snapshot.goal
        if console.repeated and (goal is None or goal.phase in _CANCELLED or not goal.mine):
            return None
        running = console.view.snapshot.running_goal
        if running is None or running.mine:
            return self._run(console)

        async def cancel() -> None:
            console.tell(await console.station.robot.cancel(another=True))

        question = "Another client sent this goal. Cancel it?"
        console.confirm("Cancel", question, "No", {"Cancel it": cancel})
        return None

    async def _run(self, console: Console) -> None:
        if console.view.snapshot.running_goal is not None:
            console.tell(await console.station.robot.cancel())
        elif not console.copy_selection():
            keys = f"{console.view.key('quit')} (or {console.view.key('quit_everywhere')})"
            console.say(f"No goal is running. Press {keys} to quit.")


class CancelAll(Command):
    acts = True
    id = "cancel_all"
    help = "Cancel every goal of the robot's actions, whoever sent it (asks first)"

    def run(self, console: Console) -> None:
        async def cancel() -> None:
            console.tell(await console.station.robot.cancel_all())

        question = "Cancel every goal of the robot's actions, other clients' too?"
        console.confirm("Cancel every goal", question, "No", {"Cancel all": cancel})


class Continue(Command):
    acts = True
    id, key = "continue_queue", "n"
    help = "Continue the queue of goals that is held"

    def blocked(self, console: Console) -> str:
        return "" if console.view.held else "no queue is held"

    def run(self, console: Console) -> None:
        console.tell(console.station.resume())
        console.look()


class Drop(Command):
    acts = True
    id, key = "drop_target", "k"
    help = "Leave out the next goal of the queue"

    def blocked(self, console: Console) -> str:
        return "" if console.view.waiting else "no goal waits in the queue"

    def run(self, console: Console) -> None:
        console.station.drop()
        console.look()


class StopNow(Command):
    acts = True
    id, key, footer = "stop", "ctrl+x", "STOP"
    help = "STOP: software stop, at once and latched; does not replace the hardware one"
    where = EVERYWHERE
    insists = True  # never dropped: the robot may only just have been found
    every = 0.5

    def __init__(self, stop: Stop | None) -> None:
        self.service = "" if stop is None else stop.service

    def run(self, console: Console) -> Work | None:
        if console.repeated and console.view.snapshot.motion.stopped:
            return None  # the key is held, and the robot has stopped
        return self._run(console)

    async def _run(self, console: Console) -> None:
        console.tell(await console.station.robot.emergency_stop())


class GiveUpStop(Command):
    acts = True
    id = "give_up_stop"
    help = "Give up a STOP that the robot does not confirm; it is sent no more (asks first)"

    def blocked(self, console: Console) -> str:
        stop = console.view.snapshot.open_stop
        return "" if stop is not None else "no STOP is waiting to be confirmed"

    def run(self, console: Console) -> None:
        async def give_up() -> None:
            console.tell(await console.station.robot.give_up_stop())

        question = "The robot has not confirmed the STOP and may be driving. Send it no more?"
        console.confirm("Give up STOP", question, "Keep sending", {"Give up": give_up})


class Release(Command):
    acts = True
    id, key = "release", "R"
    help = "Release the stop (asks first); nothing resumes by itself"
    once = True

    def __init__(self, stop: Stop | None) -> None:
        self.service = "" if stop is None else stop.release

    def blocked(self, console: Console) -> str:
        if not self.service:
            return f"{console.view.snapshot.robot.name} has no service to release a stop"
        stopped = console.view.snapshot.motion.stopped
        return super().blocked(console) or ("" if stopped else "the robot is not stopped")

    def run(self, console: Console) -> None:
        async def release() -> None:
            console.tell(await console.station.robot.release_emergency_stop())

        question = "Release the stop? Moves are allowed again; nothing resumes by itself."
        console.confirm("Release", question, "Stay stopped", {"Release": release})


class Give(Command):
    """A command of the robot file."""

    acts = True

    once = True

    def __init__(self, given: Service) -> None:
        self._given = given
        self.id, self.key, self.service = given.id, given.key, given.service
        self.from_file = given.where
        asks = {"moving": "; asks first while a goal runs", "always": "; asks first"}
        self.help = (given.help or given.title) + asks.get(given.ask, "")
        self._word = given.title.split()[0]
        self.footer = "" if given.is_about("battery") else self._word

    def run(self, console: Console) -> Work | None:
        given, goal = self._given, console.view.snapshot.running_goal

        async def give() -> None:
            on = not any(_reading(console, name) for name in given.toggle.values())
            console.tell(await console.station.robot.command(given, on))

        if given.ask == "never" or (given.ask == "moving" and goal is None):
            return give()
        now = f"The robot is {way(goal)}. " if goal is not None else ""
        question = f"{now}{given.title} now?"
        console.confirm(given.title, question, "Leave it", {self._word: give})
        return None


def _reading(console: Console, name: str) -> bool:
    """What a toggle inverts: `battery.charging`, `motion.moving`, `motion.stopped`."""
    topic, _, reading = name.partition(".")
    return bool(getattr(getattr(console.view.snapshot, topic), reading))
