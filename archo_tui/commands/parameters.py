"""Commands of the parameters' panel."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

from archo_tui import parameter_file
from archo_tui.commands.base import IN_PANEL, PARAMETERS, Command
from archo_tui.errors import ArchoError
from archo_tui.robot.values import text_of
from archo_tui.screens.ask_path import AskPath
from archo_tui.screens.confirm import Confirm

if TYPE_CHECKING:
    from archo_tui.app import ArchoApp

_DEFAULT_FILE = "archo_params.yaml"


class _InParameters(Command):
    where, panel = IN_PANEL, PARAMETERS

    def blocked(self, app: ArchoApp) -> str:
        return "" if app.view.snapshot.parameters else "no node has told its parameters yet"


class Edit(_InParameters):
    """Edit the selected parameter."""

    id, key = "edit", "enter"

    def run(self, app: ArchoApp) -> None:
        app.main.parameters.edit()


class Filter(_InParameters):
    """Show only parameters with these letters in their node, name or value."""

    id, key = "filter", "slash"

    def run(self, app: ArchoApp) -> None:
        app.main.parameters.search.open()


class Undo(_InParameters):
    """Undo your last change of a parameter."""

    id, key = "undo", "u"

    def blocked(self, app: ArchoApp) -> str:
        edit = app.edits.last
        if edit is None:
            return "nothing to undo"
        there = any(p.node == edit.node for p in app.view.snapshot.parameters)
        return "" if there else f"{edit.node} is gone"

    async def run(self, app: ArchoApp) -> None:
        edit = app.edits.last
        assert edit is not None
        now = {p.name: p.value for p in app.view.snapshot.parameters if p.node == edit.node}
        others = [name for name, value in edit.after.items() if now.get(name) != value]
        if others:
            said = ", ".join(f"{name} is {text_of(now.get(name))} by now" for name in others)
            back = ", ".join(f"{name} {text_of(edit.before[name])}" for name in others)
            question = Confirm("Undo", f"{said}. Set it back to {back}?", "Leave it", "Set back")
            if await app.ask(question) != "Set back":
                return
        app.tell(await app.edits.undo(app.robot, edit))


class Save(_InParameters):
    """Save all parameters to a ROS parameter file."""

    id, key = "save", "ctrl+s"

    def run(self, app: ArchoApp) -> None:
        text, left_out = parameter_file.dump(app.view.snapshot.parameters)
        warned: set[Path] = set()  # files that exist, which was said

        async def save(path: Path) -> str:
            if path not in warned and await asyncio.to_thread(path.exists):
                warned.add(path)
                return f"{path} exists: enter again replaces it"
            try:
                await asyncio.to_thread(parameter_file.write, path, text)
            except OSError as error:
                return f"{path}: cannot be written: {error.strerror}"
            app.robot.note("YOU", "console", f"save parameters: saved to {path}")
            for line in left_out:
                app.robot.note("WARN", "console", f"not saved, files cannot hold it: {line}")
            app.notify(f"Saved to {path}.", markup=False)
            return ""

        app.push_screen(AskPath("Save parameters", "ROS parameter file", _DEFAULT_FILE, save))


class Load(_InParameters):
    """Load a ROS parameter file; shows first what would change."""

    id, key = "load", "ctrl+o"

    def run(self, app: ArchoApp) -> None:
        async def load(path: Path) -> str:
            try:
                parameters = app.view.snapshot.parameters
                plan = await asyncio.to_thread(parameter_file.plan, path, parameters)
            except ArchoError as error:
                return str(error)
            app.run_worker(self._preview(app, path, plan), group=self.id)
            return ""

        app.push_screen(AskPath("Load parameters", "ROS parameter file", _DEFAULT_FILE, load))

    async def _preview(self, app: ArchoApp, path: Path, plan: parameter_file.Plan) -> None:
        lines = [f"{path}", ""]
        if plan.problems:
            lines += ["Nothing can be changed:", *plan.problems]
        else:
            lines += [
                f"{p.node.lstrip('/')} {p.name}: {text_of(p.value)} -> {text_of(value)}"
                for p, value in plan.changes
            ] or ["Everything is as the file says."]
            lines += [f"left out: {line}" for line in plan.left_out]
        answers = ["Leave"]
        if plan.changes and not plan.problems:
            answers.append(f"Change {len(plan.changes)}")
        if await app.ask(Confirm("Load parameters", "\n".join(lines), *answers)) == answers[0]:
            return
        by_node: dict[str, dict[str, object]] = {}
        for parameter, value in plan.changes:
            by_node.setdefault(parameter.node, {})[parameter.name] = value
        for node, values in by_node.items():
            app.tell(await app.set_parameters(node, values))
