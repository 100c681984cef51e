"""Commands for what no robot file names: any goal, any service."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from archo_tui.commands.base import Command, Console, write_file
from archo_tui.commands.robot import SendGoal
from archo_tui.daemon_threads import in_daemon
from archo_tui.robot.state import Outcome, in_namespace
from archo_tui.robots.check import missing
from archo_tui.robots.model import GoalKind, Input, Service
from archo_tui.robots.save import dump
from archo_tui.robots.words import free
from archo_tui.screens.ask_path import AskPath
from archo_tui.screens.choose import Choose
from archo_tui.screens.message_form import MessageForm, Send


class _AnyOf(Command):
    """Lists what is on the graph, then makes a form of its type."""

    what = ""
    acts = True

    def found(self, console: Console) -> Mapping[str, tuple[str, ...]]:
        """Names with their types."""
        raise NotImplementedError

    def blocked(self, console: Console) -> str:
        return "" if self.found(console) else f"no {self.what} is on the graph"

    def run(self, console: Console) -> None:
        found = self.found(console)
        rows = [(name, ", ".join(found[name])) for name in sorted(found)]
        console.open(Choose(self.help, rows, lambda name: self._form(console, name)))

    async def _form(self, console: Console, name: str) -> None:
        kinds = self.found(console).get(name, ())
        if len(kinds) != 1:
            console.say(f"{name} has several types: {', '.join(kinds)}")
            return
        # reads files: not on this thread
        leaves = await in_daemon(console.station.robot.form, kinds[0])
        if leaves is None:
            console.say(missing(name, kinds[0]))
            return
        typed = console.typed.setdefault(name, {})
        send = self.sender(console, name, kinds[0])
        console.open(MessageForm(f"{name}  {kinds[0]}", leaves, send, typed))

    def sender(self, console: Console, name: str, kind: str) -> Send:
        """What is done with the values."""
        raise NotImplementedError


class AnyGoal(_AnyOf):
    id, key = "any_goal", "G"
    help = "Send a goal to any action on the graph"
    what = "action"

    async def _form(self, console: Console, name: str) -> None:
        snapshot = console.view.snapshot
        for kind in snapshot.robot.goals:  # the robot file has a form of its own
            if in_namespace(snapshot.namespace, kind.action.lstrip("/")) == name:
                work = SendGoal(kind).run(console)
                if work is not None:
                    await work
                return
        await super()._form(console, name)

    def found(self, console: Console) -> Mapping[str, tuple[str, ...]]:
        return console.view.snapshot.actions

    def sender(self, console: Console, name: str, kind: str) -> Send:
        short = name.rpartition("/")[2]
        goal = GoalKind(id=_id(console, name), title=short, action=name, type=kind)

        async def send(values: Mapping[str, Any]) -> Outcome:
            outcome = await console.station.robot.send(goal, values)
            if outcome.ok:
                known = [old for old in console.used.goals if old.action != name]
                used = replace(goal, form={path: Input() for path in _paths(values)})
                console.used = replace(console.used, goals=(*known, used))
            return outcome

        return send


class AnyService(_AnyOf):
    id, key = "any_service", "C"
    help = "Call any service on the graph"
    what = "service"

    def found(self, console: Console) -> Mapping[str, tuple[str, ...]]:
        return console.view.snapshot.services

    def sender(self, console: Console, name: str, kind: str) -> Send:
        async def call(values: Mapping[str, Any]) -> Outcome:
            outcome = await console.station.robot.call(name, kind, values)
            if outcome.ok:
                console.say(outcome.text, name)
                short = name.rpartition("/")[2]
                known = [old for old in console.used.commands if old.service != name]
                if not values:  # one with fields cannot be a command of a robot file
                    used = Service(id=_id(console, name), title=short, service=name)
                    console.used = replace(console.used, commands=(*known, used))
            return outcome

        return call


def _id(console: Console, name: str) -> str:
    """What a kept action or service is called, beside the console's and the file's own words."""
    kept = console.used
    used = {goal.id for goal in kept.goals if goal.action != name}
    for command in kept.commands:
        if command.service != name:
            used |= {command.id, command.off_word}
    return free(name.rpartition("/")[2].lower().strip("_") or "other", used)


def _paths(values: Mapping[str, Any], before: str = "") -> Iterator[str]:
    """The dotted paths of what was typed, of nested messages too."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _paths(value, f"{before}{name}.")
        else:
            yield f"{before}{name}"


class KeepRobot(Command):
    id = "keep_robot"
    help = "Keep as robot file: the robot's own, and the goals and services used without it"

    def run(self, console: Console) -> None:
        write = write_file(console, dump(console.used), "keep as robot file")
        console.open(AskPath("Keep as robot file", "Robot file", "robot.yaml", write))
